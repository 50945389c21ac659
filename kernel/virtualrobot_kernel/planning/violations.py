"""Violations of limits by a planned motion: found on its polynomials where that is exact, else on its samples."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.brake import nominal_time
from virtualrobot_kernel.motion.limits import TOLERANCE
from virtualrobot_kernel.motion.planned import Plan, Track
from virtualrobot_kernel.motion.polynomial import Excursion, PiecewisePolynomial
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.planning.bodies import load_of
from virtualrobot_kernel.planning.carried_bases import CarriedBases
from virtualrobot_kernel.planning.dynamics import first_violation
from virtualrobot_kernel.planning.foreseen import after, at
from virtualrobot_kernel.planning.robots import Arm
from virtualrobot_kernel.planning.sampling import RobotSamples, Samples, joint_states, steps_at
from virtualrobot_kernel.planning.tool_states import tool_chain, tool_states
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, RobotData

SAMPLED_TOLERANCE = 1e-3
"""Share by which a law may exceed limits that its planner has verified on a grid of its own."""


class ViolationKind(Enum):
    """Kind of violation; the names equal those of `ViolationKind` in the contract."""

    JOINT_POSITION = "JOINT_POSITION"
    JOINT_VELOCITY = "JOINT_VELOCITY"
    JOINT_ACCELERATION = "JOINT_ACCELERATION"
    EFFORT = "EFFORT"
    REACH = "REACH"
    SINGULARITY = "SINGULARITY"
    OTHER = "OTHER"
    COLLISION = "COLLISION"
    PAYLOAD = "PAYLOAD"


@dataclass(frozen=True, slots=True, eq=False)
class Violation:
    """Violation of a limit by a motion, with time and place: see the message of this name in the contract.

    contact: the nodes (names) that touch, and the nearest point (3,) of each; None where it is another violation.
    step_path: what the step is called in the program's text.
    """

    kind: ViolationKind
    step: int
    robot: str
    joint: str
    time: float | None
    path_fraction: float | None
    world_t_tcp: Pose | None
    value: float
    limit: float
    message: str
    contact: tuple[tuple[str, NDArray[np.float64]], ...] | None = None
    step_path: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Two nodes (uids) of a world that touch on the way of a motion.

    time: s from its start. distance: m that they are apart then, less than `resolution`. points (2, 3): the nearest
    points of both, in the world's frame.
    """

    time: float
    first: int
    second: int
    distance: float
    resolution: float
    points: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Found:
    """Violation before its place is known: `column` is that of the joint, -1 for none."""

    time: float
    kind: ViolationKind
    robot: str
    column: int
    value: float
    limit: float
    group: Group = WHOLE


def first_of(
    snapshot: Snapshot,
    program: Program,
    joints: Sequence[tuple[str, str]],
    samples: Samples,
    min_singular_value: float,
    arms: Sequence[Arm] = (),
    bases: CarriedBases | None = None,
) -> Violation | None:
    """Return the first violation in time of a motion, whose columns are `joints` (robot, joint); None without one.

    Joint limits are those of `snapshot`. Positions are exact, and so are velocities and accelerations of joints that
    move by given times; efforts, the nearness to singularities, and what planners promise, are looked at where
    `samples` are. The tool centre point that is told is that of the arm, among `arms`, that the joint moves.
    """
    found = [*_exact(snapshot, program, joints), *_sampled(snapshot, joints, samples, min_singular_value)]
    found += _loaded(snapshot, program, joints)
    if not found:
        return None
    return _placed(snapshot, program, joints, min(found, key=lambda one: one.time), arms, bases)


def single_joints(snapshot: Snapshot, joints: Sequence[tuple[str, str]]) -> list[Joint]:
    """Return the joints of these names (robot, joint)."""
    structure = snapshot.structure
    return [single_joint(structure, structure.node(robot, Kind.ROBOT), name)[0] for robot, name in joints]


