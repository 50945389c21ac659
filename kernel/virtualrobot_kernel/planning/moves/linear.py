"""Lines of the tool centre point (LIN), and searches on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.line import line_between
from virtualrobot_kernel.motion.plan import Plan, plan_lin
from virtualrobot_kernel.motion.signals import Condition
from virtualrobot_kernel.planning.moves.path_move import PathMove
from virtualrobot_kernel.planning.planned_move import PoseGoal, world_t_goal
from virtualrobot_kernel.planning.redundancy import FREE, Redundancy
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Snapshot


@dataclass(frozen=True, slots=True, eq=False)
class Linear(PathMove):
    """Straight line of the tool centre point; 0 stands for the default speed (m/s) and acceleration (m/s^2).

    until: the condition with which it ends before its goal, a search.
    """

    goal: PoseGoal
    speed_factor: float = 1.0
    max_velocity: float = 0.0
    max_acceleration: float = 0.0
    max_angular_velocity: float = 0.0
    redundancy: Redundancy = FREE
    until: Condition | None = None
    time_law: TimeLaw = TimeLaw.JERK_LIMITED

    @property
    def references(self) -> tuple[str, ...]:
        """Reference node of its goal."""
        return (self.goal.reference,)

    @property
    def moving_reference(self) -> str | None:
        """Reference node where the goal moves along with it; None where it does not."""
        return self.goal.reference if self.goal.moving else None

    @property
    def search(self) -> Condition | None:
        """Condition of a signal that ends it; None where it doesn't search."""
        return self.until

    @property
    def path_reference(self) -> str:
        """Reference node of its goal, in whose frame the path is."""
        return self.goal.reference

    def path_from(self, snapshot: Snapshot, reference_t_start: Pose) -> CartesianPath:
        """Return the line to the goal."""
        return line_between(reference_t_start, self.goal.reference_t_tcp)

    def planner(self, snapshot: Snapshot, base_t_world: Pose) -> Callable[..., Plan]:
        """Return the planner of the line."""
        return partial(plan_lin, base_t_goal=base_t_world @ world_t_goal(snapshot, self.goal))
