"""`virtualrobot driver ...` of robots that are connected, and `virtualrobot estop`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import FiniteRange, Target, target_options
from virtualrobot.cli.ports import ports
from virtualrobot.cli.settings import settings_from, settings_option
from virtualrobot.cli.state import stop_line

if TYPE_CHECKING:
    from virtualrobot.drivers import DriverJoint, DriverStatus


@click.command()
@click.argument("robot", type=ROBOT)
@click.argument("component")
@settings_option
@click.option(
    "--joint",
    "joints",
    multiple=True,
    metavar="NAME[,reversed][,OFFSET]",
    help="The controller's next joint: which joint of the robot it is, and where that is when it says 0 (rad or m).",
)
@click.option("--lead", type=FiniteRange(0.02, 0.4), help="How much later than its twin it does things, seconds [0.1].")
@click.option("--without-watchdog", is_flag=True, help="Consent to a controller that doesn't stop by itself.")
@target_options
def connect(
    target: Target,
    robot: str,
    component: str,
    values: tuple[str, ...],
    joints: tuple[str, ...],
    lead: float | None,
    without_watchdog: bool,
) -> None:
    """Connect ROBOT by the driver COMPONENT to its controller; nothing moves."""
    with target.connect() as client:
        schemas = {known.name: known.settings_schema for known in client.plugins.components("robot_driver")}
        status = client.drivers.connect(
            robot,
            component,
            settings_from(values, schemas.get(component, {})),
            joints=list(map(_joint, joints)),
            lead=lead,
            without_watchdog=without_watchdog,
        )
        said = status.controller
        name = " ".join(filter(None, (said.model, said.version, said.serial)))
        click.echo(f"{robot} is connected: {name or component}, {said.joint_count} joints, {said.rate:g} Hz")


@click.command()
@click.argument("robot", type=ROBOT)
@target_options
def disconnect(target: Target, robot: str) -> None:
    """End the driver of ROBOT; one that moves is stopped first."""
    with target.connect() as client:
        client.drivers.disconnect(robot)
        click.echo(f"{robot} has no driver any more")


@click.command(name="list")
@target_options
def list_drivers(target: Target) -> None:
    """Show which robots have a driver, and how it is."""
    with target.connect() as client:
        statuses, stop = client.drivers.list(), client.cell.stopped
    if stop:
        click.echo(stop_line(stop))
    click.echo("\n".join(map(_line, statuses)) or "no robot has a driver")


@click.command()
@click.argument("robot", type=ROBOT)
@click.argument("mode", type=click.Choice(["simulated", "monitor", "execute"]))
@target_options
def mode(target: Target, robot: str, mode: str) -> None:
    """Choose how ROBOT and its twin go together.

    execute needs a lease of the robot and ends with it: in 'virtualrobot shell', lease it first. After a fault motions
    of the robot are refused until its mode is chosen.
    """
    with target.connect() as client:
        click.echo(_line(client.drivers.set_mode(robot, mode)))


@click.command()
@click.argument("robot", type=ROBOT)
@target_options
def reset(target: Target, robot: str) -> None:
    """Clear a fault at the controller of ROBOT, and connect again; nothing moves."""
    with target.connect() as client:
        click.echo(_line(client.drivers.reset(robot)))


@click.command()
@click.argument("reason", required=False, default="")
@click.option("--release", is_flag=True, help="End the stop; nothing moves by that.")
@target_options
def estop(target: Target, reason: str, release: bool) -> None:
    """Stop the cell: all robots come to rest on their paths and stay so until --release. It is no safety function."""
    with target.connect() as client:
        if release:
            client.cell.release()
            click.echo("the stop has ended")
        else:
            client.cell.stop(reason)
            click.echo("the cell is stopped; --release ends that")


CONNECTING = (connect, disconnect, list_drivers, mode, ports, reset)
"""Commands of the group `driver` for robots that are, or will be, connected."""


def _joint(text: str) -> DriverJoint:
    from virtualrobot.drivers import DriverJoint

    name, *rest = text.split(",")
    offsets = [word for word in rest if word != "reversed"]
    try:
        return DriverJoint(name, "reversed" in rest, float(offsets[0]) if offsets else 0.0)
    except ValueError as error:
        raise click.UsageError(f"--joint is NAME[,reversed][,OFFSET], not {text!r}") from error


def _line(status: DriverStatus) -> str:
    words = f": {status.text}" if status.text else ""
    number = f" {status.code}" if status.code else ""
    halted = "; motions are refused until 'virtualrobot driver mode'" if status.halted else ""
    return f"{status.robot}  {status.component}  {status.mode}  {status.state}{number}{words}{halted}"
