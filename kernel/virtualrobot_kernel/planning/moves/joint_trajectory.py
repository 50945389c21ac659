"""Joint trajectories: positions at times of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.plan import plan_trajectory
from virtualrobot_kernel.motion.segments import JointMotion, TrajectoryPoints, plan_points, points
from virtualrobot_kernel.planning.moves.move import Move
from virtualrobot_kernel.planning.planned_move import PlannedMove, joint_limits
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import SolverOf
from virtualrobot_kernel.world.commands import FromHere
from virtualrobot_kernel.world.from_here import joint_motion
from virtualrobot_kernel.world.state import Snapshot


@dataclass(frozen=True, slots=True, eq=False)
class Tolerances:
    """Tolerances (k, 2) of the positions and velocities of joints, None or 0 for any, on the way and at the goal.

    goal_seconds: how long the goal is waited for; 0: without end.
    """

    path: NDArray[np.float64] | None = None
    goal: NDArray[np.float64] | None = None
    goal_seconds: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class JointTrajectory(Move):
    """Trajectory of joints at times (n,) in seconds: positions (n, k), velocities, accelerations (n, k) or None.

    segments: whether each segment is given by its ends, from wherever the joints are; else it is one smooth curve from
    the first row. start_time: when time 0 is (s of simulation time); None: when it starts. from_motion: whether the
    joints may be on their way as it starts; else they are at rest.
    """

    joints: tuple[str, ...]
    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64] | None = None
    accelerations: NDArray[np.float64] | None = None
    segments: bool = False
    start_time: float | None = None
    tolerances: Tolerances = Tolerances()
    from_motion: bool = False

    not_joined: ClassVar[str] = "a joint trajectory has times of its own"
    timed: ClassVar[bool] = True

    @property
    def alone(self) -> str:
        """Field for which it has to be the only move of its motion; empty where it needn't be."""
        if self.start_time is not None:
            return "start_time_seconds"
        if self.tolerances.path is not None:
            return "path_tolerances"
        return "goal_tolerances" if self.tolerances.goal is not None else ""

    def joint_names(self, snapshot: Snapshot) -> Sequence[str]:
        """Return its joints."""
        return self.joints

    def plan(self, snapshot: Snapshot, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan; raise KernelError where it names joints twice or begins elsewhere than they are."""
        node = self.node(snapshot)
        limits, start = self._limits(snapshot)
        if not self.segments:
            plan = plan_trajectory(start, self.times, self.positions, self.velocities, limits)
            return PlannedMove(node, self.joints, plan)
        here = JointMotion(start, np.zeros(len(start)), np.zeros(len(start)))
        if self.from_motion:
            named = tuple((node.uid, joint) for joint in self.joints)
            here = joint_motion(snapshot.structure, snapshot.state, named)
        elapsed = 0.0 if self.start_time is None else snapshot.simulation_time - self.start_time
        return PlannedMove(node, self.joints, plan_points(self._points(limits), here, elapsed, limits))

    def from_here(self, snapshot: Snapshot) -> FromHere | None:
        """Return what its plan is made anew of as it starts; None where it begins at its first row."""
        if not self.segments:
            return None
        limits, _ = self._limits(snapshot)
        begin = None if self.start_time is None else self.start_time / snapshot.tick_seconds
        return FromHere(self._points(limits), limits, begin, snapshot.tick_seconds)

    def _limits(self, snapshot: Snapshot) -> tuple[JointLimits, NDArray[np.float64]]:
        node = self.node(snapshot)
        if not self.joints or len(set(self.joints)) != len(self.joints):
            raise KernelError(f"a trajectory must name its joints, each once, not {list(self.joints)}", robot=node.name)
        return joint_limits(snapshot, node, self.joints)

    def _points(self, limits: JointLimits) -> TrajectoryPoints:
        return points(self.times, self.positions, self.velocities, self.accelerations, limits)
