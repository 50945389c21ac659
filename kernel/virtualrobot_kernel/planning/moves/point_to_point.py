"""Point-to-point moves (PTP): straight lines in joint space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, LimitError, UnknownNameError
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.orientation import unit
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.planning.apart import apart_tcp, goal_of_tcp, share_apart, stands_still
from virtualrobot_kernel.planning.free_joints import reached
from virtualrobot_kernel.planning.moves.move import Move
from virtualrobot_kernel.planning.moving_base import MovingBase
from virtualrobot_kernel.planning.planned_move import PlannedMove, PoseGoal, joint_limits, world_t_goal
from virtualrobot_kernel.planning.redundancy import FREE, NearOf, Redundancy
from virtualrobot_kernel.planning.robots import SolverOf, arm_of
from virtualrobot_kernel.planning.tool_states import tool_chain, tool_states
from virtualrobot_kernel.units import MOST_ANGLE, degrees_question
from virtualrobot_kernel.world.actuators import joint_positions
from virtualrobot_kernel.world.change import coordinate_of
from virtualrobot_kernel.world.crafts import craft_of
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.groups import WHOLE, Group, joints_of
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node, RobotData

TCP_LOOKS = 257
"""Number of places on a way at which the speed of a tool centre point is looked at."""


@dataclass(frozen=True, slots=True)
class ActuatorGoal:
    """Positions of actuators by name, in their units."""

    positions: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class PointToPoint(Move):
    """Straight line in joint space to joints by name, to a pose, to a posture by name, or to actuator positions.

    max_velocity (m/s), max_angular_velocity (rad/s): those of the chosen tool centre point; 0: any.
    """

    goal: Mapping[str, float] | PoseGoal | str | ActuatorGoal
    speed_factor: float = 1.0
    redundancy: Redundancy = FREE
    time_law: TimeLaw = TimeLaw.JERK_LIMITED
    max_velocity: float = 0.0
    max_angular_velocity: float = 0.0

    @property
    def solved(self) -> bool:
        """True if the goal is a pose."""
        return isinstance(self.goal, PoseGoal)

    @property
    def references(self) -> tuple[str, ...]:
        """Reference node of a goal pose; none for other goals."""
        return (self.goal.reference,) if isinstance(self.goal, PoseGoal) else ()

    @property
    def moving_reference(self) -> str | None:
        """Reference node of a goal pose that moves along with it; None for other goals."""
        return self.goal.reference if isinstance(self.goal, PoseGoal) and self.goal.moving else None

    @property
    def posture(self) -> str:
        """Posture that is its goal; empty for other goals."""
        return self.goal if isinstance(self.goal, str) else ""

    def joint_names(self, snapshot: Snapshot) -> Sequence[str]:
        """Return the joints that the goal names, or those of the arm."""
        node = self.node(snapshot)
        if isinstance(self.goal, PoseGoal):
            return arm_of(snapshot, node, self.group).joint_names
        return tuple(self._positions(snapshot, node))

    def plan(self, snapshot: Snapshot, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan; a pose is reached by the posture nearest to the present one, or to that of a target."""
        node = self.node(snapshot)
        if not isinstance(self.goal, PoseGoal):
            return self._to_joints(snapshot, node, self._positions(snapshot, node))
        world_t_tcp = world_t_goal(snapshot, self.goal)
        if self.fixed_tool:
            arm = arm_of(snapshot, node, self.group)
            carried = (self.fixed_tool, self.goal.reference)
            world_t_tcp = goal_of_tcp(snapshot, arm, *carried, self.goal.reference_t_tcp)
        return self._plan_to(snapshot, self.goal, world_t_tcp, solver_of, near_of)

    def _plan_to(
        self, snapshot: Snapshot, goal: PoseGoal, world_t_tcp: Pose, solver_of: SolverOf, near_of: NearOf | None
    ) -> PlannedMove:
        """Return the plan to a goal that is, or will be, at `world_t_tcp` (4, 4)."""
        node = self.node(snapshot)
        choice = (goal.configuration, self.redundancy, self.group)
        arm, solutions = reached(snapshot, node, world_t_tcp, solver_of, *choice, near_of, goal.reference)
        limits, start = joint_limits(snapshot, node, arm.joint_names)
        there, share = _nearest_turn(solutions[0], start, limits), None
        if self.fixed_tool:
            apart = apart_tcp(snapshot, arm, self.fixed_tool, goal.reference, solver_of)
            share = share_apart(apart, start, there, limits.velocity, (self.max_velocity, self.max_angular_velocity))
        return self._to_joints(snapshot, node, dict(zip(arm.joint_names, there.tolist(), strict=True)), share)

    def _to_joints(
        self, snapshot: Snapshot, node: Node, positions: Mapping[str, float], share: float | None = None
    ) -> PlannedMove:
        """Return the plan to joints, as slow as the limits of the tool centre point have it, or by a share known."""
        factor = self.speed_factor or 1.0
        if share is not None:
            factor *= share
        elif self.max_velocity or self.max_angular_velocity:
            factor *= tcp_share(snapshot, node, positions, (self.max_velocity, self.max_angular_velocity), self.group)
        return move_to_joints(snapshot, node, positions, factor, self.time_law, self.gentle)

    def plan_on(self, base: MovingBase, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return the plan to a pose where base and reference will be when all have arrived."""
        if self.fixed_tool:
            raise stands_still(self.robot, self.fixed_tool)
        if not isinstance(self.goal, PoseGoal):
            return Move.plan_on(self, base, solver_of, near_of)
        there = base.arrived()
        world_t_tcp = world_t_goal(there if self.goal.moving else base.snapshot, self.goal)
        return self._plan_to(there, self.goal, world_t_tcp, solver_of, near_of)

    def _positions(self, snapshot: Snapshot, node: Node) -> Mapping[str, float]:
        """Return the joint values of a goal that is no pose; of a posture those of the group's joints."""
        if self.group == WHOLE:
            return goal_positions(node, self.goal)
        own = joints_of(snapshot.structure, node, self.group)
        return goal_positions(node, self.goal, snapshot.structure.robots[node.uid].coordinates_of(own))


def goal_positions(
    node: Node, goal: Mapping[str, float] | PoseGoal | str | ActuatorGoal, joints: Sequence[str] | None = None
) -> Mapping[str, float]:
    """Return the joint values of a goal that is no pose; of a posture only those of a group's `joints`, if given.

    Raises UnknownNameError for a posture that there is not.
    """
    if isinstance(goal, ActuatorGoal):
        return joint_positions(node, goal.positions)
    if isinstance(goal, str):
        postures = node.data.postures if isinstance(node.data, RobotData) else {}
        if goal not in postures:
            raise UnknownNameError(f"posture of {node.name!r}", goal, postures)
        goal = {name: value for name, value in postures[goal].items() if joints is None or name in joints}
    assert not isinstance(goal, PoseGoal)
    if not goal:
        raise KernelError(
            f"the move of {node.name!r} names no joint{' of its group' if joints else ''}: give the positions of those "
            "that shall move",
            robot=node.name,
        )
    return goal


def move_to_joints(
    snapshot: Snapshot,
    node: Node,
    positions: Mapping[str, float],
    speed_factor: float,
    time_law: TimeLaw,
    gentle: tuple[float, float] = (1.0, 1.0),
) -> PlannedMove:
    """Return the straight line in joint space to joint positions by name (rad or m), columns in the robot's order."""
    names = tuple(sorted(positions, key=lambda name: coordinate_of(snapshot.structure, node, name).q))
    limits, start = joint_limits(snapshot, node, names)
    goal = np.array([positions[name] for name in names])
    for columns in map(list, limits.quaternions):
        goal[columns] = unit(goal[columns], f"the goal of {node.name!r}")
    if craft_of(node) is None:  # wheels turn as far as the way is
        _check_turns(node, limits, start, goal)
    speed_factor = speed_factor or 1.0
    plan = plan_ptp(start, goal, limits, speed_factor, time_law, gentle)
    return PlannedMove(node, names, plan, speed_factor=speed_factor, gentle=gentle)


def tcp_share(
    snapshot: Snapshot, node: Node, positions: Mapping[str, float], limits: tuple[float, float], group: Group
) -> float:
    """Return the share, up to 1, of the joints' speeds with which a tool centre point keeps its own on the way there.

    limits: m/s and rad/s; 0: any. Raises KernelError for a robot without a tool centre point.
    """
    places = np.array([coordinate_of(snapshot.structure, node, name).q for name in positions])
    joints, start = joint_limits(snapshot, node, tuple(positions))
    if joints.quaternions:
        raise KernelError(f"{node.name!r} turns freely, and its joint moves take no speed of a tool centre point")
    way = np.array([*positions.values()]) - start
    seconds = float(np.max(np.abs(way) / joints.velocity, initial=0.0))
    if seconds == 0.0:
        return 1.0
    chain = tool_chain(snapshot, node, group)
    q = np.tile(snapshot.state.q, (TCP_LOOKS, 1))
    rates = np.zeros_like(q)
    q[:, places] = start + np.linspace(0.0, 1.0, TCP_LOOKS)[:, None] * way
    rates[:, places] = way / seconds
    tool = tool_states(chain, q, rates)
    turning = np.einsum("nij,nj->ni", tool.jacobians[:, 3:], rates[:, chain.arm])
    fastest = [float(np.linalg.norm(each, axis=1).max()) for each in (tool.velocities, turning)]
    return min([1.0, *(limit / speed for limit, speed in zip(limits, fastest, strict=True) if limit and speed > 1e-12)])


def _check_turns(node: Node, limits: JointLimits, start: NDArray[np.float64], goal: NDArray[np.float64]) -> None:
    """Raise LimitError where a joint without limits would turn farther than anybody means to.

    One that has turned far may go back to where it has not.
    """
    for column, name in enumerate(limits.names):
        turn = float(goal[column] - start[column])
        endless = np.isinf(limits.lower[column]) and np.isinf(limits.upper[column]) and name not in limits.sliding
        if endless and abs(goal[column]) > MOST_ANGLE and (question := degrees_question(turn)):
            raise LimitError(
                f"the joint {name!r} of {node.name!r} would turn by {turn:g} rad at once, more than {MOST_ANGLE:.4g}"
                f"{question}; a jog or a trajectory turns it on",
                robot=node.name,
                joint=name,
                value=turn,
                limit=MOST_ANGLE,
            )


def _nearest_turn(goal: NDArray[np.float64], start: NDArray[np.float64], limits: JointLimits) -> NDArray[np.float64]:
    """Return the goal with joints that turn without limits brought within half a turn of where they are."""
    free = np.isinf(limits.lower) & np.isinf(limits.upper)
    turns = np.round((goal - start) / (2 * np.pi))
    return np.where(free, goal - 2 * np.pi * turns, goal)
