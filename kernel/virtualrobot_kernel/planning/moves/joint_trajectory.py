"""Joint trajectories: positions at times of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.plan import plan_trajectory
from virtualrobot_kernel.planning.moves.move import Move
from virtualrobot_kernel.planning.planned_move import PlannedMove, joint_limits
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import SolverOf
from virtualrobot_kernel.world.state import Snapshot


@dataclass(frozen=True, slots=True, eq=False)
class JointTrajectory(Move):
    """Trajectory of joints at times (n,) in seconds: positions (n, k), velocities (n, k) or None."""

    joints: tuple[str, ...]
    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64] | None = None

    not_joined: ClassVar[str] = "a joint trajectory has times of its own"
    timed: ClassVar[bool] = True

    def joint_names(self, snapshot: Snapshot) -> Sequence[str]:
        """Return its joints."""
        return self.joints

    def plan(self, snapshot: Snapshot, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan; raise KernelError where it names joints twice or begins elsewhere than they are."""
        node = self.node(snapshot)
        if not self.joints or len(set(self.joints)) != len(self.joints):
            raise KernelError(f"a trajectory must name its joints, each once, not {list(self.joints)}", robot=node.name)
        limits, start = joint_limits(snapshot, node, self.joints)
        plan = plan_trajectory(start, self.times, self.positions, self.velocities, limits)
        return PlannedMove(node, self.joints, plan)
