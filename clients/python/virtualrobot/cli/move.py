"""`virtualrobot move` and `stop`."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.key_hold import check_terminal, hold_by_key, hold_option
from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, Target, target_options
from virtualrobot.cli.orders import Order, order_options

if TYPE_CHECKING:
    from virtualrobot.motions.motion import Motion
    from virtualrobot.motions.moves import Move
    from virtualrobot.robots.group import Group
    from virtualrobot.robots.robot import Robot

_BAR_WIDTH = 30
_EXAMPLES = """
\b
Examples:
  virtualrobot move arm --joints joint_1=0.5,joint_4=-1.2
  virtualrobot move arm --joints 0,45,0,-90,0,45,0 --degrees
  virtualrobot move arm --pose 0.5,0,0.3 --linear
  virtualrobot move arm --pose 0.5,0.2,0.3 --via 0.6,0.1,0.3
  virtualrobot move arm --to home --speed 0.3
  virtualrobot move baxter --group left_arm --pose 0.7,0.4,0.9
"""


@click.command(epilog=_EXAMPLES)
@order_options
@click.option("--preempt", is_flag=True, help="Stop what the robot does and take over.")
@click.option("--no-wait", is_flag=True, help="Return at once; the motion goes on.")
@hold_option
@target_options
def move(target: Target, robot: str, order: Order, preempt: bool, no_wait: bool, hold: bool) -> None:
    """Move a robot and show how far it is; Ctrl-C stops it on its path."""
    check_terminal(hold, no_wait)
    with target.connect() as client:
        handle = client.robot(robot)
        wish = order.move(handle)
        if client.clock.mode == "stepped" and not no_wait:
            click.echo(f"time stands still: the motion goes on with each 'virtualrobot step'; {GO_ON}", err=True)
        start_and_follow(handle, wish, preempt, no_wait, hold)


@click.command()
@click.argument("robots", nargs=-1, type=ROBOT)
@target_options
def stop(target: Target, robots: tuple[str, ...]) -> None:
    """Stop every motion, or every motion of the ROBOTS named; they slow down on their paths."""
    with target.connect() as client:
        motions = client.stop(*robots)
        for motion in motions:
            click.echo(f"stopped {motion.id} of {', '.join(motion.robots)}")
        if not motions:
            click.echo("nothing moves")


def start_and_follow(robot: Robot | Group, wish: Move, preempt: bool, no_wait: bool, hold: bool) -> None:
    """Start a move and show how far it is, or leave it alone."""
    on_disconnect = "continue" if no_wait else "stop"
    motion = robot.start(wish, wait=False, preempt=preempt, on_disconnect=on_disconnect, hold=hold)
    show_notes(motion)
    follow_to_its_end(motion, no_wait, hold)


def follow_to_its_end(motion: Motion, no_wait: bool, hold: bool) -> None:
    """Show how far a motion is until it is where it was to go, or leave it alone; `hold`: it is held by a key."""
    if no_wait:
        click.echo(f"started {motion.id}: {motion.planned_duration:.2f} s")
        return
    if hold:
        hold_by_key(motion)
        motion.wait()
    else:
        follow(motion)
    ends_early = any(note.kind == "JOG_ENDS" for note in motion.notes)
    click.echo(f"{motion.id} reached its {'end' if ends_early else 'goal'}")


def show_notes(motion: Motion) -> None:
    """Tell what the planner made other than it was asked to."""
    for note in motion.notes:
        if note.kind != "TOUCHING":  # that the library has logged
            click.echo(f"note: {note.message}", err=True)


def follow(motion: Motion) -> None:
    """Show how far a motion is until it has succeeded; Ctrl-C cancels it. Raises when somebody else cancelled it."""
    try:
        _drawn(motion)
    except KeyboardInterrupt:
        motion.cancel("interrupted from the keyboard")
        click.echo(f"{motion.id} cancelled", err=True)
        raise click.exceptions.Exit(130) from None
    motion.wait()


def _drawn(motion: Motion) -> None:
    """Wait for the end of a motion and draw a bar meanwhile where somebody looks."""
    shown, steps, name = sys.stdout.isatty(), motion.step_count, next(iter(motion.robots), motion.id)
    try:
        for state in motion.watch():
            if shown:
                bar = "#" * round(_BAR_WIDTH * state.progress)
                step = f"  step {state.step_path}, {state.step} of {state.step_count}" if steps else ""
                click.echo(f"\r{name}  [{bar:-<{_BAR_WIDTH}}] {100 * state.progress:3.0f}%{step}", nl=False)
    finally:
        if shown:
            click.echo()