def _exact(snapshot: Snapshot, program: Program, joints: Sequence[tuple[str, str]]) -> Iterator[_Found]:
    """Yield the first excursion of each kind and track, between samples too."""
    limits = [joint.limits for joint in single_joints(snapshot, joints)]
    for stage, begin in zip(program.stages, program.begins[:-1], strict=True):
        if stage.plan is None:
            continue
        for track, columns in _tracks(stage.plan, stage.columns):
            own = [limits[column] for column in columns]
            lower, upper = np.array([one.lower for one in own]), np.array([one.upper for one in own])
            kinds = [(ViolationKind.JOINT_POSITION, track.path, lower, upper, 1.0)]
            rate = _rate(track)
            if rate:
                slope = track.rated.derivative()
                most = np.array([one.velocity for one in own])
                kinds.append((ViolationKind.JOINT_VELOCITY, slope, -most, most, rate))
                most = np.array([one.acceleration for one in own])
                kinds.append((ViolationKind.JOINT_ACCELERATION, slope.derivative(), -most, most, rate**2))
            for kind, function, low, high, factor in kinds:
                # Each side for itself: one piece may leave both, and the first counts, not the worst.
                for least, most in ((low, np.full_like(high, np.inf)), (np.full_like(low, -np.inf), high)):
                    excursion = function.first_excursion(least / factor, most / factor, TOLERANCE / factor)
                    if excursion is not None:
                        yield _found(kind, excursion, track, begin, joints, columns, low, high, factor)


def _found(
    kind: ViolationKind,
    excursion: Excursion,
    track: Track,
    begin: float,
    joints: Sequence[tuple[str, str]],
    columns: Sequence[int],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    factor: float,
) -> _Found:
    column = columns[excursion.component]
    value = excursion.value * factor
    limit = high if value > high[excursion.component] else low
    time = begin + nominal_time(track.time_law, excursion.entered, 0.0)
    return _Found(time, kind, joints[column][0], column, value, float(limit[excursion.component]))


def _sampled(
    snapshot: Snapshot, joints: Sequence[tuple[str, str]], samples: Samples, min_singular_value: float
) -> Iterator[_Found]:
    """Yield the first sample of each kind and robot that violates a limit."""
    known = single_joints(snapshot, joints)
    for robot in samples.robots:
        own = [known[column] for column in robot.columns]
        rates = (
            (ViolationKind.JOINT_VELOCITY, robot.velocities, [joint.limits.velocity for joint in own]),
            (ViolationKind.JOINT_ACCELERATION, robot.accelerations, [joint.limits.acceleration for joint in own]),
        )
        for kind, values, limits in rates:
            bad = np.argwhere(np.abs(values) > np.array(limits) * (1.0 + SAMPLED_TOLERANCE))
            for row, place in bad[:1].tolist():
                value = float(values[row, place])
                limit = float(np.copysign(limits[place], value))
                yield _Found(float(samples.times[row]), kind, robot.robot.name, robot.columns[place], value, limit)
        effort = first_violation(own, robot.efforts)
        if effort is not None:
            column = robot.columns[robot.joint_names.index(effort.joint)]
            limit = float(np.copysign(effort.limit, effort.effort))
            time = float(samples.times[effort.sample])
            yield _Found(time, ViolationKind.EFFORT, robot.robot.name, column, effort.effort, limit)
        for tool in robot.tools:
            if moves_arm(snapshot, robot, tool.group):
                near = np.flatnonzero(tool.singular_values < min_singular_value)
                for row in near[:1].tolist():
                    value, time = float(tool.singular_values[row]), float(samples.times[row])
                    kind, name = ViolationKind.SINGULARITY, robot.robot.name
                    yield _Found(time, kind, name, -1, value, min_singular_value, tool.group)


def _loaded(snapshot: Snapshot, program: Program, joints: Sequence[tuple[str, str]]) -> Iterator[_Found]:
    """Yield when a robot that moves begins to carry more than it may."""
    moved = [snapshot.structure.node(name, Kind.ROBOT) for name in dict(joints)]
    told = {node.name: node.data.payload_kilograms for node in moved if isinstance(node.data, RobotData)}
    limits = {name: limit for name, limit in told.items() if limit}
    for time, world in after(snapshot, joints, program) if limits else ():
        for name, limit in limits.items():
            load = load_of(world, world.structure.node(name, Kind.ROBOT))
            if load > limit * (1.0 + TOLERANCE):
                yield _Found(time, ViolationKind.PAYLOAD, name, -1, load, limit)


