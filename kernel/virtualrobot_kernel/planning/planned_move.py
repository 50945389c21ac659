"""Goals, limits and the plan of one move, shared by the planners of all kinds of moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import LimitError
from virtualrobot_kernel.motion.bounds import TcpBound
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.plan import Plan
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics
from virtualrobot_kernel.planning.notes import Note
from virtualrobot_kernel.planning.relative_frame import RelativeTcp
from virtualrobot_kernel.planning.robots import Arm
from virtualrobot_kernel.units import MOST_TCP_SPEED
from virtualrobot_kernel.world import change
from virtualrobot_kernel.world.change import joint_places
from virtualrobot_kernel.world.figures import Pose, identity
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node

LINE_VELOCITY = 0.25
"""Default speed of a line or an arc, in m/s."""

LINE_ACCELERATION = 1.0
"""Default acceleration of a line or an arc, in m/s^2."""

JERK_RATIO = 10.0
"""Jerk of a line or an arc (m/s^3) as a multiple (1/s) of its acceleration: full acceleration after 0.1 s."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseGoal:
    """Goal pose of the chosen tool centre point: `reference_t_tcp` (4, 4) in the frame of the node `reference`.

    With `configuration` only the posture of that name will do. `moving`: where the reference moves with other moves of
    the same step, the goal goes along; otherwise it counts where the reference is at the start.
    """

    reference_t_tcp: Pose = field(default_factory=identity)
    reference: str = ""
    configuration: str = ""
    moving: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class PlannedMove:
    """Plan of one move, with one track, and the joints of the robot that are its columns.

    What its law keeps besides the joints' own limits: `speed_factor` of their velocities, `gentle` shares of their
    accelerations and jerks, and `tcp`, the limits of the tool centre point where it is led along a Cartesian path. Or
    `relative_tcp`, where others of the step carry it: then the path's fraction is that of all of the step's moves, and
    the plan's own law counts for nothing.
    tool_states: (tool, state) that are true once it has succeeded. notes: what is other than asked, as of step 0.
    group: whose tool centre point counts for zones.
    """

    robot: Node
    joint_names: tuple[str, ...]
    plan: Plan
    tool_states: tuple[tuple[str, str], ...] = ()
    speed_factor: float = 1.0
    gentle: tuple[float, float] = (1.0, 1.0)
    tcp: TcpBound | None = None
    relative_tcp: RelativeTcp | None = None
    notes: tuple[Note, ...] = ()
    group: Group = WHOLE


def led_move(
    node: Node,
    arm: Arm,
    plan: Plan,
    tcp: TcpKinematics,
    cartesian: CartesianLimits,
    speed_factor: float,
    gentle: tuple[float, float] = (1.0, 1.0),
) -> PlannedMove:
    """Return the move of an arm whose TCP is led along a Cartesian path and keeps Cartesian limits."""
    path = plan.tracks[0].path
    bound = TcpBound(path.start, path.end, slice(0, path.dimension), tcp, cartesian.scaled(speed_factor))
    return PlannedMove(node, arm.joint_names, plan, speed_factor=speed_factor, gentle=gentle, tcp=bound)


def cartesian_limits(
    max_velocity: float,
    max_acceleration: float,
    max_angular_velocity: float = 0.0,
    gentle: tuple[float, float] = (1.0, 1.0),
) -> CartesianLimits:
    """Return the limits of a TCP that is led, in m/s, m/s^2 and rad/s; 0 stands for the defaults.

    gentle: the shares of acceleration and jerk that are used, of turning too.

    Raises LimitError for a speed that nobody means.
    """
    if max_velocity > MOST_TCP_SPEED:
        raise LimitError(
            f"the speed of a tool centre point is at most {MOST_TCP_SPEED:g} m/s, not {max_velocity:g}: millimetres? "
            "speeds are in m/s",
            value=max_velocity,
            limit=MOST_TCP_SPEED,
        )
    acceleration = max_acceleration or LINE_ACCELERATION
    return CartesianLimits(
        velocity=max_velocity or LINE_VELOCITY,
        acceleration=gentle[0] * acceleration,
        jerk=gentle[1] * JERK_RATIO * acceleration,
        rotation_velocity=max_angular_velocity or CartesianLimits.rotation_velocity,
        rotation_acceleration=gentle[0] * CartesianLimits.rotation_acceleration,
        rotation_jerk=gentle[1] * CartesianLimits.rotation_jerk,
    )


def world_t_goal(snapshot: Snapshot, goal: PoseGoal) -> Pose:
    """Return world_t_tcp (4, 4) of a goal, where its reference is now."""
    return snapshot.world_t(snapshot.structure.node(goal.reference).uid) @ goal.reference_t_tcp


def joint_limits(snapshot: Snapshot, node: Node, names: Sequence[str]) -> tuple[JointLimits, NDArray[np.float64]]:
    """Return the limits of joints and where they are now, (k,) each."""
    limits = change.joint_limits(snapshot.structure, node, names)
    return limits, snapshot.state.q[joint_places(snapshot.structure, [(node.uid, name) for name in names])[0]]
