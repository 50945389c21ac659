"""Jogs of one joint, as somebody at a pendant chooses them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, tau

import numpy as np

from virtualrobot_kernel.motion.jog import plan_joint_jog
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.planning.moves.move import Move
from virtualrobot_kernel.planning.notes import jog_notes
from virtualrobot_kernel.planning.planned_move import PlannedMove, joint_limits
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import SolverOf
from virtualrobot_kernel.world.actuators import actuators_of
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import JointType, Node


@dataclass(frozen=True, slots=True, eq=False)
class JointJog(Move):
    """Jog of one joint, at a signed velocity (rad/s or m/s); distance None: until its limit or a whole turn."""

    joint: str
    velocity: float
    distance: float | None = None
    speed_factor: float = 1.0

    def joint_names(self, snapshot: Snapshot) -> Sequence[str]:
        """Return the joint."""
        return (self.joint,)

    def plan(self, snapshot: Snapshot, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan, which ends early where the joint or an actuator can go no further; a note tells that."""
        node = self.node(snapshot)
        limits, start = joint_limits(snapshot, node, (self.joint,))
        limits = _within_actuators(snapshot, node, limits)
        distance = inf if self.distance is None else self.distance
        endless = np.isinf(limits.upper if self.velocity > 0.0 else limits.lower)[0]
        if self.distance is None and endless:
            joint = single_joint(snapshot.structure, node, self.joint)[0]
            distance = inf if joint.type is JointType.PRISMATIC else tau
        speed_factor = self.speed_factor or 1.0
        plan, end = plan_joint_jog(float(start[0]), self.velocity, distance, limits, speed_factor)
        share = speed_factor * abs(self.velocity) / float(limits.velocity[0])
        return PlannedMove(node, (self.joint,), plan, speed_factor=share, notes=jog_notes(node.name, end))


def _within_actuators(snapshot: Snapshot, node: Node, limits: JointLimits) -> JointLimits:
    """Return the limits of one joint, narrowed to where the other joints of its actuators let it go."""
    (name,) = limits.names
    lower, upper = float(limits.lower[0]), float(limits.upper[0])
    for actuator in actuators_of(node):
        ratio, rest = 0.0, actuator.offset
        for joint, factor in actuator.terms:
            if joint == name:
                ratio += factor
            else:
                rest += factor * float(snapshot.state.q[single_joint(snapshot.structure, node, joint)[1]])
        if ratio:
            ends = sorted(((actuator.lower - rest) / ratio, (actuator.upper - rest) / ratio))
            lower, upper = max(lower, ends[0]), min(upper, ends[1])
    return replace(limits, lower=np.array([min(lower, upper)]), upper=np.array([upper]))
