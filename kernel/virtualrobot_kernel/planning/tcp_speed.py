"""Speed limits of tool centre points, as for teaching: what would be faster is planned again, slower."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import sqrt
from typing import TypeVar

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.foreseen import after
from virtualrobot_kernel.planning.moves import Move
from virtualrobot_kernel.planning.program import MoveStep, Step
from virtualrobot_kernel.planning.sampling import END_TOLERANCE, joint_states
from virtualrobot_kernel.planning.tool_states import tool_chain, tool_states
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.commands import StartMotion
from virtualrobot_kernel.world.groups import WHOLE
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

SAMPLE_SECONDS = 0.004
"""Time (s) between the samples in which speeds are looked at: a tick."""

CHUNK = 1000
"""Number of samples worked on at a time."""

MARGIN = 0.99
"""Share of the limit that is planned for, so that nothing between two samples is faster."""

CLOSE = 0.9
"""Share of the limit from which a motion counts as fast enough."""

MOST_TRIES = 8
"""Greatest number of plans of one motion that was too fast."""

Planned = TypeVar("Planned")


def kept(snapshot: Snapshot, plan: Callable[[float], Planned], command_of: Callable[[Planned], StartMotion]) -> Planned:
    """Return a plan whose tool centre points keep the speed limits of their robots.

    Args:
        snapshot: the world in which it is made, whose state has the limits.
        plan: makes it with all speed factors of moves multiplied by a factor, 1 at first.
        command_of: returns what a plan starts.

    Raises KernelError (LIMIT_EXCEEDED) where no factor does, as of a trajectory with times of its own.
    """
    planned, limits = plan(1.0), snapshot.state.tcp_speed_limits
    if not limits:
        return planned
    excess, robot, speed = _greatest(snapshot, command_of(planned), limits)
    if excess <= 1.0:
        return planned
    # A move that is too short for its greatest speed is as fast with a somewhat smaller factor, so the one that is just
    # right is looked for between one with which it is too fast and one with which it is slow enough.
    too_fast, slow_enough, best = 1.0, 0.0, None
    factor = MARGIN / excess
    for _ in range(MOST_TRIES):
        planned = plan(factor)
        excess, robot, speed = _greatest(snapshot, command_of(planned), limits)
        if excess <= 1.0:
            slow_enough, best = factor, planned
            if excess >= CLOSE:
                break
            factor = min(sqrt(slow_enough * too_fast), factor * MARGIN / excess)
        else:
            too_fast = factor
            factor = sqrt(slow_enough * too_fast) if best is not None else factor * MARGIN / excess
    if best is not None:
        return best
    raise KernelError(
        f"the tool centre point of {robot!r} would go at {speed:.3g} m/s, and its limit is {speed / excess:.3g} m/s "
        "(`set_tcp_speed_limit`), which a motion with times of its own can't be slowed to; give it longer times",
        reason=Reason.LIMIT_EXCEEDED,
        robot=robot,
        speed=speed,
        limit=speed / excess,
    )


def slower(steps: Sequence[Step], factor: float) -> tuple[Step, ...]:
    """Return steps with the speed factors of their moves multiplied by a factor."""
    if factor == 1.0:
        return tuple(steps)
    return tuple(
        replace(step, moves=slower_moves(step.moves, factor)) if isinstance(step, MoveStep) else step for step in steps
    )


def slower_moves(moves: Sequence[Move], factor: float) -> tuple[Move, ...]:
    """Return moves with their speed factors multiplied by a factor; one without keeps its times."""
    if factor == 1.0:
        return tuple(moves)
    given = [getattr(move, "speed_factor", None) for move in moves]
    return tuple(
        move if own is None else replace(move, **{"speed_factor": (own or 1.0) * factor})
        for move, own in zip(moves, given, strict=True)
    )


def _greatest(snapshot: Snapshot, command: StartMotion, limits: Mapping[int, float]) -> tuple[float, str, float]:
    """Return the greatest share of its limit that a tool centre point's speed has, its robot, and the speed (m/s)."""
    structure, program, joints = snapshot.structure, command.program, command.joints
    nodes = [structure.node(robot, Kind.ROBOT) for robot, _ in joints]
    places = [single_joint(structure, node, name)[1] for node, (_, name) in zip(nodes, joints, strict=True)]
    worlds = after(snapshot, joints, program)
    ends = [*(begin for begin, _ in worlds[1:]), program.duration + END_TOLERANCE]
    worst = (0.0, "", 0.0)
    for (begin, world), end in zip(worlds, ends, strict=True):
        times = np.arange(begin, end, SAMPLE_SECONDS)
        for first in range(0, len(times), CHUNK):
            q, v, _ = joint_states(program, times[first : first + CHUNK])
            everything = np.tile(world.state.q, (len(q), 1))
            rates = np.zeros_like(everything)
            everything[:, places], rates[:, places] = q, v
            for uid, limit in limits.items():
                robot = structure.nodes[uid]
                tool = tool_states(tool_chain(world, robot, WHOLE), everything, rates)
                speed = float(np.linalg.norm(tool.velocities, axis=1).max(initial=0.0))
                worst = max(worst, (speed / limit, robot.name, speed))
    return worst
