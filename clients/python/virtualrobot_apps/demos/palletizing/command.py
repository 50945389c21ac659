"""`virtualrobot demo`: starts a kernel, runs a demo in it, and ends it."""

from __future__ import annotations

from pathlib import Path

import click
from virtualrobot.cli.options import FiniteRange, Target, target_options
from virtualrobot.cli.own_kernel import in_kernel


@click.command(short_help="Watch two robots palletize, or a vehicle under water.")
@click.argument("which", type=click.Choice(["cell", "auv"]), default="cell")
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
@click.option(
    "--mission",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    metavar="FILE",
    help="Of auv: its mission.",
)
@click.option("--plot", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE", help="Of auv: draw it, .svg.")
@target_options
def demo(
    target: Target,
    which: str,
    loop: bool,
    headless: bool,
    speed: float | None,
    film: Path | None,
    data: Path | None,
    mission: Path | None,
    plot: Path | None,
) -> None:
    """Watch an iiwa and a Panda palletize the boxes of a conveyor (cell), or a BlueROV2 follow a path (auv).

    Starts a kernel of its own and ends it; with --address the demo replaces the world of a kernel that runs already.
    """
    if which == "auv":
        _auv(target, headless, speed, mission, plot, bool(loop or film or data))
        return
    if mission is not None or plot is not None:
        raise click.UsageError("--mission and --plot are for the demo auv")
    from virtualrobot_apps.demos.palletizing import palletize as app
    from virtualrobot_apps.demos.palletizing import resuming

    if data is not None and target.address is not None:
        raise click.UsageError("--data is for a kernel of the demo's own, --address for one that runs already")
    options = () if data is None else ("--data", str(data))
    with in_kernel(target, headless, speed, *options) as client:
        begun = None if data is None else resuming.begun(client)
        app.main(client, loop=loop, headless=headless, film=film, begun=begun)


def _auv(
    target: Target, headless: bool, speed: float | None, mission: Path | None, plot: Path | None, has_others: bool
) -> None:
    """Run the mission under water; its time goes by steps, as fast as it can be where nobody looks."""
    from virtualrobot_apps.vehicles import sail

    if has_others:
        raise click.UsageError("--loop, --record and --data are for the demo cell")
    if plot is not None and (plot.suffix != ".svg" or not plot.parent.is_dir()):
        raise click.UsageError("--plot takes a name that ends in .svg, in a folder that is there")
    pace = speed if speed is not None else (0.0 if headless else 1.0)
    with in_kernel(target, headless, None) as client:
        before = client.clock.read()
        try:
            sail.main(client, mission, plot, pace)
        finally:
            if before.mode == "realtime":
                client.clock.set_realtime(before.speed_factor)
