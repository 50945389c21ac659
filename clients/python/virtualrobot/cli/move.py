"""`virtualrobot move` and `stop`."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.options import GO_ON, Numbers, Target, degrees_option, pose_of_numbers, target_options

if TYPE_CHECKING:
    from virtualrobot.motion import Motion
    from virtualrobot.robot import Robot
    from virtualrobot.v1 import motion_pb2

_BAR_WIDTH = 30
_EXAMPLES = """
\b
Examples:
  virtualrobot move arm --joints joint_1=0.5,joint_4=-1.2
  virtualrobot move arm --joints 0,45,0,-90,0,45,0 --degrees
  virtualrobot move arm --pose 0.5,0,0.3 --linear
  virtualrobot move arm --pose 0.5,0.2,0.3 --via 0.6,0.1,0.3
  virtualrobot move arm --to home --speed 0.3
"""


@click.command(epilog=_EXAMPLES)
@click.argument("robot")
@click.argument("more", nargs=-1, metavar="[JOINT=VALUE]...")
@click.option("--joints", metavar="VALUES", help="JOINT=VALUE,... or all values in order: 0,0.5,0,-1.2,0,0.8,0")
@click.option("--pose", "pose", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="Where the tool centre point goes.")
@click.option("--to", "posture", metavar="POSTURE", help="A posture with a name, such as home.")
@click.option("--reference", default="", help="The node in whose frame the pose is given [world].")
@click.option("--linear", is_flag=True, help="Along a straight line; with --pose.")
@click.option("--via", type=Numbers(3), metavar="X,Y,Z", help="Along an arc through this point; with --pose.")
@click.option("--speed", type=float, default=1.0, help="The part of the greatest joint speed, above 0, up to 1 [1].")
@click.option("--preempt", is_flag=True, help="Stop what the robot does and take over.")
@click.option("--no-wait", is_flag=True, help="Return at once; the motion goes on.")
@degrees_option
@target_options
def move(
    target: Target,
    robot: str,
    more: tuple[str, ...],
    joints: str | None,
    pose: tuple[float, ...] | None,
    posture: str | None,
    reference: str,
    linear: bool,
    via: tuple[float, ...] | None,
    speed: float,
    preempt: bool,
    no_wait: bool,
    degrees: bool,
) -> None:
    """Move a robot and show how far it is; Ctrl-C stops it on its path."""
    words = [word for word in (joints, *more) if word]
    if bool(words) + (pose is not None) + bool(posture) != 1:
        raise click.UsageError("say where to, in one way: --joints, --pose or --to")
    if linear and pose is None:
        raise click.UsageError("--linear goes with --pose")
    if via is not None and (pose is None or linear):
        raise click.UsageError("--via goes with --pose and without --linear")
    if not 0 < speed <= 1:
        raise click.UsageError(f"--speed is above 0, up to 1, not {speed:g}")
    with target.connect() as client:
        handle = client.robot(robot)
        if pose is None:
            goal = posture or joint_goal(handle, words, degrees)
            order = handle.ptp(goal, speed_factor=speed)
        else:
            where = pose_of_numbers(pose, degrees, handle.tcp if not reference else None)
            if via is not None:
                order = handle.circular(via, where, reference=reference, speed_factor=speed)
            else:
                make = handle.linear if linear else handle.ptp
                order = make(where, reference=reference, speed_factor=speed)
        if client.clock.mode == "stepped" and not no_wait:
            click.echo(f"time stands still: the motion goes on with each 'virtualrobot step'; {GO_ON}", err=True)
        _start(handle, order, preempt, no_wait)


@click.command()
@click.argument("robots", nargs=-1)
@target_options
def stop(target: Target, robots: tuple[str, ...]) -> None:
    """Stop every motion, or every motion of the ROBOTS named; they slow down on their paths."""
    with target.connect() as client:
        motions = client.stop(*robots)
        for motion in motions:
            click.echo(f"stopped {motion.id} of {', '.join(motion.robots)}")
        if not motions:
            click.echo("nothing moves")


def joint_goal(robot: Robot, words: Sequence[str], degrees: bool) -> dict[str, float] | list[float]:
    """Return joint values by name from `name=value` words, or in order from numbers; `degrees` for turning joints."""
    from virtualrobot.errors import UnknownNameError
    from virtualrobot.v1 import nodes_pb2

    entries = [entry for word in words for entry in re.split(r"[\s,]+", word.strip(" ,"))]
    named = ["=" in entry for entry in entries]
    if any(named) and not all(named):
        raise click.UsageError("give joint values either all by name or all in order")
    try:
        values = [float(entry.rpartition("=")[2]) for entry in entries]
    except ValueError:
        raise click.UsageError(f"{' '.join(words)!r} are no joint values: name=value,... or numbers") from None
    if not degrees:
        return dict(zip((e.rpartition("=")[0] for e in entries), values, strict=True)) if all(named) else values
    description = robot.description
    sliding = {joint.name for joint in description.joints if joint.type == nodes_pb2.JOINT_TYPE_PRISMATIC}
    every = [joint.name for joint in description.joints]
    if all(named):
        names = [entry.rpartition("=")[0] for entry in entries]
        if unknown := sorted(set(names) - set(every)):
            raise UnknownNameError(f"the robot {robot.name!r} has no joint {unknown[0]!r}; it has {', '.join(every)}")
    else:
        names = every if len(values) == len(every) else list(description.chain_joints)
        if len(names) != len(values):
            return values  # the robot says what is wrong
    return {n: v if n in sliding else math.radians(v) for n, v in zip(names, values, strict=True)}


def _start(robot: Robot, order: motion_pb2.Move, preempt: bool, no_wait: bool) -> None:
    """Start a move and show how far it is, or leave it alone."""
    motion = robot.start(order, wait=False, preempt=preempt, on_disconnect="continue" if no_wait else "stop")
    if no_wait:
        click.echo(f"started {motion.id}: {motion.planned_duration_seconds:.2f} s")
        return
    try:
        _follow(motion)
    except KeyboardInterrupt:
        motion.cancel("interrupted from the keyboard")
        click.echo(f"{motion.id} cancelled", err=True)
        raise click.exceptions.Exit(130) from None
    motion.wait()  # raises when somebody else cancelled it
    click.echo(f"{motion.id} reached its goal")


def _follow(motion: Motion) -> None:
    """Wait for the end of a motion and draw a bar meanwhile where somebody looks."""
    shown = sys.stdout.isatty()
    try:
        for message in motion.watch():
            if shown:
                bar = "#" * round(_BAR_WIDTH * message.progress)
                click.echo(f"\r{motion.robots[0]}  [{bar:-<{_BAR_WIDTH}}] {100 * message.progress:3.0f}%", nl=False)
    finally:
        if shown:
            click.echo()
