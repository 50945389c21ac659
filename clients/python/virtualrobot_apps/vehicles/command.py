"""`virtualrobot demo auv`: starts a kernel, leads a vehicle under water through a mission, and ends it."""

from __future__ import annotations

from pathlib import Path

import click
from virtualrobot.cli.options import FiniteRange, Target, target_options
from virtualrobot.cli.own_kernel import in_kernel


@click.command()
@click.option(
    "--mission", type=click.Path(path_type=Path, dir_okay=False, exists=True), metavar="FILE", help="What it does."
)
@click.option("--plot", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE", help="Draw it: .svg.")
@click.option("--headless", is_flag=True, help="Open no viewer.")
@click.option("--speed", type=FiniteRange(0.01, 100.0), help="Simulated seconds for each second of the wall clock.")
@target_options
def auv(target: Target, mission: Path | None, plot: Path | None, headless: bool, speed: float | None) -> None:
    """Watch a BlueROV2 follow a path under water against a current.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the vehicle replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.vehicles import sail

    if plot is not None and plot.suffix != ".svg":
        raise click.UsageError("--plot takes a name that ends in .svg")
    if plot is not None and not plot.parent.is_dir():
        raise click.UsageError(f"--plot: there is no folder {plot.parent}")
    pace = speed if speed is not None else (0.0 if headless else 1.0)
    with in_kernel(target, headless, None) as client:
        before = client.clock.read()
        try:
            sail.main(client, mission, plot, pace)
        finally:
            if before.mode == "realtime":
                client.clock.set_realtime(before.speed_factor)
