"""`virtualrobot teleop`."""

from __future__ import annotations

import asyncio
import math
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, FiniteRange, Target, target_options

if TYPE_CHECKING:
    from prompt_toolkit.input import Input
    from prompt_toolkit.output import Output

    from virtualrobot.cli.gamepad import Pad
    from virtualrobot.cli.gamepad_mapping import Control, GamepadMapping
    from virtualrobot.robots.robot import Robot

ABOVE_ZERO = FiniteRange(0.0, min_open=True)

_EXAMPLES = """
\b
Examples:
  virtualrobot teleop ugv
  virtualrobot teleop ugv --speed 0.3 --turn 0.5
  virtualrobot teleop ugv --gamepad
  virtualrobot teleop arm --space-mouse
"""

PAD_SECONDS = 0.02
"""Time (s) between two looks at a gamepad or a space mouse."""


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT)
@click.option("--speed", type=ABOVE_ZERO, default=0.3, help="The greatest speed in m/s [0.3].")
@click.option("--turn", type=ABOVE_ZERO, default=0.6, help="The greatest turning rate in rad/s [0.6].")
@click.option("--gamepad", is_flag=True, help="Drive by a gamepad, while its dead man's button is held.")
@click.option("--space-mouse", is_flag=True, help="The same by a space mouse, which moves an arm's tool.")
@click.option(
    "--mapping",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    metavar="FILE",
    help="What axes and buttons mean.",
)
@click.option("--preempt", is_flag=True, help="Stop what the robot does and take over.")
@target_options
def teleop(
    target: Target,
    robot: str,
    speed: float,
    turn: float,
    gamepad: bool,
    space_mouse: bool,
    mapping: Path | None,
    preempt: bool,
) -> None:
    """Drive the craft ROBOT by the keys of this terminal, while one is held.

    With --gamepad or --space-mouse by such a device, which moves the joints or the tool of a robot that is no craft.
    Whatever ends this command stops the robot.
    """
    if gamepad and space_mouse:
        raise click.UsageError("say --gamepad or --space-mouse, not both")
    if mapping is not None and not gamepad and not space_mouse:
        raise click.UsageError("--mapping is that of a gamepad: say --gamepad, too; or --space-mouse")
    if sys.stdin is None or not sys.stdin.isatty():
        raise click.UsageError(
            "keys need a terminal, and so do --gamepad and --space-mouse, to show what they do; without one use "
            "'virtualrobot drive'"
        )
    with target.connect() as client:
        if client.clock.mode == "stepped":
            raise click.UsageError(f"time stands still, and nothing would drive; {GO_ON}")
        if not gamepad and not space_mouse:
            drive_by_keys(client.robot(robot), speed, turn, preempt)
            return
        from virtualrobot.cli import gamepad_mapping
        from virtualrobot.cli.gamepad import Gamepad
        from virtualrobot.cli.space_mouse import SpaceMouse

        if space_mouse:
            meant = gamepad_mapping.read_mapping(
                mapping or gamepad_mapping.USUAL_SPACE_MOUSE, gamepad_mapping.SPACE_MOUSE
            )
        else:
            meant = gamepad_mapping.read_mapping(mapping or gamepad_mapping.USUAL)
        with SpaceMouse() if space_mouse else Gamepad() as pad:
            drive_by_pad(client.robot(robot), pad, meant, speed, turn, preempt)


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

    keys = DriveKeys((speed, speed, turn))
    with Teleoperation(robot, keys.wanted, preempt) as driving:

        def text() -> str:
            x, y, heading = driving.place
            vx, vy, omega = driving.twist
            place = f"{robot.name} at {x:z.3f} {y:z.3f} m, {math.degrees(heading):z.1f} deg"
            told = f"{vx:z.2f} {vy:z.2f} m/s, {omega:z.2f} rad/s   {100.0 * keys.share:.0f}% of the limits"
            return f"{HELP}\n{place}   {told}\n{driving.error}"

        KeyScreen(keys.press, text).run(source, output)
    x, y, heading = driving.place
    click.echo(f"{robot.name} rests at {x:.3f}, {y:.3f} m, heading {heading:.3f} rad")