def moves_arm(snapshot: Snapshot, robot: RobotSamples, group: Group) -> bool:
    """Return whether one of the joints that move the flange, or the end of a group, is moved."""
    own = {single_joint(snapshot.structure, robot.robot, name)[1] for name in robot.joint_names}
    return not own.isdisjoint(tool_chain(snapshot, robot.robot, group).arm.tolist())


def _tracks(plan: Plan, columns: Sequence[int]) -> Iterator[tuple[Track, Sequence[int]]]:
    """Yield the tracks of a plan and the motion's columns that each has."""
    first = 0
    for track in plan.tracks:
        yield track, columns[first : first + track.path.dimension]
        first += track.path.dimension


def _rate(track: Track) -> float:
    """Return du/dtau of a track that moves by given times, 0 for one that has a law of its own."""
    law: PiecewisePolynomial = track.time_law
    return float(law.coefficients[0, 1, 0]) if law.coefficients.shape[:2] == (1, 2) else 0.0


def _placed(
    snapshot: Snapshot,
    program: Program,
    joints: Sequence[tuple[str, str]],
    found: _Found,
    arms: Sequence[Arm],
    bases: CarriedBases | None,
) -> Violation:
    """Return a violation with its place, in words too."""
    snapshot = at(after(snapshot, joints, program), found.time)
    joint = joints[found.column][1] if found.column >= 0 else ""
    group = found.group
    if joint:
        node = snapshot.structure.node(found.robot, Kind.ROBOT)
        group = _group_moved(arms, found.robot, single_joint(snapshot.structure, node, joint)[1])
    pose = tool_pose(snapshot, program, joints, found.robot, found.time, group, bases)
    where = f"after {found.time:.4g} s, {_at(pose)}"
    if found.kind is ViolationKind.SINGULARITY:
        message = (
            f"{found.robot!r}{group} comes too near to a singularity {where}: the smallest singular value of the "
            f"Jacobian is {found.value:.3g}, and at least {found.limit:g} is wanted"
        )
    elif found.kind is ViolationKind.PAYLOAD:
        message = (
            f"{found.robot!r} would carry {found.value:.4g} kg at its flange {where}; by its data sheet it may carry "
            f"{found.limit:g} kg"
        )
    else:
        slides = single_joints(snapshot, [joints[found.column]])[0].type is JointType.PRISMATIC
        what, unit = WORDS[found.kind][0], WORDS[found.kind][2 if slides else 1]
        message = (
            f"the joint {joint!r} of {found.robot!r} {what} {found.value:.6g} {unit} {where}; "
            f"its limit is {found.limit:.6g} {unit}"
        )
    step = int(steps_at(program, np.array([found.time]))[0])
    fraction = _fraction(program, joints, found)
    return Violation(
        *(found.kind, step, found.robot, joint, found.time, fraction, pose, found.value, found.limit, message),
        step_path=program.path_of(step),
    )


def _group_moved(arms: Sequence[Arm], robot: str, place: int) -> Group:
    """Return the group of the first arm of a robot that has the coordinate at `place` in q; without one WHOLE."""
    return next((arm.group for arm in arms if arm.robot.name == robot and place in arm.q_index), WHOLE)


