"""Samples of a planned motion: joints, efforts and tool centre points at times of one's choice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.motion.resolved_rate import lever_arm
from virtualrobot_kernel.planning.carried_bases import CarriedBases
from virtualrobot_kernel.planning.dynamics import solve_inverse_dynamics
from virtualrobot_kernel.planning.foreseen import after
from virtualrobot_kernel.planning.program import GivenUp
from virtualrobot_kernel.planning.robots import Arm
from virtualrobot_kernel.planning.tool_states import singular_values, tool_chain, tool_states
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Node

MOST_NUMBERS = 500_000
"""Greatest number of numbers in one answer: as many as gRPC clients take by default, 4 MiB."""

CHUNK = 1000
"""Number of samples worked on at a time: between two chunks a caller who has given up is heard."""

END_TOLERANCE = 1e-9
"""Greatest distance (s) of a tick from a motion's end at which it is the end, as for a motion that runs."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ToolSamples:
    """Tool centre point of a robot's group in n samples.

    world_t_tcp (n, 4, 4), tcp_speeds (n,): m/s. singular_values (n,): of the Jacobian as lines and arcs are judged by;
    0 where no joint moves the flange.
    """

    group: Group
    world_t_tcp: Floats
    tcp_speeds: Floats
    singular_values: Floats


@dataclass(frozen=True, slots=True, eq=False)
class BaseSamples:
    """Base of a craft in n samples: its k coordinates by name, with their rates where each has one (n, k)."""

    names: tuple[str, ...]
    positions: Floats
    velocities: Floats
    accelerations: Floats


@dataclass(frozen=True, slots=True, eq=False)
class RobotSamples:
    """One robot's motion in n samples of k joints; `columns` (k,) are the joints' places among those of the motion.

    positions, velocities, accelerations, efforts (n, k): rad or m, per s, per s², N m or N. tools: of the robot itself,
    then of its groups that are moved. base: that of a craft whose drives the motion moves.
    """

    robot: Node
    joint_names: tuple[str, ...]
    columns: tuple[int, ...]
    positions: Floats
    velocities: Floats
    accelerations: Floats
    efforts: Floats
    tools: tuple[ToolSamples, ...]
    base: BaseSamples | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Motion in n samples: times (n,) in s from its start, the step (n,) that each belongs to, and its robots."""

    times: Floats
    steps: NDArray[np.int32]
    robots: tuple[RobotSamples, ...]


def sample_times(duration: float, seconds: float) -> Floats:
    """Return times (n,) every `seconds` from 0, the last one at the end, which is `duration`."""
    count = _count(duration, seconds)
    times = np.arange(count, dtype=np.float64) * seconds
    times[-1] = duration if count > 1 else 0.0
    return times


def check_size(duration: float, seconds: float, joints: int, robots: int) -> None:
    """Raise KernelError (TOO_LARGE) when a motion so long has more samples `seconds` apart than one answer holds."""
    most = MOST_NUMBERS // (2 + 4 * joints + 8 * robots)
    count = _count(duration, seconds)
    if count > most:
        raise KernelError(
            f"the motion of {joints} joints takes {duration:.6g} s, which is {count} samples {seconds:g} s apart; at "
            f"most {most} are told at a time; give sample_seconds of {1.01 * duration / (most - 1):.3g} or more",
            reason=Reason.TOO_LARGE,
            field="sample_seconds",
            samples=count,
            most=most,
        )


def _count(duration: float, seconds: float) -> int:
    return int(min(np.ceil((duration - END_TOLERANCE) / seconds), 2**53)) + 1 if duration > END_TOLERANCE else 1


def sampled(
    snapshot: Snapshot,
    program: Program,
    joints: Sequence[tuple[str, str]],
    times: Floats,
    given_up: GivenUp,
    arms: Sequence[Arm] = (),
    bases: CarriedBases | None = None,
) -> Samples:
    """Return the samples of a motion planned on `snapshot` at `times` (n,), growing from 0, at full speed factors.

    `joints` names the program's columns as (robot, joint). All else stands as it is in the snapshot, but for what steps
    of the program change, such as what is held; gravity, tools and held parts count as in `solve_inverse_dynamics`; for
    efforts a base that the motion moves stands still. `arms` are
    those that it is for: of their groups the tool centre points are told too. `bases` tells where drives take bases.
    """
    states = joint_states(program, times)
    steps = steps_at(program, times)
    worlds = after(snapshot, joints, program)
    ends = [*np.searchsorted(times, [begin for begin, _ in worlds[1:]]), len(times)]
    parts_of = [
        (world, slice(first, min(first + CHUNK, end)))
        for begin, end, (_, world) in zip([0, *ends[:-1]], ends, worlds, strict=True)
        for first in range(begin, end, CHUNK)
    ]
    nodes = [snapshot.structure.node(robot, Kind.ROBOT) for robot, _ in joints]
    places = [single_joint(snapshot.structure, node, name)[1] for node, (_, name) in zip(nodes, joints, strict=True)]
    carried = None if bases is None else _carried(bases, len(snapshot.state.q), places, times, states[1], given_up)
    robots = []
    for node in dict.fromkeys(nodes):
        columns = tuple(column for column, other in enumerate(nodes) if other is node)
        names = tuple(joints[column][1] for column in columns)
        q, v, a = (values[:, columns] for values in states)
        groups = tuple(dict.fromkeys((WHOLE, *(arm.group for arm in arms if arm.robot.uid == node.uid))))
        levers, efforts, tools = [_Lever() for _ in groups], [], [[] for _ in groups]
        for world, rows in parts_of:
            if given_up():
                raise KernelError("nobody waits for these samples any more")
            efforts.append(_efforts(world, node, names, q[rows], v[rows], a[rows]))
            everything = np.tile(world.state.q, (len(efforts[-1]), 1))
            rates = np.zeros_like(everything)
            everything[:, places], rates[:, places] = states[0][rows], states[1][rows]
            if bases is not None and carried is not None:
                everything[:, bases.places], rates[:, bases.places] = (values[rows] for values in carried)
            for group, lever, parts in zip(groups, levers, tools, strict=True):
                tool = tool_states(tool_chain(world, node, group), everything, rates)
                speeds = np.linalg.norm(tool.velocities, axis=1)
                parts.append((tool.world_t_tcp, speeds, lever.values(tool.jacobians, steps[rows])))
        told = tuple(
            ToolSamples(group, *(np.concatenate(column) for column in zip(*parts, strict=True)))
            for group, parts in zip(groups, tools, strict=True)
        )
        base = None
        if bases is not None and carried is not None:
            base = _base(snapshot, node, bases.places, times, *carried)
        robots.append(RobotSamples(node, names, columns, q, v, a, np.concatenate(efforts), told, base))
    return Samples(times, steps, tuple(robots))


def _carried(
    bases: CarriedBases, count: int, places: Sequence[int], times: Floats, velocities: Floats, given_up: GivenUp
) -> tuple[Floats, Floats]:
    """Return the coordinates of bases and their rates at times (n,), (n, k) each, of joints `places` of so many."""
    q, v = np.zeros((len(times), len(bases.places))), np.zeros((len(times), len(bases.places)))
    rates = np.zeros(count)
    for row, time in enumerate(times.tolist()):
        if row % CHUNK == 0 and given_up():
            raise KernelError("nobody waits for these samples any more")
        everything = bases.at(time)
        rates[places] = velocities[row]
        q[row], v[row] = everything[bases.places], bases.rates(everything, rates)
    return q, v


def _base(
    snapshot: Snapshot, node: Node, places: NDArray[np.int64], times: Floats, q: Floats, v: Floats
) -> BaseSamples | None:
    """Return the base of a robot among the carried coordinates (n, k); None where it is none of them."""
    by_place = {one.q: name for name, one in snapshot.structure.robots[node.uid].coordinates.items()}
    own = [column for column, place in enumerate(places.tolist()) if place in by_place]
    if not own:
        return None
    names = tuple(by_place[int(places[column])] for column in own)
    bends = np.gradient(v[:, own], times, axis=0) if len(times) > 1 else np.zeros((len(times), len(own)))
    return BaseSamples(names, q[:, own], v[:, own], bends)


def _efforts(snapshot: Snapshot, robot: Node, names: Sequence[str], q: Floats, v: Floats, a: Floats) -> Floats:
    """Return the efforts (n, k) of a robot's joints; those of planar and floating ones, which stand still, are 0."""
    found, joints = np.zeros_like(q), snapshot.structure.robots[robot.uid].joint_names
    own = [column for column, name in enumerate(names) if name in joints]
    if own:
        moved = [names[column] for column in own]
        found[:, own] = solve_inverse_dynamics(snapshot, robot, moved, q[:, own], v[:, own], a[:, own]).efforts
    return found


