"""Motions before they move: planned in samples, and checked against all limits and for collisions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.messages import array_of, pose_of
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix, poses_from_rows
from virtualrobot.motions.motion import Tracking
from virtualrobot.v1 import motion_pb2

Floats = NDArray[np.float64]

Wish = motion_pb2.Move | motion_pb2.ProgramStep
"""Part of a motion: a move of those that go together, or a step of a program."""


@dataclass(frozen=True, slots=True)
class PlanNote:
    """Something that the planner made other than asked; `kind` is as in `PlanNoteKind` of the contract.

    wanted, kept: the value that was asked for and the one that became of it, in meters, radians or percent.
    """

    kind: str
    step: int
    robot: str
    wanted: float
    kept: float
    message: str

    @staticmethod
    def of(message: motion_pb2.PlanNote) -> PlanNote:
        """Return what a message tells."""
        kind = motion_pb2.PlanNoteKind.Name(message.kind).removeprefix("PLAN_NOTE_KIND_")
        return PlanNote(kind, message.step, message.robot, message.wanted, message.kept, message.message)


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


@dataclass(frozen=True, slots=True, eq=False)
class RobotTrajectory:
    """The motion of one robot in n samples of k joints.

    Attributes:
        robot: the robot.
        joint_names: the joints that move, in the order of the columns.
        positions: (n, k), radians or meters.
        velocities: (n, k), rad/s or m/s.
        accelerations: (n, k), rad/s^2 or m/s^2.
        efforts: (n, k), effort of each joint on the link that it moves, tools and held parts included: N m or N.
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


@dataclass(frozen=True, slots=True, eq=False)
class MotionPlan:
    """A motion in n samples; the last one is at its end. Steps that wait for a signal take no time.

    Attributes:
        duration_seconds: duration at full speed factors (s).
        times: (n,), seconds, strictly growing from 0.
        steps: (n,), the step of a program that each sample belongs to, from 0.
        robots: the trajectory of each robot, by its name.
        notes: the differences of the plan from what was asked.
    """

    duration_seconds: float
    times: Floats
    steps: NDArray[np.int32]
    robots: dict[str, RobotTrajectory]
    notes: tuple[PlanNote, ...]

    @staticmethod
    def of(message: motion_pb2.PlanMotionResponse) -> MotionPlan:
        """Return what a message tells."""
        return MotionPlan(
            message.duration_seconds,
            array_of(message.times),
            array_of(message.steps),
            {robot.robot: RobotTrajectory.of(robot) for robot in message.robots},
            tuple(map(PlanNote.of, message.notes)),
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


@dataclass(frozen=True, slots=True, eq=False)
class Violation:
    """A limit that a motion violates, or a collision on its way.

    Attributes:
        kind: the kind of the violation.
        step: the step of a program, from 0.
        robot: the robot; of two nodes that touch, the one that the step moves the first of them with, else the second.
        joint: the joint; empty where it is not a joint's limit.
        time_seconds: time from the start of the motion (s); None where it can't be planned so far.
        path_fraction: part of its step's path that is done there, 0 to 1; None where that is not known.
        world_t_tcp: pose of the tool centre point then in the world's frame, 4x4; None where that is not known.
        value: the value, in the kind's unit.
        limit: the limit that it violates.
        message: all of it in words.
        first: a node that touches another one; empty for limits.
        second: the other node.
        points: (2, 3) the nearest points of both then, in the world's frame; None for limits.
    """

    kind: ViolationKind
    step: int
    robot: str
    joint: str
    time_seconds: float | None
    path_fraction: float | None
    world_t_tcp: Matrix | None
    value: float
    limit: float
    message: str
    first: str
    second: str
    points: Floats | None

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
        )

    def __str__(self) -> str:
        """Return it in words."""
        return self.message


@dataclass(frozen=True, slots=True, eq=False)
class MotionCheck:
    """Result of checking a motion.

    Attributes:
        first_violation: the first limit in time that it violates, or the first collision; None without either.
        duration_seconds: duration at full speed factors (s); 0 where it can't be planned.
        min_singular_value: the smallest one on the way, of those arms that move; None where there is none.
        notes: the differences of the plan from what was asked.
    """

    first_violation: Violation | None
    duration_seconds: float
    min_singular_value: float | None
    notes: tuple[PlanNote, ...]

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
        )


def plan(services: Services, spec: motion_pb2.MotionSpec, *, sample_seconds: float = 0.0) -> MotionPlan:
    """Return what a motion would do; see `Client.plan`."""
    request = motion_pb2.PlanMotionRequest(spec=spec, sample_seconds=sample_seconds)
    return MotionPlan.of(services.motion.PlanMotion(request, timeout=LONG_TIMEOUT_SECONDS))


def check(
    services: Services,
    spec: motion_pb2.MotionSpec,
    *,
    min_singular_value: float = 0.0,
    collisions: bool = True,
    resolution_meters: float = 0.0,
) -> MotionCheck:
    """Return whether a motion keeps all limits and touches nothing; see `Client.check`."""
    request = motion_pb2.CheckMotionRequest(
        spec=spec,
        min_singular_value=min_singular_value,
        ignore_collisions=not collisions,
        resolution_meters=resolution_meters,
    )
    return MotionCheck.of(services.motion.CheckMotion(request, timeout=LONG_TIMEOUT_SECONDS))


def motion_of(wishes: Iterable[Wish], tracking: Tracking | None = None) -> motion_pb2.MotionSpec:
    """Return the motion that is these moves together, or these steps."""
    given = list(wishes)
    moves = [wish for wish in given if isinstance(wish, motion_pb2.Move)]
    steps = [wish for wish in given if isinstance(wish, motion_pb2.ProgramStep)]
    if len(moves) + len(steps) < len(given) or (moves and steps):
        raise InvalidArgumentError("a motion is moves that go together, or the steps of a program")
    tracked = None if tracking is None else tracking.message
    return motion_pb2.MotionSpec(moves=moves, steps=steps, tracking=tracked)
