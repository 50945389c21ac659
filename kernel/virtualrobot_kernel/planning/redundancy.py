"""What an arm is wished to do with the joints that it has beyond those that its goal needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum


class Preference(Enum):
    """What free joints are used for; the names equal those of `RedundancyPreference` in the contract."""

    UNSPECIFIED = "UNSPECIFIED"
    JOINT_LIMITS = "JOINT_LIMITS"
    MANIPULABILITY = "MANIPULABILITY"
    POSTURE = "POSTURE"


@dataclass(frozen=True, slots=True, eq=False)
class Redundancy:
    """Joints that stand still, the arm angle (rad), and what the other joints are used for.

    `locked_joints` and `posture` are radians or metres by joint name; `posture` goes with POSTURE.
    """

    locked_joints: Mapping[str, float] = field(default_factory=dict)
    arm_angle: float | None = None
    preference: Preference = Preference.UNSPECIFIED
    posture: Mapping[str, float] = field(default_factory=dict)


FREE = Redundancy()
"""No wish."""
