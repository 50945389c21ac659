"""`virtualrobot capture`, `record`, `pixel` and `measure`: pictures, films, what is under a pixel, and distances."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from virtualrobot.cli.options import Numbers, Target, target_options

if TYPE_CHECKING:
    from virtualrobot.view.measuring import Measure, Place
    from virtualrobot.view.pictures import Camera


class Size(click.ParamType):
    """Width and height in pixels, such as 1280x720."""

    name = "size"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        """Return both."""
        if isinstance(value, tuple):
            return value
        width, separator, height = str(value).lower().partition("x")
        if not (separator and width.isdecimal() and height.isdecimal()):
            self.fail(f"{value!r} is not a width and a height in pixels, such as 1280x720", param, ctx)
        return int(width), int(height)


class PlaceType(click.ParamType):
    """A node, and a point in its frame where wanted, such as table:0,0,0.7."""

    name = "place"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Place:
        """Return both."""
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportReturnType] what this function has returned before
        node, separator, point = str(value).partition(":")
        return node, Numbers(3).convert(point, param, ctx) if separator else (0.0, 0.0, 0.0)


def camera_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options that say from where a picture is taken."""
    for option in (
        click.option("--size", type=Size(), default=None, metavar="WxH", help="Pixels [1280x720, or the camera's]."),
        click.option("--at", "target_point", type=Numbers(3), metavar="X,Y,Z", help="What --from looks at [0,0,0]."),
        click.option("--from", "eye", type=Numbers(3), metavar="X,Y,Z", help="Where it is taken from, in meters."),
        click.option("--camera", metavar="NAME", help="Through this camera, or from this viewpoint, of the scene."),
    ):
        function = option(function)
    return function


plain_option = click.option("--plain", is_flag=True, help="Without annotations, boxes, axes and measurements.")


@click.command()
@click.argument("output", type=click.Path(path_type=Path, dir_okay=False))
@camera_options
@plain_option
@click.option("--model", metavar="NAME", help="A small picture of this known model instead, as a .png; see `models`.")
@target_options
def capture(
    target: Target,
    output: Path,
    camera: str | None,
    eye: tuple[float, ...] | None,
    target_point: tuple[float, ...] | None,
    size: tuple[int, int] | None,
    plain: bool,
    model: str | None,
) -> None:
    """Write a picture of the world as it is now to OUTPUT, a .png or .jpg; it needs no browser."""
    from virtualrobot.view.pictures import format_of

    format = format_of(output)
    if model is not None:
        if format != "png" or camera or eye or size or plain:
            raise click.UsageError("--model is alone, and its OUTPUT a .png")
        with target.connect() as client:
            picture = client.view.capture_model(model)
        picture.save(output)
        click.echo(f"{output}: {picture.width}x{picture.height}, the model {model}")
        return
    with target.connect() as client:
        picture = client.view.capture(camera_of(camera, eye, target_point), size=size, format=format, plain=plain)
    picture.save(output)
    click.echo(f"{output}: {picture.width}x{picture.height}, at {picture.simulation_time:.3f} s")


@click.command()
@click.argument("column", type=float)
@click.argument("row", type=float)
@camera_options
@target_options
def pixel(
    target: Target,
    column: float,
    row: float,
    camera: str | None,
    eye: tuple[float, ...] | None,
    target_point: tuple[float, ...] | None,
    size: tuple[int, int] | None,
) -> None:
    """Tell what is under the pixel at COLUMN, ROW of the picture that `capture` takes; 0 0 is the upper left one."""
    with target.connect() as client:
        found = client.view.pick(column, row, camera_of(camera, eye, target_point), size=size)
    if not found.node:
        click.echo("nothing")
        return
    red, green, blue = (round(255 * part) for part in found.color.tolist())
    click.echo(f"{found.node}, {found.distance:.3f} m from the eye, of the colour #{red:02x}{green:02x}{blue:02x}")
    click.echo(f"  world  {three(found.point)}")
    click.echo(f"  node   {three(found.node_point)}")


@click.command()
@click.argument("first", type=PlaceType())
@click.argument("second", type=PlaceType())
@click.option("--watch", is_flag=True, help="Go on until Ctrl-C.")
@target_options
def measure(target: Target, first: Place, second: Place, watch: bool) -> None:
    """Tell how far FIRST and SECOND are apart: nodes, or points in their frames such as table:0,0,0.7."""
    with target.connect() as client:
        if not watch:
            click.echo(_measured(client.view.measure(first, second)))
            return
        for told in client.view.watch_measure(first, second, max_rate=5.0):
            on_terminal = sys.stdout.isatty()
            click.echo(("\r\x1b[K" if on_terminal else "") + _measured(told), nl=not on_terminal)


def camera_of(camera: str | None, eye: Sequence[float] | None, target: Sequence[float] | None) -> Camera | None:
    """Return where a picture is taken from; None means as the view's camera does."""
    if camera is not None and eye is not None:
        raise click.UsageError("give either --camera or --from")
    if eye is None:
        if target is not None:
            raise click.UsageError("--at needs --from")
        return camera
    return eye, target or (0.0, 0.0, 0.0)


def _measured(told: Measure) -> str:
    return f"{told.distance:.4f} m from {three(told.first)} to {three(told.second)}"


def three(values: Iterable[float]) -> str:
    """Return the coordinates of a point in words."""
    return " ".join(f"{value + 0.0:.4f}" for value in values)
