"""`virtualrobot state`, `leases` and `step`: what is where, who has it, and how time runs."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, Target, degrees_option, target_options
from virtualrobot.cli.signals import signal_text

if TYPE_CHECKING:
    from virtualrobot.cell import CellStop
    from virtualrobot.connection import Client
    from virtualrobot.motions.motion import Motion

_WATCH_SECONDS = 0.2


@click.command()
@click.argument("robots", nargs=-1, type=ROBOT)
@click.option("--watch", is_flag=True, help="Go on until Ctrl-C.")
@degrees_option
@target_options
def state(target: Target, robots: tuple[str, ...], watch: bool, degrees: bool) -> None:
    """Show clock, robots (all, or those named), signals and motions."""
    with target.connect() as client:
        text = describe(client, robots, degrees)
        click.echo(text)
        while watch:
            time.sleep(_WATCH_SECONDS)
            lines = text.count("\n") + 1
            text = describe(client, robots, degrees)
            # On a terminal draw over what is there; elsewhere one after the other.
            above = f"\x1b[{lines}A\x1b[J" if sys.stdout.isatty() else "\n"
            click.echo(above + text)


@click.command()
@target_options
def leases(target: Target) -> None:
    """Show who has leased which robots, and since when; those that are not shown can be moved by anyone."""
    with target.connect() as client:
        for lease in client.leases():
            since = lease.since.astimezone().strftime("%Y-%m-%d %H:%M:%S")
            click.echo(f"{', '.join(lease.robots) or 'no robot any more'}: {lease.owner}, since {since} ({lease.id})")


@click.command()
@click.argument("ticks", type=click.IntRange(1), default=1)
@click.option("--realtime", is_flag=True, help="Afterwards let time follow the wall clock again.")
@target_options
def step(target: Target, ticks: int, realtime: bool) -> None:
    """Let time go on by TICKS ticks; the kernel's clock is `stepped` then.

    A clock that follows the wall is set to `stepped` first; a kernel started by `virtualrobot serve --stepped` is so
    from the beginning.
    """
    with target.connect() as client:
        if client.clock.mode != "stepped":
            client.clock.set_stepped()
            if not realtime:
                click.echo(f"time stands still now but for steps; {GO_ON}", err=True)
        stamp = client.clock.step(ticks).stamp
        click.echo(f"tick {stamp.tick}, {stamp.simulation_time:.3f} s")
        if realtime:
            client.clock.set_realtime()


def describe(client: Client, robots: Sequence[str], degrees: bool) -> str:
    """Return clock, robots, signals and running motions as text."""
    from virtualrobot.robots.values import RobotState
    from virtualrobot.tables import aligned, joint_rows
    from virtualrobot.v1 import robot_pb2

    clock = client.clock.read()
    lines = [
        f"{clock.mode} clock: {clock.stamp.simulation_time:.3f} s, tick {clock.stamp.tick} of "
        f"{1000 * clock.tick_length:g} ms, real-time factor {clock.real_time_factor:.2f}"
    ]
    if (stop := client.cell.stopped) is not None:
        lines.append(stop_line(stop))
    answer = client.services.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest(names=robots))
    for message in answer.robots:
        robot, now = client.robot(message.name), RobotState.of(message, answer.stamp)
        lines += ["", f"{robot.name}  speed factor {now.speed_factor:g}  {_tools(now.tool, now.tool_states)}".rstrip()]
        lines.append("  tcp  " + _place(now.world_t_tcp, degrees))
        lines += [f"  groups  {names}"] if (names := ", ".join(robot.groups)) else []
        lines += [f"  {line}" for line in aligned(joint_rows(robot, now, degrees))]
    if not robots:
        signals = client.signals.read()
        lines += [""] * bool(signals)
        lines += [f"signal {signal.name}: {signal_text(signal)}" for signal in signals]
    motions = [motion for motion in client.motions() if not robots or set(motion.robots) & set(robots)]
    lines += [""] * bool(motions)
    lines += [_motion(motion) for motion in motions]
    return "\n".join(lines)


def stop_line(stop: CellStop) -> str:
    """Return the line of a stop of the cell."""
    since = stop.time.astimezone().strftime("%Y-%m-%d %H:%M:%S")
    return f"the cell is stopped by {stop.by}, since {since}: {stop.reason}"


def _motion(motion: Motion) -> str:
    robots = f" of {', '.join(motion.robots)}" if motion.robots else ""
    now = motion.state
    step = f", step {now.step} of {now.step_count}" if now.step_count else ""
    step += f" ({now.step_path})" if now.step_path not in ("", str(now.step)) else ""
    return f"motion {now.id}{robots}: {now.phase.name.lower()}, {100 * now.progress:.0f}%{step}"


def _tools(chosen: str, states: dict[str, str]) -> str:
    return "  ".join(
        f"{'*' if tool == chosen else ''}{tool}{f' ({state})' if state else ''}" for tool, state in states.items()
    )


def _place(world_t_tcp: object, degrees: bool) -> str:
    import numpy as np

    from virtualrobot.geometry import roll_pitch_yaw_of

    matrix = np.asarray(world_t_tcp)
    angles = roll_pitch_yaw_of(matrix)
    angles = np.degrees(angles) if degrees else angles
    unit = "deg" if degrees else "rad"
    x, y, z, roll, pitch, yaw = (f"{value:z.4f}" for value in (*matrix[:3, 3], *angles))
    return f"{x} {y} {z} m   roll pitch yaw {roll} {pitch} {yaw} {unit}"
