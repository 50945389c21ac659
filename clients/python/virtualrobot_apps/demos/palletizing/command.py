"""`virtualrobot demo`: starts a kernel, runs the demo in it, and ends it."""

from __future__ import annotations

from pathlib import Path

import click
from virtualrobot.cli.options import FiniteRange, Target, target_options
from virtualrobot.cli.own_kernel import in_kernel

from virtualrobot_apps.demos.bins.command import bins
from virtualrobot_apps.demos.carry.command import carry
from virtualrobot_apps.demos.controllers.command import controllers
from virtualrobot_apps.demos.fetch.command import fetch
from virtualrobot_apps.demos.patrol.command import patrol
from virtualrobot_apps.demos.processes.command import commands
from virtualrobot_apps.demos.twin.command import twin
from virtualrobot_apps.vehicles.command import auv, boebot, hexapod, maze, quadruped, rov, ugv, uvms


@click.group(short_help="Watch two robots palletize.", invoke_without_command=True)
@click.option("--loop", is_flag=True, help="Begin again when both pallets are full.")
@click.option("--headless", is_flag=True, help="Open no viewer.")
@click.option("--speed", type=FiniteRange(0.01, 100.0), help="Simulated seconds for each second of the wall clock.")
@click.option(
    "--record",
    "film",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Film it, .mp4 or .gif: 25 pictures a second of simulation time.",
)
@click.option(
    "--data",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Keep the cell in a folder, and go on there the next time.",
)
@target_options
@click.pass_context
def demo(
    context: click.Context,
    target: Target,
    loop: bool,
    headless: bool,
    speed: float | None,
    film: Path | None,
    data: Path | None,
) -> None:
    """Watch an iiwa and a Panda palletize the boxes of a conveyor.

    Starts a kernel of its own and ends it; with --address the demo replaces the world of a kernel that runs already.
    """
    if context.invoked_subcommand is not None:
        context.obj = target
        return
    from virtualrobot_apps.demos.palletizing import palletize as app
    from virtualrobot_apps.demos.palletizing import resuming

    if data is not None and target.address is not None:
        raise click.UsageError("--data is for a kernel of the demo's own, --address for one that runs already")
    options = () if data is None else ("--data", str(data))
    with in_kernel(target, headless, speed, *options) as client:
        begun = None if data is None else resuming.begun(client)
        app.main(client, loop=loop, headless=headless, film=film, begun=begun)


demo.add_command(controllers)
demo.add_command(twin)
demo.add_command(auv)
demo.add_command(bins)
demo.add_command(boebot)
demo.add_command(carry)
demo.add_command(fetch)
demo.add_command(maze)
demo.add_command(ugv)
demo.add_command(hexapod)
demo.add_command(patrol)
demo.add_command(quadruped)
demo.add_command(rov)
demo.add_command(uvms)
for one in commands():
    demo.add_command(one)
