"""Splines of the tool centre point through poses, each in the frame of a node of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.plan import Plan, plan_spline
from virtualrobot_kernel.motion.spline import spline
from virtualrobot_kernel.planning.moves.path_move import PathMove
from virtualrobot_kernel.planning.planned_move import PoseGoal, world_t_goal
from virtualrobot_kernel.planning.redundancy import FREE, Redundancy
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Snapshot


@dataclass(frozen=True, slots=True, eq=False)
class Spline(PathMove):
    """Smooth curve of the tool centre point through poses; 0 stands for the default speed, as for a line."""

    goals: tuple[PoseGoal, ...]
    speed_factor: float = 1.0
    max_velocity: float = 0.0
    max_acceleration: float = 0.0
    max_angular_velocity: float = 0.0
    redundancy: Redundancy = FREE
    time_law: TimeLaw = TimeLaw.JERK_LIMITED

    @property
    def references(self) -> tuple[str, ...]:
        """Reference nodes of its goals, each once."""
        return tuple(dict.fromkeys(goal.reference for goal in self.goals))

    @property
    def moving_reference(self) -> str | None:
        """Node with which all goals move along, None where none does; raise KernelError for some."""
        moving = {goal.reference for goal in self.goals if goal.moving}
        if not moving:
            return None
        if len(moving) > 1 or any(not goal.moving or goal.reference not in moving for goal in self.goals):
            raise KernelError(
                f"the goals of the spline of {self.robot!r} move along with {', '.join(map(repr, sorted(moving)))}; "
                "all of them must move along, with one node, or none",
                robot=self.robot,
            )
        return moving.pop()

    @property
    def path_reference(self) -> str:
        """Node that all goals move along with, or that the robot carries along a tool, or the world."""
        if not self.fixed_tool:
            return self.moving_reference or ""
        if len(self.references) > 1:
            frames = ", ".join(map(repr, self.references))
            raise KernelError(
                f"the goals of the spline of {self.robot!r} are in the frames of {frames}; along a tool that stands "
                "apart all are in one",
                robot=self.robot,
            )
        return self.goals[0].reference

    def path_from(self, snapshot: Snapshot, reference_t_start: Pose) -> CartesianPath:
        """Return the spline through the goals."""
        moving = self.moving_reference is not None or bool(self.fixed_tool)
        goals = [goal.reference_t_tcp if moving else world_t_goal(snapshot, goal) for goal in self.goals]
        return spline(reference_t_start, goals)

    def planner(self, snapshot: Snapshot, base_t_world: Pose) -> Callable[..., Plan]:
        """Return the planner of the spline; its errors name the goal that is nearest to the place."""
        return partial(plan_spline, base_t_goals=[base_t_world @ world_t_goal(snapshot, goal) for goal in self.goals])
