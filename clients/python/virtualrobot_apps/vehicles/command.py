"""`virtualrobot demo auv`, `boebot`, `hexapod`, `maze`, `quadruped`, `rov`, `ugv`, `uvms`: machines in kernels."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
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
PHYSICS = click.option(
    "--physics", default="none", show_default=True, metavar="ENGINE", help="By forces: `mujoco`, `bullet`."
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
@click.option("--gamepad", is_flag=True, help="Pilot by a gamepad, while its dead man's button is held.")
@click.option("--space-mouse", is_flag=True, help="The same by a space mouse.")
@click.option(
    "--mapping",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    metavar="FILE",
    help="What axes and buttons mean.",
)
@HEADLESS
@target_options
def rov(target: Target, gamepad: bool, space_mouse: bool, mapping: Path | None, headless: bool) -> None:
    """Pilot a BlueROV2 among piles in a current, by the keys of this terminal, while one is held.

    In real time. Starts a kernel of its own and ends it; with --address the vehicle replaces the world of a kernel that
    runs already.
    """
    from virtualrobot.cli import gamepad_mapping
    from virtualrobot.cli.gamepad import Gamepad
    from virtualrobot.cli.space_mouse import SpaceMouse

    from virtualrobot_apps.vehicles import pilot

    if gamepad and space_mouse:
        raise click.UsageError("say --gamepad or --space-mouse, not both")
    if mapping is not None and not gamepad and not space_mouse:
        raise click.UsageError("--mapping is that of a gamepad: say --gamepad, too; or --space-mouse")
    if sys.stdin is None or not sys.stdin.isatty():
        raise click.UsageError("a pilot needs a terminal; without one use 'virtualrobot demo auv'")
    if space_mouse:
        meant = gamepad_mapping.read_mapping(mapping or gamepad_mapping.USUAL_SPACE_MOUSE, gamepad_mapping.SPACE_MOUSE)
    else:
        meant = gamepad_mapping.read_mapping(mapping or pilot.MAPPING)
    with ExitStack() as stack:
        pad = stack.enter_context(SpaceMouse() if space_mouse else Gamepad()) if gamepad or space_mouse else None
        pilot.main(stack.enter_context(in_kernel(target, headless, None)), pad, meant)


@click.command()
@PLOT
@HEADLESS
@SPEED
@target_options
def uvms(target: Target, plot: Path | None, headless: bool, speed: float | None) -> None:
    """Watch an underwater vehicle with an arm, which pushes it about and keeps its tool in place while it drifts.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the vehicle replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.vehicles import uvms

    with stepped(target, plot, headless) as client:
        uvms.main(client, plot, pace_of(speed, headless))


@click.command()
@click.option("--side", type=FiniteRange(0.5, 50.0), help="Side of the square [2 m].")
@click.option("--room", is_flag=True, help="Around the table of a furnished room, instead of a square.")
@PHYSICS
@PLOT
@HEADLESS
@SPEED
@target_options
def ugv(
    target: Target,
    side: float | None,
    room: bool,
    physics: str,
    plot: Path | None,
    headless: bool,
    speed: float | None,
) -> None:
    """Watch a UGV drive a square by waypoints, or through a room, with a PI and then with a PID controller.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the UGV replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.vehicles import ugv

    if room and side is not None:
        raise click.UsageError("--side is of the square, which --room has not")
    with stepped(target, plot, headless) as client:
        ugv.main(client, None if room else side or ugv.SIDE, plot, pace_of(speed, headless), physics)


GROUND = click.option(
    "--ground", type=click.Choice(["level", "rolling"]), default="rolling", show_default=True, help="What it walks on."
)
SEED = click.option("--seed", type=WholeRange(0), default=1, show_default=True, help="Seed of rolling ground.")
SLOPE = click.option(
    "--slope", type=FiniteRange(-45.0, 45.0), default=0.0, show_default=True, help="Slope of level ground (degrees)."
)


@click.command()
@click.option(
    "--gait", type=click.Choice(["tripod", "ripple", "wave"]), default="tripod", show_default=True, help="How it steps."
)
@GROUND
@SEED
@SLOPE
@PHYSICS
@PLOT
@HEADLESS
@SPEED
@target_options
def hexapod(
    target: Target,
    gait: str,
    ground: str,
    seed: int,
    slope: float,
    physics: str,
    plot: Path | None,
    headless: bool,
    speed: float | None,
) -> None:
    """Watch a hexapod walk: its steps, its support polygon, and how far it is from falling.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the hexapod replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.vehicles.walking import demo

    check_ground(ground, slope)
    with stepped(target, plot, headless) as client:
        pace = pace_of(speed, headless)
        demo.main(client, "hexapod", gait, ground, seed, plot, pace, math.radians(slope), physics)


@click.command()
@click.option(
    "--model", type=click.Choice(["a1", "aliengo"]), default="a1", show_default=True, help="Which of the catalogue."
)
@click.option("--gait", type=click.Choice(["crawl", "trot"]), default="crawl", show_default=True, help="How it steps.")
@GROUND
@SEED
@SLOPE
@PHYSICS
@PLOT
@HEADLESS
@SPEED
@target_options
def quadruped(
    target: Target,
    model: str,
    gait: str,
    ground: str,
    seed: int,
    slope: float,
    physics: str,
    plot: Path | None,
    headless: bool,
    speed: float | None,
) -> None:
    """Watch a quadruped of the catalogue walk: its steps, its support polygon, and how far it is from falling.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the quadruped replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.vehicles.walking import demo

    check_ground(ground, slope)
    with stepped(target, plot, headless) as client:
        pace = pace_of(speed, headless)
        demo.main(client, model, gait, ground, seed, plot, pace, math.radians(slope), physics)


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
@click.option("--seeds", type=WholeRange(1, 1000), default=1, show_default=True, help="How many of each size.")
@PLOT
@HEADLESS
@SPEED
@target_options
def maze(
    target: Target, size: int, seed: int, mazes: int, seeds: int, plot: Path | None, headless: bool, speed: float | None
) -> None:
    """Watch a Boe-Bot pass mazes by the right-hand rule and three sonars.

    With --mazes and --seeds it is a study: several mazes of each size, counted in a table.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the maze replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.vehicles.boebot import maze_run
    from virtualrobot_apps.vehicles.boebot.maze import LARGEST

    if size + mazes - 1 > LARGEST:
        raise click.UsageError(f"--size and --mazes: the largest maze has {LARGEST} cells along a side")
    with stepped(target, plot, headless) as client:
        maze_run.main(client, size, seed, mazes, plot, pace_of(speed, headless), seeds)


def check_ground(ground: str, slope: float) -> None:
    """Refuse slopes of rolling ground."""
    if ground == "rolling" and slope:
        raise click.UsageError("--slope is of level ground: say --ground level")


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
