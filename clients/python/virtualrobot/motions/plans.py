"""Motions before they move: planned in samples, and checked against all limits and for collisions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.messages import array_of, pose_of, value_or_default
from virtualrobot._wire.options import check_options
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix, poses_from_rows
from virtualrobot.motions.motion import Motion, StartOptions, Tracking, check_not_empty, start_request
from virtualrobot.motions.moves import Move, messages_of
from virtualrobot.motions.state import PlanNote, PlanReference
from virtualrobot.v1 import motion_pb2

Floats = NDArray[np.float64]


@shown
@dataclass(frozen=True, slots=True, eq=False)
class GroupTrajectory:
    """Tool centre point of a group in n samples.

    Attributes:
        world_t_tcp: (n, 4, 4), its pose in the world's frame.
        tcp_speeds: (n,), its speed in m/s.
    """

    world_t_tcp: Floats
    tcp_speeds: Floats

    @staticmethod
    def of(message: motion_pb2.GroupTrajectory) -> tuple[str | tuple[str, str], GroupTrajectory]:
        """Return which group a message tells of, and what."""
        chosen = message.group
        poses, speeds = poses_from_rows(array_of(message.world_t_tcp)), array_of(message.tcp_speeds)
        return chosen.name or (chosen.base_link, chosen.tip_link), GroupTrajectory(poses, speeds)


@shown
@dataclass(frozen=True, slots=True, eq=False)
class RobotTrajectory:
    """The motion of one robot in n samples of k joints.

    Attributes:
        robot: the robot.
        joint_names: the joints that move, in the order of the columns; of a craft whose drives do the coordinates of
            its base after them.
        positions: (n, k), radians or meters.
        velocities: (n, k), rad/s or m/s.
        accelerations: (n, k), rad/s^2 or m/s^2.
        efforts: (n, k), effort of each joint on the link that it moves, tools and held parts included: N m or N.
            Bodies without a mass weigh nothing; `Robot.solve_inverse_dynamics` names them in its `warnings`.
        world_t_tcp: (n, 4, 4), pose of the chosen tool centre point in the world's frame.
        tcp_speeds: (n,), its speed in m/s.
        groups: the tool centre points of its groups that are moved, by name, or by (base link, tip link).
    """

    robot: str
    joint_names: tuple[str, ...]
    positions: Floats
    velocities: Floats
    accelerations: Floats
    efforts: Floats
    world_t_tcp: Floats
    tcp_speeds: Floats
    groups: dict[str | tuple[str, str], GroupTrajectory]

    @staticmethod
    def of(message: motion_pb2.RobotTrajectory) -> RobotTrajectory:
        """Return what a message tells."""
        return RobotTrajectory(
            message.robot,
            tuple(message.joint_names),
            array_of(message.positions),
            array_of(message.velocities),
            array_of(message.accelerations),
            array_of(message.efforts),
            poses_from_rows(array_of(message.world_t_tcp)),
            array_of(message.tcp_speeds),
            dict(GroupTrajectory.of(group) for group in message.groups),
        )


@shown
@dataclass(frozen=True, slots=True, eq=False)
class MotionPlan:
    """A motion in n samples; the last one is at its end. Steps that wait for a signal take no time.

    Attributes:
        duration: duration at full speed factors (s).
        times: (n,), seconds, strictly growing from 0.
        steps: (n,), the step of a program that each sample belongs to, from 0.
        robots: the trajectory of each robot, by its name.
        notes: the differences of the plan from what was asked.
        reference: what `Client.start_plan` starts it by; None for one that belongs to the moment: along a moving frame,
            or with steps that are planned when they are reached.
    """

    duration: float
    times: Floats
    steps: NDArray[np.int32]
    robots: dict[str, RobotTrajectory]
    notes: tuple[PlanNote, ...]
    reference: PlanReference | None

    @staticmethod
    def of(message: motion_pb2.PlanMotionResponse) -> MotionPlan:
        """Return what a message tells."""
        return MotionPlan(
            message.duration_seconds,
            array_of(message.times),
            array_of(message.steps),
            {robot.robot: RobotTrajectory.of(robot) for robot in message.robots},
            tuple(map(PlanNote.of, message.notes)),
            PlanReference.of(message),
        )


class ViolationKind(Enum):
    """Kind of a violation by a motion; the comments give the unit of the violation's `value` and `limit`."""

    JOINT_POSITION = motion_pb2.VIOLATION_KIND_JOINT_POSITION  # rad or m
    JOINT_VELOCITY = motion_pb2.VIOLATION_KIND_JOINT_VELOCITY  # rad/s or m/s
    JOINT_ACCELERATION = motion_pb2.VIOLATION_KIND_JOINT_ACCELERATION  # rad/s^2 or m/s^2
    EFFORT = motion_pb2.VIOLATION_KIND_EFFORT  # N m or N
    REACH = motion_pb2.VIOLATION_KIND_REACH  # m
    SINGULARITY = motion_pb2.VIOLATION_KIND_SINGULARITY  # without unit
    OTHER = motion_pb2.VIOLATION_KIND_OTHER
    COLLISION = motion_pb2.VIOLATION_KIND_COLLISION  # m that they are apart
    PAYLOAD = motion_pb2.VIOLATION_KIND_PAYLOAD  # kg


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Violation:
    """A limit that a motion violates, or a collision on its way.

    Attributes:
        kind: the kind of the violation.
        step: the step of a program, from 0.
        robot: the robot; of two nodes that touch, the one that the step moves the first of them with, else the second.
        joint: the joint; empty where it is not a joint's limit.
        time: time from the start of the motion (s); None where it can't be planned so far.
        path_fraction: part of its step's path that is done there, 0 to 1; None where that is not known.
        world_t_tcp: pose of the tool centre point then in the world's frame, 4x4; None where that is not known.
        value: the value, in the kind's unit.
        limit: the limit that it violates.
        message: all of it in words.
        first: a node that touches another one; empty for limits.
        second: the other node.
        points: (2, 3) the nearest points of both then, in the world's frame; None for limits.
        step_path: the step as the program's text has it, such as `4[2].0`.
    """

    kind: ViolationKind
    step: int
    robot: str
    joint: str
    time: float | None
    path_fraction: float | None
    world_t_tcp: Matrix | None
    value: float
    limit: float
    message: str
    first: str
    second: str
    points: Floats | None
    step_path: str = ""

    @staticmethod
    def of(message: motion_pb2.Violation) -> Violation:
        """Return what a message tells."""
        return Violation(
            ViolationKind(message.kind),
            message.step,
            message.robot,
            message.joint,
            message.time_seconds if message.HasField("time_seconds") else None,
            message.path_fraction if message.HasField("path_fraction") else None,
            pose_of(message.world_t_tcp) if message.HasField("world_t_tcp") else None,
            message.value,
            message.limit,
            message.message,
            message.first,
            message.second,
            np.array([[point.x, point.y, point.z] for point in (message.first_point, message.second_point)])
            if message.HasField("first_point")
            else None,
            message.step_path,
        )

    def __str__(self) -> str:
        """Return it in words."""
        return self.message


