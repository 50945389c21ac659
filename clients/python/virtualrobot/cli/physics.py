"""`virtualrobot physics`: which engine moves parts by forces, and which parts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import NODE
from virtualrobot.cli.options import Numbers, Target, target_options

if TYPE_CHECKING:
    from virtualrobot.physics import PhysicsStatus


@click.group(invoke_without_command=True)
@click.pass_context
@target_options
def physics(context: click.Context, target: Target) -> None:
    """Show or set which engine moves parts by forces, and which parts."""
    if context.invoked_subcommand is None:
        with target.connect() as client:
            click.echo("\n".join(status_lines(client.physics.status)))


@physics.command()
@click.argument("engine")
@click.option("--gravity", type=Numbers(3), metavar="X,Y,Z", help="Gravity in the world, m/s^2 [as it is].")
@click.option("--substeps", type=click.IntRange(min=1), metavar="N", help="The engine's steps in a tick [as it is].")
@target_options
def use(target: Target, engine: str, gravity: tuple[float, ...] | None, substeps: int | None) -> None:
    """Let ENGINE, such as mujoco, move parts; `none` lets forces move nothing."""
    with target.connect() as client:
        client.physics.set(engine, gravity=gravity, substeps=substeps)
        click.echo("\n".join(status_lines(client.physics.status)))


@physics.command()
@click.argument("parts", nargs=-1, required=True, type=NODE)
@target_options
def enable(target: Target, parts: tuple[str, ...]) -> None:
    """Let PARTS move by forces."""
    with target.connect() as client:
        client.physics.enable(*parts)


@physics.command()
@click.argument("parts", nargs=-1, required=True, type=NODE)
@target_options
def disable(target: Target, parts: tuple[str, ...]) -> None:
    """Let PARTS stay where they are."""
    with target.connect() as client:
        client.physics.disable(*parts)


def status_lines(status: PhysicsStatus) -> Iterator[str]:
    """Yield how physics are as lines."""
    if status.engine == "none":
        yield "nothing moves by forces; 'virtualrobot physics use mujoco' changes that"
        return
    x, y, z = status.gravity.tolist()
    yield f"{status.engine} moves parts, in {status.substeps} steps a tick; gravity is {x:g}, {y:g}, {z:g} m/s^2"
    if status.fault:
        yield f"nothing moves: {status.fault}"
    yield f"moving: {', '.join(status.moving_parts) or 'nothing'}"
    for one in status.contacts:
        x, y, z = one.force.tolist()
        yield f"{one.first} touches {one.second} by {x:.3g}, {y:.3g}, {z:.3g} N"
