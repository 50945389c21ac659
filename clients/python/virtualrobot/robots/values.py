"""Answers of robots: states, limits and kinematic solutions as plain values."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import Stamp, array_of, pose_of, stamp_of
from virtualrobot._wire.showing import shown
from virtualrobot.errors import LimitError, UnreachableError
from virtualrobot.geometry import Matrix
from virtualrobot.v1 import geometry_pb2, nodes_pb2, robot_pb2


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Limits of a joint: position in rad or m, its derivatives per s, s^2 and s^3, effort in N m or N."""

    lower: float
    upper: float
    velocity: float
    acceleration: float
    jerk: float
    effort: float

    @staticmethod
    def of(message: nodes_pb2.JointLimits) -> JointLimits:
        """Return limits from a message; no limit of position is infinite."""
        return JointLimits(
            message.lower if message.HasField("lower") else -math.inf,
            message.upper if message.HasField("upper") else math.inf,
            message.velocity,
            message.acceleration,
            message.jerk,
            message.effort,
        )


@shown
@dataclass(frozen=True, slots=True)
class RobotState:
    """State of a robot's joints and tools at one instant.

    Attributes:
        name: the robot.
        stamp: the instant of this state.
        positions: coordinates of all joints as they are, radians and meters.
        velocities: velocities of all joints as they are, rad/s and m/s.
        world_t_tcp: 4x4, the chosen tool centre point, or without a tool the flange.
        tool: the chosen tool; empty means none.
        tool_center_point: the chosen point; empty means none.
        tool_states: the state of each mounted tool.
        speed_factor: the factor by which its motions are slowed.
        motion_ids: the motions that move it or its grippers.
        actuator_positions: positions of its actuators, in their units, in the order of `Robot.actuators`.
        commanded_positions: coordinates as motions command them; `positions` unless the joints are measured or
            moved by motors.
        commanded_velocities: velocities as motions command them; `velocities` unless the joints are measured or
            moved by motors.
        tool_widths: how wide each mounted tool is open, in meters; of those that have widths.
        tcp_speed_limit: the greatest speed of its tool centre point (m/s); 0: it has none.
        efforts: what the motors of a robot under physics exerted, in the order of `velocities` (N m, N); else empty.
    """

    name: str
    stamp: Stamp
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    world_t_tcp: Matrix
    tool: str
    tool_center_point: str
    tool_states: dict[str, str]
    speed_factor: float
    motion_ids: tuple[str, ...]
    actuator_positions: NDArray[np.float64]
    commanded_positions: NDArray[np.float64]
    commanded_velocities: NDArray[np.float64]
    tool_widths: dict[str, float]
    tcp_speed_limit: float = 0.0
    efforts: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    @staticmethod
    def of(message: robot_pb2.RobotState, stamp: geometry_pb2.Stamp) -> RobotState:
        """Return the state that a message tells."""
        return RobotState(
            message.name,
            stamp_of(stamp),
            np.array(message.positions, dtype=float),
            np.array(message.velocities, dtype=float),
            pose_of(message.world_t_tcp),
            message.tool,
            message.tool_center_point,
            dict(message.tool_states),
            message.speed_factor,
            tuple(message.motion_ids),
            np.array(message.actuator_positions, dtype=float),
            np.array(message.commanded_positions or message.positions, dtype=float),
            np.array(message.commanded_velocities or message.velocities, dtype=float),
            dict(message.tool_widths),
            message.tcp_speed_limit,
            np.array(message.efforts, dtype=float),
        )


@shown
@dataclass(frozen=True, slots=True)
class Actuator:
    """A motor or a cylinder; its position is `offset` plus the sum of ratio times joint.

    Attributes:
        name: unique within the robot.
        ratios: its own unit per radian or meter, by joint.
        offset: its position where those joints are at 0.
        lower: the least position; -inf without a limit.
        upper: the greatest position; inf without a limit.
    """

    name: str
    ratios: dict[str, float]
    offset: float
    lower: float
    upper: float

    @staticmethod
    def of(message: nodes_pb2.Actuator) -> Actuator:
        """Return the actuator that a message tells."""
        return Actuator(
            message.name,
            {term.joint: term.ratio for term in message.terms},
            message.offset,
            message.lower if message.HasField("lower") else -math.inf,
            message.upper if message.HasField("upper") else math.inf,
        )


@checked
@dataclass(frozen=True, slots=True)
class JointGroup:
    """Joints with a common name, such as those of an arm or a hand, as a group of an SRDF file.

    Attributes:
        name: unique within the robot.
        joint_names: the joints that can be moved, in the robot's order; may be left out where two links are given.
        base_link: the link that the group's chain begins at; empty where joints alone are given.
        tip_link: the link that the group's chain ends at; empty likewise.
        kinematics: the component that solves the chain; empty means the one that its geometry allows.
    """

    name: str
    joint_names: tuple[str, ...] = ()
    base_link: str = ""
    tip_link: str = ""
    kinematics: str = ""

    @staticmethod
    def of(message: nodes_pb2.JointGroup) -> JointGroup:
        """Return what a message says."""
        names = tuple(message.joint_names)
        return JointGroup(message.name, names, message.base_link, message.tip_link, message.kinematics)

    @property
    def _message(self) -> nodes_pb2.JointGroup:
        return nodes_pb2.JointGroup(
            name=self.name,
            joint_names=self.joint_names,
            base_link=self.base_link,
            tip_link=self.tip_link,
            kinematics=self.kinematics,
        )


