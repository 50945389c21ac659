"""Redundancy resolution: use of the joints that an arm has beyond those that its goal needs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

from virtualrobot_kernel.motion.nullspace import Near
from virtualrobot_kernel.world.state import Snapshot

if TYPE_CHECKING:
    from virtualrobot_kernel.planning.robots import Arm

NearOf = Callable[[Snapshot, "Arm"], Near]
"""Factory of the distances of an arm from everything else in a world."""


class Preference(Enum):
    """Preference for the use of free joints; the names equal those of `RedundancyPreference` in the contract."""

    UNSPECIFIED = "UNSPECIFIED"
    JOINT_LIMITS = "JOINT_LIMITS"
    MANIPULABILITY = "MANIPULABILITY"
    POSTURE = "POSTURE"
    DISTANCE = "DISTANCE"


@dataclass(frozen=True, slots=True, eq=False)
class Redundancy:
    """Joints that stand still, the arm angle (rad), and what the other joints are used for.

    `locked_joints` and `posture` are radians or metres by joint name; `posture` goes with POSTURE. Planning knows no
    shapes: what measures distances for DISTANCE is given to it as a `NearOf`, beside the solvers.
    """

    locked_joints: Mapping[str, float] = field(default_factory=dict)
    arm_angle: float | None = None
    preference: Preference = Preference.UNSPECIFIED
    posture: Mapping[str, float] = field(default_factory=dict)


FREE = Redundancy()
"""Redundancy without any objective."""