@shown
@dataclass(frozen=True, slots=True, eq=False)
class MotionCheck:
    """Result of checking a motion.

    Attributes:
        first_violation: the first limit in time that it violates, or the first collision; None without either.
        duration: duration at full speed factors (s); 0 where it can't be planned.
        min_singular_value: the smallest one on the way, of those arms that move; None where there is none.
        notes: the differences of the plan from what was asked.
        reference: what `Client.start_plan` starts that by which was looked at; None where it violates something, and
            where a `MotionPlan` has none.
    """

    first_violation: Violation | None
    duration: float
    min_singular_value: float | None
    notes: tuple[PlanNote, ...]
    reference: PlanReference | None

    @property
    def ok(self) -> bool:
        """True where it keeps all limits and touches nothing."""
        return self.first_violation is None

    @staticmethod
    def of(message: motion_pb2.CheckMotionResponse) -> MotionCheck:
        """Return what a message tells."""
        return MotionCheck(
            Violation.of(message.first_violation) if message.HasField("first_violation") else None,
            message.duration_seconds,
            message.min_singular_value if message.HasField("min_singular_value") else None,
            tuple(map(PlanNote.of, message.notes)),
            PlanReference.of(message),
        )


class PlanOptions(TypedDict, total=False):
    """Options of plans.

    Attributes:
        sample_time: time between samples (s), at least a tick; a tick by default.
    """

    sample_time: float | None


class CheckOptions(TypedDict, total=False):
    """Options of checks of motions.

    Attributes:
        min_singular_value: the smallest singular value of the Jacobian that is accepted, its linear rows divided by the
            longest lever arm; by default only lines and arcs keep away from singularities, by 0.01.
        collisions: whether collisions are looked for, as they are by default.
        resolution: distance (m) below which nodes may be told to collide; none is missed; 0.0001 by default.
    """

    min_singular_value: float | None
    collisions: bool | None
    resolution: float | None


