"""`virtualrobot navigate`: a vehicle of a kernel maps the floor that it stands on, and goes to places on it."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import FiniteRange, Target, target_options
from virtualrobot.errors import WrongStateError

if TYPE_CHECKING:
    from virtualrobot import Client

    from virtualrobot_apps.seeing.navigation.mapping import Mapper
    from virtualrobot_apps.seeing.navigation.vehicle import Vehicle

_EXAMPLES = """
\b
Examples:
  virtualrobot navigate explore ugv floor.yaml
  virtualrobot navigate go ugv floor.yaml --to 4.5 2 --to 0 0
  virtualrobot navigate go ugv floor.yaml --to 4.5 2 --from 0 0 90
"""
ANY = FiniteRange()
SPEED = click.option(
    "--speed", type=FiniteRange(0.01, 100.0), help="Simulated seconds for each second of the wall clock [all it can]."
)
LIDAR = click.option("--lidar", metavar="SENSOR", help="The lidar [the one of the robot that is called so].")
ENCODERS = click.option("--encoders", metavar="SENSOR", help="The encoders [the ones that are called so].")
_PACKAGES = {"navigation": ("pyastar2d", "scipy"), "seeing": ("scipy", "small_gicp")}
FILE = click.argument("file", type=click.Path(path_type=Path, dir_okay=False), metavar="MAP.yaml")


@click.group(epilog=_EXAMPLES, short_help="Let a vehicle map a floor by lidar and go to places on it.")
@target_options
@click.pass_context
def navigate(ctx: click.Context, target: Target) -> None:
    """Let a vehicle map a floor by lidar and odometry, and go to places on it.

    MAP.yaml is a map as ROS's map_server has it, its picture (.pgm) beside it. In steps: while the vehicle drives,
    simulation time goes on as it asks. Ctrl-C stops it.
    """
    ctx.obj = target


@navigate.command()
@click.argument("robot")
@FILE
@click.option(
    "--from",
    "start",
    type=(ANY, ANY, ANY),
    default=(0.0, 0.0, 0.0),
    metavar="X Y DEGREES",
    help="Its pose in the map's frame now [0 0 0].",
)
@click.option(
    "--resolution", type=FiniteRange(0.01, 0.5), default=0.05, show_default=True, help="Edge of a cell in meters."
)
@LIDAR
@ENCODERS
@SPEED
@target_options
def explore(
    target: Target,
    robot: str,
    file: Path,
    start: tuple[float, float, float],
    resolution: float,
    lidar: str | None,
    encoders: str | None,
    speed: float | None,
) -> None:
    """Look at the edges of what is known until none is left that can be seen, and write the map.

    Edges that stay unseen are told with the reason, and the exit code is 1 then. Ctrl-C writes the map so far; it is
    130 then.
    """
    check_file(file)
    check_packages()
    from virtualrobot_apps.seeing.navigation import journeys

    with target.connect() as client:
        vehicle = _vehicle(client, robot, lidar, encoders)
        try:
            explored = journeys.explore(
                client, vehicle, journeys.pose_of(start), resolution=resolution, say=click.echo, pace=speed or 0.0
            )
        except journeys.ExplorationInterrupted as interrupted:
            click.echo("interrupted: writes the map so far", err=True)
            _save(interrupted.mapper, file)
            raise click.exceptions.Exit(130) from None
    _save(explored.mapper, file)
    if explored.unseen:
        raise SystemExit(1)


@navigate.command()
@click.argument("robot")
@FILE
@click.option("--to", "goals", type=(ANY, ANY), multiple=True, required=True, metavar="X Y", help="Where to; repeated.")
@click.option(
    "--from",
    "start",
    type=(ANY, ANY, ANY),
    metavar="X Y DEGREES",
    help="Its pose in the map now [it looks for its place].",
)
@LIDAR
@ENCODERS
@SPEED
@target_options
def go(
    target: Target,
    robot: str,
    file: Path,
    goals: tuple[tuple[float, float], ...],
    start: tuple[float, float, float] | None,
    lidar: str | None,
    encoders: str | None,
    speed: float | None,
) -> None:
    """Go to places on a map, around what stands in the way; the exit code is 1 when one isn't reached."""
    check_packages()
    from virtualrobot_apps.seeing.navigation import journeys
    from virtualrobot_apps.seeing.navigation.grid import load
    from virtualrobot_apps.seeing.navigation.navigator import Goal

    grid = load(file)
    with target.connect() as client:
        reached = journeys.go(
            client,
            _vehicle(client, robot, lidar, encoders),
            grid,
            [Goal(*goal) for goal in goals],
            None if start is None else journeys.pose_of(start),
            say=click.echo,
            pace=speed or 0.0,
        )
    if not all(reached):
        raise SystemExit(1)


def _save(mapper: Mapper, file: Path) -> None:
    mapper.grid.save(file)
    rows, columns = mapper.grid.occupied.shape[:2]
    click.echo(
        f"{file}: {columns} x {rows} cells of {mapper.grid.resolution:g} m, of {len(mapper.poses)} scans and "
        f"{mapper.loops} loops"
    )


def check_file(file: Path) -> None:
    """Raise UsageError for a name that no map can be written to."""
    if file.suffix != ".yaml":
        raise click.UsageError(f"a map's name ends in .yaml, not {file.name!r}")
    if not file.parent.is_dir():
        raise click.UsageError(f"there is no folder {file.parent}")


def check_packages(extra: str = "navigation") -> None:
    """Raise WrongStateError, which says how to install them, where packages of an extra are missing."""
    if missing := [name for name in _PACKAGES[extra] if importlib.util.find_spec(name) is None]:
        raise WrongStateError(f"{extra} needs {' and '.join(missing)}: pip install 'virtualrobot[{extra}]'")


def _vehicle(client: Client, robot: str, lidar: str | None, encoders: str | None) -> Vehicle:
    from virtualrobot_apps.seeing.navigation.vehicle import Vehicle, sensors_of

    if lidar is None or encoders is None:
        found = sensors_of(client, robot)
        lidar, encoders = lidar or found[0], encoders or found[1]
    return Vehicle(client, robot, lidar, encoders)
