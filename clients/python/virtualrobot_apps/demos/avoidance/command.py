"""`virtualrobot avoid`: starts a kernel, lets an arm avoid obstacles in it, and ends it."""

from __future__ import annotations

from pathlib import Path

import click
from virtualrobot.cli.options import FiniteRange, Target, target_options
from virtualrobot.cli.own_kernel import in_kernel


@click.command(short_help="Watch an arm avoid obstacles while its tool goes its way.")
@click.option("--robot", type=click.Choice(["iiwa", "panda"]), default="iiwa", show_default=True, help="Which arm.")
@click.option("--hold", is_flag=True, help="The tool stays where it is, instead of going round.")
@click.option("--seconds", type=FiniteRange(1.0, 600.0), default=12.0, show_default=True, help="How long each run is.")
@click.option("--plot", type=click.Path(path_type=Path, dir_okay=False), help="Draw distances and errors: .svg.")
@click.option("--stepped", is_flag=True, help="In steps instead of real time: the same in every run.")
@click.option("--headless", is_flag=True, help="Open no viewer.")
@click.option("--speed", type=FiniteRange(0.01, 100.0), help="Simulated seconds for each second of the wall clock.")
@target_options
def avoid(
    target: Target,
    robot: str,
    hold: bool,
    seconds: float,
    plot: Path | None,
    stepped: bool,
    headless: bool,
    speed: float | None,
) -> None:
    """Watch the links of an arm keep away from a post and a ball while its tool goes its way: without and with it.

    Starts a kernel of its own and ends it; with --address the cell replaces the world of a kernel that runs already.
    """
    if stepped and speed is not None:
        raise click.UsageError("--stepped has no --speed: it is as fast as it can be")
    if plot is not None and plot.suffix != ".svg":
        raise click.UsageError("--plot takes a name that ends in .svg")
    if plot is not None and not plot.parent.is_dir():
        raise click.UsageError(f"--plot: there is no folder {plot.parent}")
    from virtualrobot_apps.demos.avoidance import avoid as app

    with in_kernel(target, headless, speed) as client:
        before = client.clock.read()
        if stepped:
            client.clock.set_stepped()
        try:
            app.main(client, robot, hold, seconds, plot, headless)
        finally:
            if stepped and before.mode == "realtime":
                client.clock.set_realtime(before.speed_factor)
