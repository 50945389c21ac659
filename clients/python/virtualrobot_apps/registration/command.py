"""`virtualrobot marker` and `virtualrobot register`: printed markers, and where real things are for a device."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.names import NODE, ROBOT
from virtualrobot.cli.options import FiniteRange, Numbers, Target, WholeRange, target_options

if TYPE_CHECKING:
    from virtualrobot_apps.registration.touched import Registration

_FILE = click.Path(exists=True, dir_okay=False, path_type=Path)
_edge = click.option(
    "--edge", type=FiniteRange(0.0, 1.0, min_open=True), default=0.15, help="The edge of its black square, m [0.15]."
)


@click.command(short_help="Write a sheet with a marker, to be printed.")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--number", type=WholeRange(0, 49), default=0, help="Which of the 50 markers [0].")
@click.option("--paper", type=click.Choice(["a4", "a3", "letter"]), default="a4", help="The paper [a4].")
@_edge
def marker(file: Path, number: int, paper: str, edge: float) -> None:
    """Write a sheet with a marker to FILE: .pdf, .svg or .png. No kernel is needed.

    Print it in its true size and fix it where the model has a frame: x to the right, y up, z out of the paper.
    """
    from virtualrobot_apps.registration.marker_pose import bits_of
    from virtualrobot_apps.registration.marker_sheet import WRITERS, sheet

    writer = WRITERS.get(file.suffix.lower())
    if writer is None:
        raise click.UsageError(f"{file} doesn't end with {', '.join(sorted(WRITERS))}")
    data = writer(sheet(bits_of(number), edge, number, paper))
    try:
        file.write_bytes(data)
    except OSError as error:
        raise click.UsageError(f"{file} cannot be written: {error.strerror or error}") from error
    click.echo(f"written: {file}, marker {number}, edge {1e3 * edge:g} mm; print it in its true size")


@click.group(short_help="Find where a measuring device, or a real robot, is, by touched points or a printed marker.")
@target_options
@click.pass_context
def register(ctx: click.Context, target: Target) -> None:
    """Find where a measuring device is for the model, or a real robot, and keep it in the world."""
    ctx.obj = target


@register.command()
@click.argument("file", type=_FILE)
@click.option("--frame", help="Keep the device as this frame, below the node that the file's points are relative to.")
@click.option(
    "--robot", type=ROBOT, help="Put this robot where it really is instead: the device measures in the world."
)
@click.option("--tool", "tools", type=NODE, multiple=True, help="A node whose error is told; may be given again.")
@click.option(
    "--least-apart", type=FiniteRange(0.0), default=0.6, help="Distance that two points have, seen from above, m [0.6]."
)
@target_options
def touched(
    target: Target, file: Path, frame: str | None, robot: str | None, tools: tuple[str, ...], least_apart: float
) -> None:
    """Find where a device is that touched points of the model, which FILE (.yaml) lists.

    Gravity is known: one axis of the device's frame is up. Without --frame and --robot nothing changes.
    """
    from virtualrobot_apps.registration.placing import keep_frame, move_robot, touched_in
    from virtualrobot_apps.registration.touched_file import read_touched

    if frame is not None and robot is not None:
        raise click.UsageError("--frame keeps a device and --robot moves a robot; give one of them")
    read = read_touched(file)
    with target.connect() as client:
        found, errors = touched_in(client, read, tools, least_apart)
        click.echo("\n".join(_lines(found, errors)))
        if frame is not None:
            keep_frame(client, frame, found.model_t_device, read.relative_to)
            click.echo(f"kept as {frame}, below {read.relative_to}")
        if robot is not None:
            move_robot(client, robot, found)
            click.echo(f"{robot} stands where it was touched")


@register.command()
@click.argument("pictures", nargs=-1, required=True, type=_FILE, metavar="PICTURE...")
@click.option("--marker", "sheet", type=NODE, required=True, help="The node where the sheet is in the model.")
@click.option("--number", type=WholeRange(0, 49), help="Which marker, where several are seen.")
@click.option(
    "--field", type=FiniteRange(0.0, 180.0, True, True), help="The camera's horizontal field of view, degrees."
)
@click.option("--matrix", type=Numbers(4), metavar="FX,FY,CX,CY", help="Instead: its focal lengths and middle, pixels.")
@click.option("--distortion", type=Numbers(4, 5, 8), default=(), metavar="K1,K2,P1,P2,...", help="OpenCV's [none].")
@click.option("--up", type=Numbers(3), metavar="X,Y,Z", help="Away from gravity, for the camera (x right, y down).")
@click.option("--tool", "tools", type=NODE, multiple=True, help="A node whose error is told; may be given again.")
@click.option("--frame", help="Keep the camera as this frame, below the sheet's node.")
@_edge
@target_options
def picture(
    target: Target,
    pictures: tuple[Path, ...],
    sheet: str,
    number: int | None,
    field: float | None,
    matrix: tuple[float, ...] | None,
    distortion: tuple[float, ...],
    up: tuple[float, ...] | None,
    tools: tuple[str, ...],
    frame: str | None,
    edge: float,
) -> None:
    """Find where a camera is that took PICTURE, or some from one place, of a marker."""
    import math

    import numpy as np

    from virtualrobot_apps.registration.marker_pose import read_picture
    from virtualrobot_apps.registration.placing import AWAY, camera_in, keep_frame, seen_in

    if (field is None) == (matrix is None):
        raise click.UsageError("the camera's --field or its --matrix is needed, one of them")
    seen = seen_in(
        {str(file): read_picture(file) for file in pictures},
        field=None if field is None else math.radians(field),
        matrix=matrix,
        distortion=distortion,
        edge=edge,
        number=number,
    )
    with target.connect() as client:
        seen, world_t_camera, errors = camera_in(client, seen, sheet, tools, up)
        distance = float(np.linalg.norm(seen.camera_t_marker[:3, 3]))
        click.echo(
            f"marker {seen.number}, {distance:.3f} m away, corners {seen.deviation:.2f} pixels off; "
            f"the camera is at {_place(world_t_camera[:3, 3].tolist())}"
        )
        click.echo("\n".join(_errors({f"{AWAY:g} m beside it": seen.error([AWAY, 0.0, 0.0]), **errors})))
        if frame is not None:
            keep_frame(client, frame, world_t_camera, sheet)
            click.echo(f"kept as {frame}, below {sheet}")


def _lines(found: Registration, errors: dict[str, float]) -> list[str]:
    """Return how good a registration is, in words; `errors` (m) are those of nodes, by their names."""
    import numpy as np
    from virtualrobot.geometry import roll_pitch_yaw_of

    from virtualrobot_apps.registration.placing import AWAY

    place = _place(found.model_t_device[:3, 3].tolist())
    yaw = float(roll_pitch_yaw_of(found.model_t_device)[2])
    off = ", ".join(f"{1e3 * one:.1f}" for one in found.residuals)
    away = {f"{AWAY:g} m away": found.error(found.center + np.array([AWAY, 0.0, 0.0]))}
    return [
        f"the device is at {place}, turned by {yaw:.4f} rad; points off by {off} mm",
        f"a touch is good to {1e3 * found.noise:.1f} mm",
        *_errors({**away, **errors}),
    ]


def _errors(errors: dict[str, float]) -> list[str]:
    """Return how far places are off, in words."""
    told = (f"  {name}: {1e3 * error:.1f} mm" for name, error in errors.items())
    return ["in 95 of 100 cases these are off by no more than:", *told]


def _place(numbers: list[float]) -> str:
    """Return a place in words, without a minus before what rounds to 0."""
    return ", ".join(f"{round(one, 4) + 0.0:.4f}" for one in numbers)
