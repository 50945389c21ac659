"""Check of a motion's limits and contacts: planned as it would be started, and never started."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import rotation_matrix

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.motion.resolved_rate import SMALLEST_SINGULAR_VALUE
from virtualrobot_kernel.planning.carried_bases import Follow
from virtualrobot_kernel.planning.moves import Move
from virtualrobot_kernel.planning.notes import Note
from virtualrobot_kernel.planning.plan_motion import PlannedMotion, plan_motion
from virtualrobot_kernel.planning.program import GivenUp, MotionSpec
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.relaxed import relaxed, solver_in
from virtualrobot_kernel.planning.robots import SolverOf, arm_of
from virtualrobot_kernel.planning.sampling import Samples, sample_times, sampled
from virtualrobot_kernel.planning.together import moved_arms
from virtualrobot_kernel.planning.violations import Contact, Violation, ViolationKind, first_of, moves_arm, touching
from virtualrobot_kernel.world.commands import StartMotion
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

MOST_SAMPLES = 100_000
"""Greatest number of samples of a check, about; a motion of more ticks is sampled more thinly."""

ANSWERS = (Reason.LIMIT_EXCEEDED, Reason.UNREACHABLE, Reason.SINGULARITY)
"""Reasons to refuse a motion that is understood: for a check these are answers."""


FirstContact = Callable[[Snapshot, StartMotion, float], Contact | None]
"""First contact of a motion that starts in a world, before a time of it (s); None: there is none."""


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """Result of a check: the first violation (None: none), and the motion's measures if it can be planned.

    duration: s, 0 where it can't be planned. min_singular_value: of those arms that move, None where none does.
    planned: what was looked at; None where it can't be planned.
    """

    first_violation: Violation | None
    duration: float = 0.0
    min_singular_value: float | None = None
    notes: tuple[Note, ...] = ()
    planned: PlannedMotion | None = None


def check_motion(
    snapshot: Snapshot,
    spec: MotionSpec,
    solver_of: SolverOf,
    min_singular_value: float,
    given_up: GivenUp,
    first_contact: FirstContact | None = None,
    near_of: NearOf | None = None,
    follow: Follow | None = None,
) -> Checked:
    """Return whether a motion keeps all limits, and else the first one in time that it violates.

    With `first_contact` it is looked for contacts, too: one that is sooner than any other violation is told. `follow`
    tells where drives take bases.

    A motion that meets the ends of joints, or moves faster than they can by times of its own, is planned as if there
    were no ends, to find where it does; one that can't be planned even so is told with the place that its planner
    names. Raises KernelError for what is no motion at all, such as unknown names.
    """
    try:
        planned = plan_motion(snapshot, spec, solver_of, given_up, near_of)
    except KernelError as error:
        if error.reason not in ANSWERS:
            raise
        return _refused(snapshot, spec, solver_of, min_singular_value, given_up, first_contact, near_of, follow, error)
    return check_planned(snapshot, spec, planned, min_singular_value, given_up, first_contact, follow)


def check_planned(
    snapshot: Snapshot,
    spec: MotionSpec,
    planned: PlannedMotion,
    min_singular_value: float,
    given_up: GivenUp,
    first_contact: FirstContact | None = None,
    follow: Follow | None = None,
) -> Checked:
    """Return whether a motion that was planned keeps all limits as it is; see `check_motion`."""
    found = _looked_at(snapshot, snapshot, spec, planned, min_singular_value, given_up, first_contact, follow)
    return replace(found, planned=planned)


def _looked_at(
    snapshot: Snapshot,
    planned_on: Snapshot,
    spec: MotionSpec,
    planned: PlannedMotion,
    min_singular_value: float,
    given_up: GivenUp,
    first_contact: FirstContact | None,
    follow: Follow | None,
) -> Checked:
    """Return the check of a planned motion against the limits of `snapshot`."""
    program, joints = planned.command.program, planned.command.joints
    arms = moved_arms(planned_on, spec.every_move)
    bases = None if follow is None else follow(snapshot, program, joints)
    samples = sampled(planned_on, program, joints, _times(program, snapshot.tick_seconds), given_up, arms, bases)
    violation = first_of(snapshot, program, joints, samples, min_singular_value, arms, bases)
    if first_contact is not None:
        until = program.duration if violation is None or violation.time is None else violation.time
        contact = first_contact(snapshot, planned.command, until)
        if contact is not None:
            violation = touching(snapshot, program, joints, contact, arms, bases)
    return Checked(violation, program.duration, _least_singular_value(snapshot, samples), planned.notes)


def _times(program: Program, tick_seconds: float) -> NDArray[np.float64]:
    """Return the times (n,) at which a motion is looked at: each tick of its stages, and their ends."""
    moving = [(begin, one.duration) for begin, one in zip(program.begins, program.stages, strict=False) if one.plan]
    seconds = max(tick_seconds, sum(duration for _, duration in moving) / MOST_SAMPLES)
    return np.unique([0.0, *(begin + time for begin, duration in moving for time in sample_times(duration, seconds))])


def _least_singular_value(snapshot: Snapshot, samples: Samples) -> float | None:
    values = [
        float(tool.singular_values.min())
        for robot in samples.robots
        for tool in robot.tools
        if moves_arm(snapshot, robot, tool.group)
    ]
    return min(values, default=None)


def _refused(
    snapshot: Snapshot,
    spec: MotionSpec,
    solver_of: SolverOf,
    min_singular_value: float,
    given_up: GivenUp,
    first_contact: FirstContact | None,
    near_of: NearOf | None,
    follow: Follow | None,
    error: KernelError,
) -> Checked:
    """Return the first violation of a motion that can't be planned."""
    if error.reason is Reason.LIMIT_EXCEEDED:
        loose = relaxed(snapshot, *_relaxable(snapshot, spec.every_move))
        try:
            planned = plan_motion(loose, spec, solver_in(snapshot, solver_of), given_up, near_of)
        except KernelError as other:
            if other.reason not in ANSWERS:
                raise
        else:
            found = _looked_at(snapshot, loose, spec, planned, min_singular_value, given_up, first_contact, follow)
            if found.first_violation is not None:
                return Checked(found.first_violation)
    if (step := int(error.metadata.get("step", "0"))) > 0:
        # What the steps before it violate comes first.
        steps = replace(spec, steps=spec.steps[:step])
        before = check_motion(snapshot, steps, solver_of, min_singular_value, given_up, first_contact, near_of, follow)
        if before.first_violation is not None:
            return Checked(before.first_violation)
    return Checked(_told_by(snapshot, error))


