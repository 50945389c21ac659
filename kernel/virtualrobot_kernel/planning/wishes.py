"""What robots are wished to do, as data: one kind of move each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.circle import Center, Via
from virtualrobot_kernel.motion.signals import Condition
from virtualrobot_kernel.planning.jog import CartesianJog, JointJog
from virtualrobot_kernel.planning.planned_move import (
    PoseGoal,
)
from virtualrobot_kernel.planning.redundancy import FREE, Redundancy
from virtualrobot_kernel.planning.spline import Spline
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.groups import WHOLE, Group


@dataclass(frozen=True, slots=True)
class ActuatorGoal:
    """Where actuators shall be, in their units, by name."""

    positions: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class PointToPoint:
    """A straight line in joint space to joints by name, to a pose, to a posture by name, or to actuator positions."""

    robot: str
    goal: Mapping[str, float] | PoseGoal | str | ActuatorGoal
    speed_factor: float = 1.0
    redundancy: Redundancy = FREE
    time_law: TimeLaw = TimeLaw.JERK_LIMITED
    group: Group = WHOLE


@dataclass(frozen=True, slots=True, eq=False)
class Linear:
    """A straight line of the tool centre point; 0 stands for the default speed (m/s) and acceleration (m/s^2).

    until: the condition with which it ends before its goal, a search.
    """

    robot: str
    goal: PoseGoal
    speed_factor: float = 1.0
    max_velocity: float = 0.0
    max_acceleration: float = 0.0
    redundancy: Redundancy = FREE
    until: Condition | None = None
    time_law: TimeLaw = TimeLaw.JERK_LIMITED
    group: Group = WHOLE


@dataclass(frozen=True, slots=True, eq=False)
class Circular:
    """An arc of the tool centre point through a point or about a centre; 0 stands for the default speed, as for a line.

    All is given in the frame of the node `reference`; reference_t_goal (4, 4) may be None when the centre has an angle.
    `with_arc`: the tool turns as the arc does instead of evenly to the goal's orientation. `moving`: the reference
    moves with other moves of the same step, and the arc goes along.
    """

    robot: str
    shape: Via | Center
    reference_t_goal: Pose | None = None
    reference: str = ""
    with_arc: bool = False
    speed_factor: float = 1.0
    max_velocity: float = 0.0
    max_acceleration: float = 0.0
    redundancy: Redundancy = FREE
    time_law: TimeLaw = TimeLaw.JERK_LIMITED
    moving: bool = False
    group: Group = WHOLE


@dataclass(frozen=True, slots=True, eq=False)
class JointTrajectory:
    """Joints at times (n,) in seconds: positions (n, k), velocities (n, k) or None."""

    robot: str
    joint_names: tuple[str, ...]
    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64] | None = None
    group: Group = WHOLE


@dataclass(frozen=True, slots=True, eq=False)
class ToolStateMove:
    """The joints of a tool (empty: the chosen one, or the group's) to where one of its states has them."""

    robot: str
    tool: str
    state: str
    speed_factor: float = 1.0
    time_law: TimeLaw = TimeLaw.JERK_LIMITED
    group: Group = WHOLE


Move = PointToPoint | Linear | Circular | Spline | JointTrajectory | ToolStateMove | JointJog | CartesianJog

LED = (Linear, Circular, Spline, CartesianJog)
"""What leads the tool centre point along a course."""
