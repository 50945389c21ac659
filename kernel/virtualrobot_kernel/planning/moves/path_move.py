"""Moves whose tool centre point is led along a path: the common base of lines, arcs and splines."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import partial

from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.planning.apart import plan_apart, stands_still
from virtualrobot_kernel.planning.free_joints import cartesian_tcp
from virtualrobot_kernel.planning.moves.move import Move
from virtualrobot_kernel.planning.moving_base import MovingBase, plan_on_moving_base
from virtualrobot_kernel.planning.planned_move import PlannedMove, cartesian_limits, joint_limits, led_move
from virtualrobot_kernel.planning.redundancy import NearOf, Redundancy
from virtualrobot_kernel.planning.robots import SolverOf, arm_on_path
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Snapshot


class PathMove(Move):
    """Move of the tool centre point along a path; each kind has these fields."""

    __slots__ = ()

    speed_factor: float
    max_velocity: float
    max_acceleration: float
    max_angular_velocity: float
    redundancy: Redundancy
    time_law: TimeLaw

    @property
    @abstractmethod
    def path_reference(self) -> str:
        """Node in whose frame `path_from` is."""

    @abstractmethod
    def path_from(self, snapshot: Snapshot, reference_t_start: Pose) -> CartesianPath:
        """Return the path that begins at a pose (4, 4), in the frame of `path_reference`."""

    @abstractmethod
    def planner(self, snapshot: Snapshot, base_t_world: Pose) -> Callable[..., Plan]:
        """Return the planner of `motion.plan` for this path, seen from the arm's base."""

    @property
    def solved(self) -> bool:
        """True: a path of a tool centre point needs the kinematics component."""
        return True

    def _cartesian_limits(self) -> CartesianLimits:
        rates = (self.max_velocity, self.max_acceleration, self.max_angular_velocity)
        return cartesian_limits(*rates, self.gentle)

    def joint_names(self, snapshot: Snapshot) -> Sequence[str]:
        """Return the joints of the arm that are not locked."""
        return arm_on_path(snapshot, self.node(snapshot), self.redundancy, self.group).joint_names

    def plan(self, snapshot: Snapshot, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan; raise KernelError with the place."""
        node = self.node(snapshot)
        arm = arm_on_path(snapshot, node, self.redundancy, self.group)
        if self.fixed_tool:
            return plan_apart(
                snapshot,
                arm,
                self.fixed_tool,
                self.path_reference,
                partial(self.path_from, snapshot),
                self._cartesian_limits(),
                self.speed_factor or 1.0,
                self.redundancy,
                self.time_law,
                self.gentle,
                solver_of,
                near_of,
            )
        limits, start = joint_limits(snapshot, node, arm.joint_names)
        planner = self.planner(snapshot, inverse(snapshot.world_t(arm.base)))
        tcp = cartesian_tcp(snapshot, arm, solver_of, self.redundancy, near_of)
        cartesian, factor = self._cartesian_limits(), self.speed_factor or 1.0
        plan = planner(
            kinematics=tcp.kinematics,
            q_start=start,
            limits=limits,
            cartesian_limits=cartesian,
            velocity_scale=factor,
            tip_t_tcp=tcp.tip_t_tcp,
            time_law=self.time_law,
            objective=tcp.objective,
            gentle=self.gentle,
        )
        return led_move(node, arm, plan, tcp, cartesian, factor, self.gentle)

    def plan_on(self, base: MovingBase, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan on a base, or towards a reference, that moves."""
        snapshot = base.snapshot
        if self.fixed_tool:
            raise stands_still(self.robot, self.fixed_tool)
        return plan_on_moving_base(
            arm_on_path(snapshot, self.node(snapshot), self.redundancy, self.group),
            base,
            lambda reference_t_start: self.path_from(snapshot, reference_t_start),
            snapshot.structure.node(self.path_reference).uid,
            self.moving_reference is not None,
            self._cartesian_limits(),
            self.speed_factor or 1.0,
            solver_of,
            self.gentle,
        )