def _relaxable(snapshot: Snapshot, moves: tuple[Move, ...]) -> tuple[set[int], set[tuple[int, str]]]:
    """Return the robots (uids) of moves, and the joints (robot uid, name) that none but timed moves may move."""
    robots: set[int] = set()
    timed: set[tuple[int, str]] = set()
    otherwise: set[int] = set()
    for move in moves:
        uid = snapshot.structure.node(move.robot, Kind.ROBOT).uid
        robots.add(uid)
        if move.timed:
            timed |= {(uid, name) for name in move.joint_names(snapshot)}
        else:
            otherwise.add(uid)
    return robots, {joint for joint in timed if joint[0] not in otherwise}


def _told_by(snapshot: Snapshot, error: KernelError) -> Violation:
    """Return the violation that a planner's refusal tells."""
    told = error.metadata
    robot = told.get("robot", "")
    if error.reason is Reason.SINGULARITY:
        kind, value, limit = ViolationKind.SINGULARITY, told.get("singular_value"), SMALLEST_SINGULAR_VALUE
    elif error.reason is Reason.UNREACHABLE:
        kind, value, limit = ViolationKind.REACH, told.get("position_error_meters"), 0.0
    else:
        at_limit = ("joint" in told and "lower" in told) or "position_error_meters" in told
        kind = ViolationKind.JOINT_POSITION if at_limit else ViolationKind.OTHER
        value = told.get("value")
        ends = [float(told[end]) for end in ("lower", "upper", "limit") if end in told]
        limit = min(ends, key=lambda end: abs(end - float(value or 0.0)), default=0.0)
    fraction = told.get("fraction")
    return Violation(
        kind=kind,
        step=int(told.get("step", "0")),
        robot=robot,
        joint=told.get("joint", ""),
        time=None,
        path_fraction=None if fraction is None else float(fraction),
        world_t_tcp=_place(snapshot, robot, told.get("base"), told.get("position"), told.get("rotation")),
        value=float(value or 0.0),
        limit=limit,
        message=str(error),
        step_path=told.get("step_path", told.get("step", "0")),
    )


def _place(snapshot: Snapshot, robot: str, base: str | None, position: str | None, rotation: str | None) -> Pose | None:
    """Return world_t_tcp (4, 4) of a place that is told in the frame of the node `base` or the robot's, if one is."""
    if not (robot and position and rotation):
        return None
    base_t_tcp = np.eye(4)
    base_t_tcp[:3, 3] = [float(part) for part in position.split(",")]
    base_t_tcp[:3, :3] = rotation_matrix(np.array([float(part) for part in rotation.split(",")]))
    structure = snapshot.structure
    frame = structure.node(base).uid if base else arm_of(snapshot, structure.node(robot, Kind.ROBOT)).base
    return snapshot.world_t(frame) @ base_t_tcp