@dataclass(frozen=True, slots=True)
class LinkPair:
    """Two links of a robot that may touch, and why, such as `Adjacent` or `Never`."""

    first: str
    second: str
    reason: str


@shown
@dataclass(frozen=True, slots=True)
class ForwardSolution:
    """Forward kinematics of a posture.

    Attributes:
        world_t_tcp: 4x4, the chosen tool centre point, or without a tool the flange.
        world_t_link: 4x4 by link name.
        configuration: the name of the posture's configuration; empty unless it was asked for and has one.
    """

    world_t_tcp: Matrix
    world_t_link: dict[str, Matrix]
    configuration: str = ""


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Jacobians:
    """Jacobians of points on a robot: three rows in m above three in rad, per rad or m of each joint.

    In the world's frame, of a robot whose base stands still.

    Attributes:
        joint_names: the joints that the columns are: all with one coordinate.
        world_t_tcp: 4x4, the pose that the chosen tool centre point would have.
        tcp: (6, k) of the chosen tool centre point.
        points: (n, 6, k) of the points that were given.
    """

    joint_names: tuple[str, ...]
    world_t_tcp: Matrix
    tcp: NDArray[np.float64]
    points: NDArray[np.float64]

    @staticmethod
    def of(message: robot_pb2.SolveJacobianResponse) -> Jacobians:
        """Return the Jacobians that a message tells."""
        return Jacobians(
            tuple(message.joint_names),
            pose_of(message.world_t_tcp),
            array_of(message.tcp_jacobian),
            array_of(message.point_jacobians),
        )


@shown
@dataclass(frozen=True, slots=True)
class InverseSolution:
    """Joint positions that reach a pose.

    Attributes:
        joint_names: the joints that were solved for, in order.
        solutions: (n, k), radians or meters, nearest to the seed first; no rows when there is none.
        configurations: the name of each solution's configuration, where the component names them.
        position_error: the position error of the best attempt.
        rotation_error: the rotation error of the best attempt.
        explanation: the reason for which there is no solution, in words.
        arm_angles: the arm angle of each solution in radians, for arms that have one; otherwise empty.
        outside_limits: there is no solution, but postures outside the limits of joints reach the pose.
    """

    joint_names: tuple[str, ...]
    solutions: NDArray[np.float64]
    configurations: tuple[str, ...]
    position_error: float
    rotation_error: float
    explanation: str
    arm_angles: tuple[float, ...] = ()
    outside_limits: bool = False

    @staticmethod
    def of(message: robot_pb2.SolveInverseResponse) -> InverseSolution:
        """Return the solutions that a message tells."""
        solved = message.status == robot_pb2.INVERSE_STATUS_SOLVED
        names = tuple(message.joint_names)
        return InverseSolution(
            names,
            array_of(message.solutions).reshape(-1, len(names)) if solved else np.empty((0, len(names))),
            tuple(message.configurations),
            message.position_error_meters,
            message.rotation_error_radians,
            message.explanation,
            tuple(message.arm_angles_radians),
            message.status == robot_pb2.INVERSE_STATUS_OUTSIDE_LIMITS,
        )

    @property
    def solved(self) -> bool:
        """True where there is a solution."""
        return len(self.solutions) > 0

    @property
    def best(self) -> NDArray[np.float64]:
        """The solution nearest to the seed, (k,); raises UnreachableError when there is none."""
        if not self.solved:
            raise UnreachableError(
                self.explanation
                or f"no posture within limits reaches the pose: off by {self.position_error:.4f} m and "
                f"{self.rotation_error:.4f} rad at best"
            )
        return self.solutions[0]

    def by_name(self) -> dict[str, float]:
        """Return the best solution by joint name; raises UnreachableError when there is none."""
        return dict(zip(self.joint_names, self.best.tolist(), strict=True))


@shown
@dataclass(frozen=True, slots=True, eq=False)
class PointSolution:
    """Joint positions that bring the tool centre point to points, one after the other.

    Attributes:
        joint_names: the joints that were solved for, in order.
        positions: (m, k), radians or meters, for the first m points: all of them where it is solved.
        solved: True where all points are reached.
        position_error: how far the best attempt at the first point that is not reached was off (m).
        explanation: which point is not reached, and why, in words; empty where all are.
        outside_limits: that point is not reached, but is by postures outside the limits of joints.
    """

    joint_names: tuple[str, ...]
    positions: NDArray[np.float64]
    solved: bool
    position_error: float
    explanation: str
    outside_limits: bool

    @staticmethod
    def of(message: robot_pb2.SolvePointsResponse) -> PointSolution:
        """Return the solution that a message tells."""
        return PointSolution(
            tuple(message.joint_names),
            array_of(message.positions).reshape(-1, len(message.joint_names)),
            message.status == robot_pb2.INVERSE_STATUS_SOLVED,
            message.position_error_meters,
            message.explanation,
            message.status == robot_pb2.INVERSE_STATUS_OUTSIDE_LIMITS,
        )

    @property
    def all(self) -> NDArray[np.float64]:
        """Positions for all points, (n, k); raises UnreachableError, or LimitError, where one is not reached."""
        if not self.solved:
            raise (LimitError if self.outside_limits else UnreachableError)(self.explanation)
        return self.positions
