"""`virtualrobot physics`: which engine moves parts by forces, and which parts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import NODE
from virtualrobot.cli.options import Numbers, Target, WholeRange, target_options

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
@click.option("--substeps", type=WholeRange(min=1), metavar="N", help="The engine's steps in a tick [as it is].")
@target_options
def use(target: Target, engine: str, gravity: tuple[float, ...] | None, substeps: int | None) -> None:
    """Let ENGINE, such as mujoco, move parts; `none` lets forces move nothing."""
    with target.connect() as client:
        client.physics.set(engine, gravity=gravity, substeps=substeps)
        click.echo("\n".join(status_lines(client.physics.status)))


@physics.command()
@click.argument("names", nargs=-1, required=True, type=NODE)
@target_options
def enable(target: Target, names: tuple[str, ...]) -> None:
    """Let parts and robots, by their NAMES, move by forces."""
    with target.connect() as client:
        client.physics.enable(*names)


@physics.command()
@click.argument("names", nargs=-1, required=True, type=NODE)
@target_options
def disable(target: Target, names: tuple[str, ...]) -> None:
    """Let parts, by their NAMES, stay where they are, and robots move by their motions alone."""
    with target.connect() as client:
        client.physics.disable(*names)


@physics.command()
@click.argument("robot", type=NODE)
@click.argument("joint", required=False)
@click.argument("mode", required=False, type=click.Choice(["usual", "free", "velocity", "position", "effort"]))
@click.option("--stiffness", type=click.FloatRange(min=0.0), default=0.0, help="N m/rad or N/m, of position.")
@click.option("--damping", type=click.FloatRange(min=0.0), default=0.0, help="N m s/rad or N s/m, of position.")
@click.option("--max-effort", type=click.FloatRange(min=0.0), default=0.0, help="N m or N [that of the joint].")
@target_options
def motor(
    target: Target,
    robot: str,
    joint: str | None,
    mode: str | None,
    stiffness: float,
    damping: float,
    max_effort: float,
) -> None:
    """Show the motors of ROBOT, or set what that of JOINT does: MODE."""
    from virtualrobot.physics import JointMotor

    with target.connect() as client:
        if joint is not None:
            client.physics.set_motors(robot, {joint: JointMotor(mode or "usual", stiffness, damping, max_effort)})
        for name, one in client.physics.motors(robot).items():
            click.echo(
                f"{name}: {one.mode}, stiffness {one.stiffness:g}, damping {one.damping:g}, "
                f"greatest effort {one.max_effort:g}"
            )


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
