"""Splines through poses: from goals, each in the frame of a node of its own, to a planned move."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.cartesian_plan import plan_spline
from virtualrobot_kernel.planning.free_joints import led_tcp
from virtualrobot_kernel.planning.planned_move import (
    PlannedMove,
    PoseGoal,
    cartesian_limits,
    joint_limits,
    led_move,
    world_t_goal,
)
from virtualrobot_kernel.planning.redundancy import FREE, Redundancy
from virtualrobot_kernel.planning.robots import SolverOf, arm_on_path
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind


@dataclass(frozen=True, slots=True, eq=False)
class Spline:
    """A smooth curve of the tool centre point through poses; 0 stands for the default speed, as for a line."""

    robot: str
    goals: tuple[PoseGoal, ...]
    speed_factor: float = 1.0
    max_velocity: float = 0.0
    max_acceleration: float = 0.0
    redundancy: Redundancy = FREE
    time_law: TimeLaw = TimeLaw.JERK_LIMITED
    group: Group = WHOLE


def moving_reference(move: Spline) -> str | None:
    """Return the node with which all goals of a spline move along, None where none does; raise KernelError for some."""
    moving = {goal.reference for goal in move.goals if goal.moving}
    if not moving:
        return None
    if len(moving) > 1 or any(not goal.moving or goal.reference not in moving for goal in move.goals):
        raise KernelError(
            f"the goals of the spline of {move.robot!r} move along with {', '.join(map(repr, sorted(moving)))}; all of "
            "them must move along, with one node, or none",
            robot=move.robot,
        )
    return moving.pop()


def spline_move(snapshot: Snapshot, move: Spline, solver_of: SolverOf) -> PlannedMove:
    """Return the planned move; raise KernelError with the place and the goal nearest to it."""
    node = snapshot.structure.node(move.robot, Kind.ROBOT)
    arm = arm_on_path(snapshot, node, move.redundancy, move.group)
    limits, start = joint_limits(snapshot, node, arm.joint_names)
    base_t_world = inverse(snapshot.world_t(arm.base))
    goals = [base_t_world @ world_t_goal(snapshot, goal) for goal in move.goals]
    tcp = led_tcp(snapshot, arm, solver_of, move.redundancy)
    cartesian, speed_factor = cartesian_limits(move.max_velocity, move.max_acceleration), move.speed_factor or 1.0
    plan = plan_spline(
        tcp.kinematics, start, goals, limits, cartesian, speed_factor, tcp.tip_t_tcp, move.time_law, tcp.wish
    )
    return led_move(node, arm, plan, tcp, cartesian, speed_factor)
