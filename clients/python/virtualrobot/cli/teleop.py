"""`virtualrobot teleop`."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, FiniteRange, Target, target_options

if TYPE_CHECKING:
    from prompt_toolkit.input import Input
    from prompt_toolkit.output import Output

    from virtualrobot.robots.robot import Robot

ABOVE_ZERO = FiniteRange(0.0, min_open=True)

_EXAMPLES = """
\b
Examples:
  virtualrobot teleop ugv
  virtualrobot teleop ugv --speed 0.3 --turn 0.5
"""


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT)
@click.option("--speed", type=ABOVE_ZERO, default=0.3, help="The greatest speed in m/s [0.3].")
@click.option("--turn", type=ABOVE_ZERO, default=0.6, help="The greatest turning rate in rad/s [0.6].")
@click.option("--preempt", is_flag=True, help="Stop what the robot does and take over.")
@target_options
def teleop(target: Target, robot: str, speed: float, turn: float, preempt: bool) -> None:
    """Drive the craft ROBOT by the keys of this terminal, while one is held.

    Whatever ends this command stops the craft.
    """
    if sys.stdin is None or not sys.stdin.isatty():
        raise click.UsageError("keys need a terminal; without one use 'virtualrobot drive'")
    with target.connect() as client:
        if client.clock.mode == "stepped":
            raise click.UsageError(f"time stands still, and nothing would drive; {GO_ON}")
        drive_by_keys(client.robot(robot), speed, turn, preempt)


def drive_by_keys(
    robot: Robot,
    speed: float,
    turn: float,
    preempt: bool = False,
    source: Input | None = None,
    output: Output | None = None,
) -> None:
    """Drive a craft by the keys of a terminal, or of `source`, until q; speeds at most in m/s and rad/s."""
    from virtualrobot.cli.key_screen import KeyScreen
    from virtualrobot.cli.teleoperation import HELP, DriveKeys, Teleoperation

    keys = DriveKeys(speed, turn)
    with Teleoperation(robot, keys.twist, preempt) as driving:

        def text() -> str:
            x, y, heading = driving.place
            vx, vy, omega = driving.twist
            place = f"{robot.name} at {x:z.3f} {y:z.3f} m, {math.degrees(heading):z.1f} deg"
            told = f"{vx:z.2f} {vy:z.2f} m/s, {omega:z.2f} rad/s   {100.0 * keys.share:.0f}% of the limits"
            return f"{HELP}\n{place}   {told}\n{driving.error}"

        KeyScreen(keys.press, text).run(source, output)
    x, y, heading = driving.place
    click.echo(f"{robot.name} rests at {x:.3f}, {y:.3f} m, heading {heading:.3f} rad")
