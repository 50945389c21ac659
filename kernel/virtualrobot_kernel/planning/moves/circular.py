"""Arcs of the tool centre point (CIRC), and searches on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.circle import Center, Via, arc
from virtualrobot_kernel.motion.plan import Plan, plan_circ
from virtualrobot_kernel.motion.signals import Condition
from virtualrobot_kernel.planning.moves.path_move import PathMove
from virtualrobot_kernel.planning.redundancy import FREE, Redundancy
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Snapshot


@dataclass(frozen=True, slots=True, eq=False)
class Circular(PathMove):
    """Arc of the tool centre point through a point or about a centre; 0 stands for the default speed, as for a line.

    All is given in the frame of the node `reference`; reference_t_goal (4, 4) may be None when the centre has an angle.
    `with_arc`: the tool turns as the arc does instead of evenly to the goal's orientation. `moving`: the reference
    moves with other moves of the same step, and the arc goes along. `until`: the condition with which it ends before
    its goal, a search.
    """

    shape: Via | Center
    reference_t_goal: Pose | None = None
    reference: str = ""
    with_arc: bool = False
    speed_factor: float = 1.0
    max_velocity: float = 0.0
    max_acceleration: float = 0.0
    max_angular_velocity: float = 0.0
    redundancy: Redundancy = FREE
    time_law: TimeLaw = TimeLaw.JERK_LIMITED
    moving: bool = False
    until: Condition | None = None

    @property
    def references(self) -> tuple[str, ...]:
        """Reference node of its goal."""
        return (self.reference,)

    @property
    def moving_reference(self) -> str | None:
        """Reference node where the goal moves along with it; None where it does not."""
        return self.reference if self.moving else None

    @property
    def search(self) -> Condition | None:
        """Condition of a signal that ends it; None where it doesn't search."""
        return self.until

    @property
    def path_reference(self) -> str:
        """Reference node of its goal, in whose frame the path is."""
        return self.reference

    def path_from(self, snapshot: Snapshot, reference_t_start: Pose) -> CartesianPath:
        """Return the arc to the goal."""
        return arc(reference_t_start, self.shape, self.reference_t_goal, self.with_arc)

    def planner(self, snapshot: Snapshot, base_t_world: Pose) -> Callable[..., Plan]:
        """Return the planner of the arc."""
        base_t_reference = base_t_world @ snapshot.world_t(snapshot.structure.node(self.reference).uid)
        goal = self.reference_t_goal
        return partial(
            plan_circ,
            shape=self.shape.seen_from(base_t_reference),
            base_t_goal=None if goal is None else base_t_reference @ goal,
            with_arc=self.with_arc,
        )