def plan(services: Services, spec: motion_pb2.MotionSpec, **options: Unpack[PlanOptions]) -> MotionPlan:
    """Return what a motion would do; see `Client.plan`."""
    check_options(options, PlanOptions, "a plan")
    check_not_empty(spec)
    sample_time = value_or_default(options.get("sample_time"), "sample_time")
    request = motion_pb2.PlanMotionRequest(spec=spec, sample_seconds=sample_time)
    return MotionPlan.of(services.motion.PlanMotion(request, timeout=LONG_TIMEOUT_SECONDS))


def plan_left(services: Services, running: Motion, **options: Unpack[PlanOptions]) -> MotionPlan:
    """Return what is planned of a motion that runs, from where it is on its path on; see `Client.plan`."""
    check_options(options, PlanOptions, "a plan")
    sample_time = value_or_default(options.get("sample_time"), "sample_time")
    request = motion_pb2.PlanMotionRequest(motion_id=running.id, sample_seconds=sample_time)
    return MotionPlan.of(services.motion.PlanMotion(request, timeout=LONG_TIMEOUT_SECONDS))


def plan_shown(services: Services, shown: ShownPlan, **options: Unpack[PlanOptions]) -> MotionPlan:
    """Return a plan that the kernel remembers in samples."""
    check_options(options, PlanOptions, "a plan")
    sample_time = value_or_default(options.get("sample_time"), "sample_time")
    request = motion_pb2.PlanMotionRequest(plan=reference_of(shown)._message, sample_seconds=sample_time)
    return MotionPlan.of(services.motion.PlanMotion(request, timeout=LONG_TIMEOUT_SECONDS))


def check(services: Services, spec: motion_pb2.MotionSpec, **options: Unpack[CheckOptions]) -> MotionCheck:
    """Return whether a motion keeps all limits and touches nothing; see `Client.check`."""
    check_not_empty(spec)
    return _checked(services, motion_pb2.CheckMotionRequest(spec=spec), **options)


def check_plan(services: Services, shown: ShownPlan, **options: Unpack[CheckOptions]) -> MotionCheck:
    """Return whether a plan keeps all limits and touches nothing as it is; see `Client.check_plan`."""
    request = motion_pb2.CheckMotionRequest(plan=reference_of(shown)._message)
    return _checked(services, request, **options)


def _checked(
    services: Services, request: motion_pb2.CheckMotionRequest, **options: Unpack[CheckOptions]
) -> MotionCheck:
    """Return the check that a request names the motion of."""
    check_options(options, CheckOptions, "a check")
    request.min_singular_value = value_or_default(options.get("min_singular_value"), "min_singular_value")
    request.ignore_collisions = not options.get("collisions", True)
    request.resolution_meters = value_or_default(options.get("resolution"), "resolution")
    return MotionCheck.of(services.motion.CheckMotion(request, timeout=LONG_TIMEOUT_SECONDS))


def start_plan(services: Services, shown: ShownPlan, **options: Unpack[StartOptions]) -> Motion:
    """Start a plan as it was shown; see `Client.start_plan`."""
    request = motion_pb2.StartMotionRequest(plan=reference_of(shown)._message)
    return start_request(services, request, **options)


ShownPlan = MotionPlan | MotionCheck | PlanReference
"""Plan as it was shown or checked, or its reference."""


def reference_of(shown: ShownPlan) -> PlanReference:
    """Return what the kernel calls a plan; raise InvalidArgumentError for one that it doesn't remember."""
    if isinstance(shown, PlanReference):
        return shown
    if shown.reference is not None:
        return shown.reference
    if isinstance(shown, MotionCheck) and shown.first_violation is not None:
        raise InvalidArgumentError(f"what was checked is not to be started: {shown.first_violation}")
    raise InvalidArgumentError(
        "a motion along a moving frame, or with steps that are planned when they are reached, belongs to the moment: "
        "start it as moves or as a program"
    )


def motion_of(moves: Iterable[Move], tracking: Tracking | None = None) -> motion_pb2.MotionSpec:
    """Return the motion that is these moves together."""
    tracked = None if tracking is None else tracking._message
    return motion_pb2.MotionSpec(moves=messages_of(moves), tracking=tracked)