def touching(
    snapshot: Snapshot,
    program: Program,
    joints: Sequence[tuple[str, str]],
    contact: Contact,
    arms: Sequence[Arm] = (),
    bases: CarriedBases | None = None,
) -> Violation:
    """Return the violation that a contact on the way of a motion is, with its place, in words too."""
    snapshot = at(after(snapshot, joints, program), contact.time)
    structure = snapshot.structure
    first, second = (structure.nodes[uid] for uid in (contact.first, contact.second))
    stage = program.stages[_stage_at(program, contact.time)]
    moved = {joints[column][0] for column in stage.columns} if stage.plan else {robot for robot, _ in joints}
    above = (node.name for uid in (first.uid, second.uid) for node in structure.ancestors(uid) if node.name in moved)
    robot = next(above, joints[0][0])
    found = _Found(contact.time, ViolationKind.COLLISION, robot, -1, contact.distance, contact.resolution)
    rows = (structure.rows[node.uid] for uid in (first.uid, second.uid) for node in structure.ancestors(uid))
    places = (place for row in rows for place in structure.coordinates_at(row))
    group = next((one for place in places if (one := _group_moved(arms, robot, place)) != WHOLE), WHOLE)
    pose = tool_pose(snapshot, program, joints, robot, contact.time, group, bases)
    when = f"after {contact.time:.4g} s" if contact.time > 0.0 else "where the motion starts"
    step = int(steps_at(program, np.array([contact.time]))[0])
    return Violation(
        kind=found.kind,
        step=step,
        robot=robot,
        joint="",
        time=contact.time,
        path_fraction=_fraction(program, joints, found),
        world_t_tcp=pose,
        value=contact.distance,
        limit=contact.resolution,
        message=f"{first.name!r} touches {second.name!r} {when}, {_at(pose)}",
        contact=((first.name, contact.points[0]), (second.name, contact.points[1])),
        step_path=program.path_of(step),
    )


def _at(world_t_tcp: Pose) -> str:
    x, y, z = world_t_tcp[:3, 3].tolist()
    return f"with the tool centre point at x {x:.4f}, y {y:.4f}, z {z:.4f} m"


WORDS = {
    ViolationKind.JOINT_POSITION: ("leaves its range, up to", "rad", "m"),
    ViolationKind.JOINT_VELOCITY: ("is too fast:", "rad/s", "m/s"),
    ViolationKind.JOINT_ACCELERATION: ("accelerates too much:", "rad/s^2", "m/s^2"),
    ViolationKind.EFFORT: ("would need", "N m", "N"),
}
"""Words for a violation of a joint, and the units for joints that turn and that slide."""


def tool_pose(
    snapshot: Snapshot,
    program: Program,
    joints: Sequence[tuple[str, str]],
    robot: str,
    time: float,
    group: Group = WHOLE,
    bases: CarriedBases | None = None,
) -> Pose:
    """Return world_t_tcp (4, 4) of a robot, or a group of it, at a time of a motion, in s; `bases` are carried."""
    node = snapshot.structure.node(robot, Kind.ROBOT)
    structure = snapshot.structure
    places = [single_joint(structure, structure.node(name, Kind.ROBOT), joint)[1] for name, joint in joints]
    q = snapshot.state.q[None].copy()
    q[:, places] = joint_states(program, np.array([time]))[0]
    if bases is not None:
        q[:, bases.places] = bases.at(time)[bases.places]
    return tool_states(tool_chain(snapshot, node, group), q, np.zeros_like(q)).world_t_tcp[0]


def _stage_at(program: Program, time: float) -> int:
    return int(np.clip(np.searchsorted(program.begins, time, side="right") - 1, 0, len(program.stages) - 1))


def _fraction(program: Program, joints: Sequence[tuple[str, str]], found: _Found) -> float | None:
    """Return the share of its step's path that is done, by the path parameter of the track that the violation is on."""
    own = {found.column} if found.column >= 0 else {at for at, (robot, _) in enumerate(joints) if robot == found.robot}
    place = _stage_at(program, found.time)
    stage, begin = program.stages[place], program.begins[place]
    if stage.plan is None:
        return None
    track = next((one for one, columns in _tracks(stage.plan, stage.columns) if not own.isdisjoint(columns)), None)
    if track is None:
        return None
    begins = [time for time, _ in stage.steps]
    step = max(int(np.searchsorted(begins, found.time - begin, side="right")) - 1, 0)
    first = begins[step]
    last = begins[step + 1] if step + 1 < len(begins) else stage.plan.duration
    u, low, high = (track.time_law.scalar_state(time)[0] for time in (found.time - begin, first, last))
    return float(np.clip((u - low) / (high - low), 0.0, 1.0)) if high > low else None
