"""`virtualrobot add`, `remove`, `rename` and `attach`: the cell is built piece by piece."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

from virtualrobot.cli.names import NODE, SOURCE
from virtualrobot.cli.options import Numbers, Target, degrees_option, pose_of_numbers, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot add table bench --size 1.2,0.8,0.75 --at 0.6,0,0
  virtualrobot add part box --size 0.1,0.1,0.1 --at 0,0,0.8 --parent bench --mass 0.5
  virtualrobot add frame "pick place" --parent bench --at 0.2,0,0.75
  virtualrobot add sensor lidar LDS-01 --at 0,0,1
  virtualrobot add light lamp --at 0,0,3 --intensity 4
"""

_LENGTHS = click.FloatRange(0.0, min_open=True)


def place_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command a NAME and the options that say where a node goes; as `name` and `where`."""

    @click.argument("name")
    @click.option("--at", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="Where it goes in its parent's frame.")
    @click.option("--parent", type=NODE, default="world", help="The node that it is fixed to [world].")
    @degrees_option
    @target_options
    @functools.wraps(function)
    def command(*arguments: Any, at: tuple[float, ...] | None, parent: str, degrees: bool, **options: Any) -> None:  # noqa: ANN401
        where = {"pose": None if at is None else pose_of_numbers(at, degrees), "parent": parent}
        function(*arguments, where=where, **options)
        click.echo(f"added {options['name']}")

    return command


color_option = click.option("--color", help="A name such as red, or #rrggbb.")
size_option = click.option("--size", type=Numbers(3), metavar="X,Y,Z", required=True, help="The edges in meters.")


class _Kinds(click.Group):
    """Kinds of things to add."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command of a kind; raise UsageError, with those that there are, for another word."""
        if args and not args[0].startswith("-") and args[0] not in self.commands:
            ctx.fail(f"there is no {args[0]!r} to add; it is one of {', '.join(self.list_commands(ctx))}")
        return super().resolve_command(ctx, args)


@click.group(cls=_Kinds, epilog=_EXAMPLES)
@target_options
@click.pass_context
def add(ctx: click.Context, target: Target) -> None:
    """Add a box, a mesh, a table, a frame, a part, a sensor or a light to the world."""
    ctx.obj = target


@add.command()
@place_options
@size_option
@color_option
def box(target: Target, name: str, where: dict[str, Any], size: tuple[float, ...], color: str | None) -> None:
    """Add the box NAME to the environment; its origin is in its middle."""
    import virtualrobot

    with target.connect() as client:
        client.scene.add_object(name, virtualrobot.box(*size, color=color), **where)


@add.command()
@place_options
@click.option("--size", type=Numbers(3), metavar="X,Y,Z", default="1.2,0.8,0.75", help="The edges [1.2,0.8,0.75].")
@color_option
def table(target: Target, name: str, where: dict[str, Any], size: tuple[float, ...], color: str | None) -> None:
    """Add the table NAME, a top on four legs; its origin is on the floor, its upper side as high as --size says."""
    import virtualrobot

    with target.connect() as client:
        client.scene.add_object(name, virtualrobot.table(*size, color=color), **where)


@add.command()
@place_options
@click.option("--length", type=_LENGTHS, help="Of its arrows in meters [0.1].")
def frame(target: Target, name: str, where: dict[str, Any], length: float | None) -> None:
    """Add the frame NAME: a place with a name, for goals and for what hangs on it."""
    with target.connect() as client:
        client.scene.add_frame(name, size=length, **where)


@add.command()
@place_options
@click.option("--size", type=Numbers(3), metavar="X,Y,Z", help="A box with these edges in meters.")
@click.option("--radius", type=_LENGTHS, help="A sphere, or with --length a cylinder along z.")
@click.option("--length", type=_LENGTHS, help="Of a cylinder in meters.")
@click.option("--mass", type=_LENGTHS, help="In kilograms [unknown].")
@color_option
def part(
    target: Target,
    name: str,
    where: dict[str, Any],
    size: tuple[float, ...] | None,
    radius: float | None,
    length: float | None,
    mass: float | None,
    color: str | None,
) -> None:
    """Add the part NAME, a thing that robots handle: a box, a sphere or a cylinder about its origin."""
    import virtualrobot

    if (size is None) == (radius is None) or (length is not None and radius is None):
        raise click.UsageError("say how big the part is: --size, --radius, or --radius and --length")
    if size is not None:
        figure = virtualrobot.box(*size, color=color)
    elif length is not None:
        figure = virtualrobot.cylinder(radius or 0.0, length, color=color)
    else:
        figure = virtualrobot.sphere(radius or 0.0, color=color)
    with target.connect() as client:
        client.scene.add_part(name, figure, mass=mass, **where)