def drive_by_pad(
    robot: Robot,
    pad: Pad,
    mapping: GamepadMapping,
    speed: float,
    turn: float,
    preempt: bool = False,
    source: Input | None = None,
    output: Output | None = None,
) -> None:
    """Drive a craft by a device until q, or move the joints or the tool of another robot.

    Speeds are at most in m/s and rad/s. Raises WrongStateError when the device has gone; the robot rests then.
    """
    from virtualrobot.cli.felt_force import FeltForce
    from virtualrobot.cli.gamepad import FeelingPad
    from virtualrobot.cli.gamepad_mapping import DIRECTIONS, TOOL
    from virtualrobot.cli.held_pad import HeldPad
    from virtualrobot.cli.key_screen import KeyScreen
    from virtualrobot.cli.space_mouse import within
    from virtualrobot.cli.teleoperation import Teleoperation, ToolLimits, Values
    from virtualrobot.errors import WrongStateError

    drives = is_craft(robot)
    tool = ToolLimits(mapping.frame, speed, turn) if mapping.tool and not drives else None
    joints = {} if drives or tool else joints_of(robot, mapping, speed, turn)
    if drives and not mapping.drive:
        raise WrongStateError(f"{robot.name!r} is a craft, and the mapping has no 'drive'")
    if joints:
        controls, limits = [control for control, _ in joints.values()], [limit for _, limit in joints.values()]
    elif tool:
        controls, limits = [mapping.tool.get(name) for name in TOOL], [speed] * 3 + [turn] * 3
    else:
        controls, limits = [mapping.drive.get(name) for name in DIRECTIONS], [speed, speed, turn]
    held = HeldPad(pad, mapping, controls, limits)

    def wanted() -> Values:
        return within(held.wanted(), speed, turn) if tool else held.wanted()

    felt: FeltForce | None = None

    async def follow() -> None:
        while True:
            held.read()
            if felt is not None and isinstance(pad, FeelingPad):
                pad.feel(felt.strength if held.is_held else 0.0)
            await asyncio.sleep(PAD_SECONDS)

    with ExitStack() as stack:
        if mapping.force is not None:
            if not isinstance(pad, FeelingPad):
                raise WrongStateError(f"{pad.name} lets nobody feel a force; leave `force` out of the mapping")
            felt = stack.enter_context(FeltForce(robot, mapping.force))
        moving = stack.enter_context(Teleoperation(robot, wanted, preempt, list(joints), tool))

        def text() -> str:
            told = ", ".join(f"{value:z.2f}" for value in moving.twist)
            names = ", ".join(joints) if joints else "m/s, rad/s" if tool else "m/s, m/s, rad/s"
            names += f"   slower by {by}" if (by := moving.held_by) else ""
            held_on = "" if held.is_held else f"   hold {mapping.hold} to move"
            share = f"{100.0 * held.share:.0f}% of the limits"
            wrong = moving.error or (felt.error if felt is not None else "")
            return f"{pad.name} moves {robot.name}{held_on}\n{told}   {names}   {share}\n{wrong}   q ends"

        KeyScreen(lambda key: None, text, follow=follow).run(source, output)
    click.echo(f"{robot.name} rests")


def is_craft(robot: Robot) -> bool:
    """Return whether a robot drives by twists."""
    from virtualrobot.errors import WrongStateError

    try:
        robot.way([])
    except WrongStateError:
        return False
    return True


def joints_of(robot: Robot, mapping: GamepadMapping, speed: float, turn: float) -> dict[str, tuple[Control, float]]:
    """Return the joints that a mapping moves, each with its control and its greatest speed (m/s or rad/s).

    Raises UnknownNameError for a joint that the robot lacks, and WrongStateError where the mapping moves none.
    """
    from virtualrobot.errors import UnknownNameError, WrongStateError

    limits, types = robot.limits, robot.joint_types
    names = [name for name in robot.joint_names if types[name] not in ("planar", "floating")]
    found: dict[str, tuple[Control, float]] = {}
    for said, control in mapping.jog.items():
        if said.isdecimal():
            # A mapping may be for robots of more joints.
            if not 0 < int(said) <= len(names):
                continue
            name = names[int(said) - 1]
        elif said in names:
            name = said
        else:
            raise UnknownNameError(f"{robot.name!r} has no joint {said!r}; its joints are {', '.join(names)}")
        found[name] = control, min(limits[name].velocity, speed if types[name] == "prismatic" else turn)
    if not found:
        raise WrongStateError(f"{robot.name!r} is no craft, and the mapping names no joint of it")
    return found
