"""`virtualrobot teleop`."""

from __future__ import annotations

import math
import sys
import threading
import time
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, FiniteRange, Target, target_options

if TYPE_CHECKING:
    from prompt_toolkit.input import Input
    from prompt_toolkit.output import Output

    from virtualrobot.cli.teleoperation import Limits
    from virtualrobot.robots.robot import Robot

ABOVE_ZERO = FiniteRange(0.0, min_open=True)

_EXAMPLES = """
\b
Examples:
  virtualrobot teleop ugv
  virtualrobot teleop ugv --speed 0.3 --turn 0.5
  virtualrobot teleop ugv --gamepad 0 --dead-man BTN_TR
"""


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT)
@click.option("--speed", type=ABOVE_ZERO, default=0.5, help="The greatest speed [0.5 m/s].")
@click.option("--turn", type=ABOVE_ZERO, default=1.0, help="The greatest turning rate [1 rad/s].")
@click.option("--gamepad", type=click.IntRange(min=0), metavar="NUMBER", help="By a gamepad, from 0, not by keys.")
@click.option("--dead-man", default="BTN_TL", help="The button of it that is held while it drives [BTN_TL].")
@click.option(
    "--axis-range", type=(float, float), default=(-32768.0, 32767.0), help="What its axes tell at their ends."
)
@target_options
def teleop(
    target: Target,
    robot: str,
    speed: float,
    turn: float,
    gamepad: int | None,
    dead_man: str,
    axis_range: tuple[float, float],
) -> None:
    """Drive the craft ROBOT by the keys of this terminal, or by a gamepad.

    It drives while a key, or the dead man's button, is held. Whatever ends this command stops it.
    """
    from virtualrobot.cli.teleoperation import Gamepad, HeldGamepad, Limits, Teleoperation

    if not axis_range[0] < axis_range[1]:
        raise click.UsageError(f"--axis-range gives the lower end first, not {axis_range[0]:g} {axis_range[1]:g}")
    if gamepad is None and (sys.stdin is None or not sys.stdin.isatty()):
        raise click.UsageError("keys need a terminal; without one give --gamepad, or use 'virtualrobot drive'")
    limits = Limits(speed, turn)
    with target.connect() as client:
        if client.clock.mode == "stepped":
            raise click.UsageError(f"time stands still, and nothing would drive; {GO_ON}")
        handle = client.robots[robot]
        if gamepad is None:
            teleop_by_keys(handle, limits)
            return
        from virtualrobot.cli.gamepad import events

        held = HeldGamepad(limits, Gamepad(dead_man=dead_man, lowest=axis_range[0], highest=axis_range[1]))
        source = events(gamepad)
        threading.Thread(target=held.follow, args=(source,), name="gamepad", daemon=True).start()
        click.echo(f"hold {dead_man} to drive {robot}; Ctrl-C ends")
        try:
            with Teleoperation(handle, held.twist) as driving:
                while not held.gone:
                    time.sleep(0.1)
                    if driving.error is not None:
                        click.echo(f"{robot}: {driving.error}", err=True)
                        driving.error = None
            click.echo("the gamepad has gone", err=True)
        except KeyboardInterrupt:
            click.echo(f"{robot} rests")


def teleop_by_keys(robot: Robot, limits: Limits, source: Input | None = None, output: Output | None = None) -> None:
    """Drive a craft by the keys of a terminal, or of `source`, until q."""
    from virtualrobot.cli.key_screen import KeyScreen
    from virtualrobot.cli.teleoperation import HELP, HeldKeys, Teleoperation

    held = HeldKeys(limits)
    with Teleoperation(robot, held.twist) as driving:

        def text() -> str:
            x, y, heading = driving.place
            vx, vy, omega = driving.twist
            told = f"told {vx:z.2f} {vy:z.2f} m/s {omega:z.2f} rad/s   {round(100 * held.scale)}% of the limits"
            said = f"\n{driving.error}" if driving.error is not None else ""
            return f"{HELP}\n{robot.name} at {x:z.3f} {y:z.3f} m {math.degrees(heading):z.1f} deg   {told}{said}"

        KeyScreen(held.press, text).run(source, output)
    x, y, heading = driving.place
    click.echo(f"{robot.name} rests at {x:.3f}, {y:.3f} m, heading {heading:.3f} rad")
