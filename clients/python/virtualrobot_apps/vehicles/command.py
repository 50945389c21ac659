"""`virtualrobot demo auv`, `boebot`, `hexapod`, `maze`, `ugv`: they start a kernel, lead a machine, and end it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import FiniteRange, Target, WholeRange, target_options
from virtualrobot.cli.own_kernel import in_kernel

if TYPE_CHECKING:
    from virtualrobot import Client

PLOT = click.option("--plot", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE", help="Draw it: .svg.")
HEADLESS = click.option("--headless", is_flag=True, help="Open no viewer.")
SPEED = click.option(
    "--speed", type=FiniteRange(0.01, 100.0), help="Simulated seconds for each second of the wall clock."
)


@click.command()
@click.option(
    "--mission", type=click.Path(path_type=Path, dir_okay=False, exists=True), metavar="FILE", help="What it does."
)
@PLOT
@HEADLESS
@SPEED
@target_options
def auv(target: Target, mission: Path | None, plot: Path | None, headless: bool, speed: float | None) -> None:
    """Watch a BlueROV2 follow a path under water against a current.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the vehicle replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.vehicles import sail

    with stepped(target, plot, headless) as client:
        sail.main(client, mission, plot, pace_of(speed, headless))


@click.command()
@click.option("--side", type=FiniteRange(0.5, 50.0), default=2.0, show_default=True, help="Side of the square (m).")
@PLOT
@HEADLESS
@SPEED
@target_options
def ugv(target: Target, side: float, plot: Path | None, headless: bool, speed: float | None) -> None:
    """Watch a UGV drive a square by waypoints, with a PI and then with a PID controller.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the UGV replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.vehicles import ugv

    with stepped(target, plot, headless) as client:
        ugv.main(client, side, plot, pace_of(speed, headless))


GROUND = click.option(
    "--ground", type=click.Choice(["level", "rolling"]), default="rolling", show_default=True, help="What it walks on."
)
SEED = click.option("--seed", type=WholeRange(0), default=1, show_default=True, help="Seed of rolling ground.")


@click.command()
@click.option(
    "--gait", type=click.Choice(["tripod", "ripple", "wave"]), default="tripod", show_default=True, help="How it steps."
)
@GROUND
@SEED
@PLOT
@HEADLESS
@SPEED
@target_options
def hexapod(
    target: Target, gait: str, ground: str, seed: int, plot: Path | None, headless: bool, speed: float | None
) -> None:
    """Watch a hexapod walk: its steps, its support polygon, and how far it is from falling.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the hexapod replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.vehicles.walking import demo

    with stepped(target, plot, headless) as client:
        demo.main(client, "hexapod", gait, ground, seed, plot, pace_of(speed, headless))


@click.command()
@PLOT
@HEADLESS
@SPEED
@target_options
def boebot(target: Target, plot: Path | None, headless: bool, speed: float | None) -> None:
    """Watch a Boe-Bot follow a line by its camera, and stop for a can that its laser sees.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the line replaces the world of a kernel that runs already. Needs the extra `vision`.
    """
    from virtualrobot_apps.vehicles.boebot import line_follower, line_run

    line_follower.library()  # before a kernel is started for nothing
    with stepped(target, plot, headless) as client:
        line_run.main(client, plot, pace_of(speed, headless))


@click.command()
@click.option("--size", type=WholeRange(2, 50), default=4, show_default=True, help="Cells along a side.")
@click.option("--seed", type=WholeRange(0), default=1, show_default=True, help="Which maze of that size.")
@click.option("--mazes", type=WholeRange(1, 49), default=1, show_default=True, help="How many, each a cell larger.")
@PLOT
@HEADLESS
@SPEED
@target_options
def maze(
    target: Target, size: int, seed: int, mazes: int, plot: Path | None, headless: bool, speed: float | None
) -> None:
    """Watch a Boe-Bot pass mazes by the right-hand rule and three sonars.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the maze replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.vehicles.boebot import maze_run
    from virtualrobot_apps.vehicles.boebot.maze import LARGEST

    if size + mazes - 1 > LARGEST:
        raise click.UsageError(f"--size and --mazes: the largest maze has {LARGEST} cells along a side")
    with stepped(target, plot, headless) as client:
        maze_run.main(client, size, seed, mazes, plot, pace_of(speed, headless))


@contextmanager
def stepped(target: Target, plot: Path | None, headless: bool) -> Iterator[Client]:
    """Give a client of a kernel whose clock is put back at the end; refuse a plot that cannot be written."""
    if plot is not None and plot.suffix != ".svg":
        raise click.UsageError("--plot takes a name that ends in .svg")
    if plot is not None and not plot.parent.is_dir():
        raise click.UsageError(f"--plot: there is no folder {plot.parent}")
    with in_kernel(target, headless, None) as client:
        before = client.clock.read()
        try:
            yield client
        finally:
            if before.mode == "realtime":
                client.clock.set_realtime(before.speed_factor)


def pace_of(speed: float | None, headless: bool) -> float:
    """Return simulated seconds for each second of the wall clock; 0: as fast as it can be."""
    return speed if speed is not None else (0.0 if headless else 1.0)