@add.command()
@click.argument("file", type=SOURCE)
@place_options
@click.option("--scale", type=Numbers(1, 3), default="1", help="One factor or three.")
@click.option("--part", "as_part", is_flag=True, help="A thing that robots handle.")
def mesh(target: Target, file: str, name: str, where: dict[str, Any], scale: tuple[float, ...], as_part: bool) -> None:
    """Add the mesh in FILE as NAME to the environment."""
    with target.connect() as client:
        factors = scale[0] if len(scale) == 1 else scale
        client.scene.load(file, name=name, scale=factors, as_part=as_part, **where)


@add.command()
@place_options
@click.argument("preset", required=False)
@click.option("--camera", is_flag=True, help="A camera, which looks along its z, in place of a range sensor.")
@click.option("--rate", type=_LENGTHS, help="Readings a second [its own].")
@click.option("--start", "running", is_flag=True, help="It reads from now on.")
def sensor(
    target: Target,
    name: str,
    preset: str | None,
    where: dict[str, Any],
    camera: bool,
    rate: float | None,
    running: bool,
) -> None:
    """Add the sensor NAME: a range sensor like the device PRESET of 'virtualrobot sensor presets', or a camera."""
    import virtualrobot

    if camera == (preset is not None):
        raise click.UsageError("say what it is: a PRESET of 'virtualrobot sensor presets', or --camera")
    with target.connect() as client:
        if camera:
            client.scene.add_camera(name, virtualrobot.camera(rate=rate, running=running), **where)
        else:
            client.scene.add_range_sensor(name, virtualrobot.range_sensor(preset, rate=rate, running=running), **where)


@add.command()
@place_options
@click.option(
    "--kind", type=click.Choice(["point", "spot", "directional"]), default="point", help="Where it shines [point]."
)
@click.option("--intensity", type=_LENGTHS, help="1 shows white 1 m away as white [1].")
@color_option
def light(
    target: Target, name: str, where: dict[str, Any], kind: str, intensity: float | None, color: str | None
) -> None:
    """Add the light NAME, for what cameras see; a spot and a directional one shine along their z."""
    import virtualrobot

    with target.connect() as client:
        client.scene.add_light(name, virtualrobot.light(kind, color=color, intensity=intensity), **where)


@click.command()
@click.argument("nodes", nargs=-1, required=True, type=NODE)
@target_options
def remove(target: Target, nodes: tuple[str, ...]) -> None:
    """Take NODES and all that hangs below them out of the world, all or none."""
    with target.connect() as client:
        with client.scene.batch() as batch:
            for node in nodes:
                batch.remove(node)
        click.echo(f"removed {', '.join(nodes)}")


@click.command()
@click.argument("node", type=NODE)
@click.argument("new_name")
@target_options
def rename(target: Target, node: str, new_name: str) -> None:
    """Give NODE another name."""
    with target.connect() as client:
        client.scene.rename(node, new_name)
        click.echo(f"renamed {node} to {new_name}")


@click.command()
@click.argument("node", type=NODE)
@click.argument("parent", type=NODE)
@click.option("--at", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="In the parent's frame [where it is].")
@degrees_option
@target_options
def attach(target: Target, node: str, parent: str, at: tuple[float, ...] | None, degrees: bool) -> None:
    """Fix NODE to PARENT, where it is in the world or --at a place in PARENT's frame."""
    with target.connect() as client:
        client.scene.attach(node, parent, None if at is None else pose_of_numbers(at, degrees))
        click.echo(f"attached {node} to {parent}")