def joint_states(program: Program, times: Floats) -> tuple[Floats, Floats, Floats]:
    """Return positions, velocities and accelerations (n, k) of a program's joints at times (n,) at full rate.

    Of a motion that has one stage they are those of its ticks, bit for bit, where the times are as far apart as these.
    """
    taus = _added_up(times)
    q = np.tile(program.start, (len(times), 1))
    v, a = np.zeros_like(q), np.zeros_like(q)
    last = len(program.stages) - 1
    for number, (stage, begin) in enumerate(zip(program.stages, program.begins[:-1], strict=True)):
        if stage.plan is None:
            continue
        columns = np.array(stage.columns, np.intp)
        end = begin + stage.duration
        later = times >= (end - END_TOLERANCE if number == last else end)
        q[np.ix_(later, columns)] = stage.plan.goal
        during = np.flatnonzero((times >= begin) & ~later)
        if len(during):
            moving = stage.plan.at(taus[during] - begin)
            for whole, part in zip((q, v, a), moving, strict=True):
                whole[np.ix_(during, columns)] = part
    return q, v, a


def _added_up(times: Floats) -> Floats:
    """Return times (n,) as a motion has them: it adds the time of a tick to that before, and so rounds otherwise."""
    if len(times) < 2:
        return times
    sums = np.concatenate([[0.0], np.add.accumulate(np.full(len(times) - 1, times[1] - times[0]))])
    return np.where(np.abs(sums - times) <= END_TOLERANCE, sums, times)


def steps_at(program: Program, times: Floats) -> NDArray[np.int32]:
    """Return the step (n,) of a program that each time belongs to: the last one that has begun."""
    begun = [
        (begin + time, step)
        for stage, begin in zip(program.stages, program.begins[:-1], strict=True)
        for time, step in stage.steps
    ]
    begins = np.array([time for time, _ in begun])
    place = np.maximum(np.searchsorted(begins, times, side="right") - 1, 0)
    return np.array([step for _, step in begun], np.int32)[place]


class _Lever:
    """Lever arm (m) at the first sample of each step: it makes the rows of the step's Jacobians comparable."""

    def __init__(self) -> None:
        self._step, self._lever = -1, 1.0

    def values(self, jacobians: Floats, steps: NDArray[np.int32]) -> Floats:
        """Return the smallest singular values (n,) of the next Jacobians (n, 6, k)."""
        parts = []
        breaks = np.flatnonzero(np.diff(steps)) + 1
        for block, step in zip(np.split(jacobians, breaks), steps[[0, *breaks]], strict=True):
            if step != self._step:
                self._step, self._lever = int(step), lever_arm(block[0])
            parts.append(singular_values(block, self._lever))
        return np.concatenate(parts)
