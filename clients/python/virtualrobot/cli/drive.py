"""`virtualrobot drive`."""

from __future__ import annotations

import math

import click

from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, Target, degrees_option, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot drive husky --forward 0.5 --seconds 4
  virtualrobot drive husky --turn 30 --degrees --seconds 3
  virtualrobot drive platform --left 0.2 --seconds 2
"""


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT)
@click.option("--forward", type=float, default=0.0, metavar="SPEED", help="m/s; backwards below 0 [0].")
@click.option("--left", type=float, default=0.0, metavar="SPEED", help="m/s to the left, for crafts that can [0].")
@click.option("--turn", type=float, default=0.0, metavar="SPEED", help="rad/s to the left [0].")
@click.option("--seconds", type=click.FloatRange(0.0, min_open=True), required=True, help="How long.")
@click.option("--preempt", is_flag=True, help="Stop what the robot does and take over.")
@degrees_option
@target_options
def drive(
    target: Target,
    robot: str,
    forward: float,
    left: float,
    turn: float,
    seconds: float,
    preempt: bool,
    degrees: bool,
) -> None:
    """Drive a craft for some seconds of simulation time, brake, and tell where it rests.

    Ctrl-C stops it.
    """
    unit = math.radians(1.0) if degrees else 1.0
    with target.connect() as client:
        if client.clock.mode == "stepped":
            raise click.UsageError(f"time stands still, and nothing would drive; {GO_ON}")
        end = client.robot(robot).drive(forward, turn * unit, left=left, seconds=seconds, preempt=preempt)
        x, y, heading = end.positions
        click.echo(f"{robot} rests at {x:.3f}, {y:.3f} m, heading {heading / unit:.3f} {'°' if degrees else 'rad'}")
