"""Motors of joints under physics, as data: what each does, and how strong it is."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class MotorMode(Enum):
    """Mode of a motor; the names equal those of `MotorMode` in the contract."""

    UNSPECIFIED = "unspecified"
    """The usual one: VELOCITY for a joint that turns without end, POSITION for others."""
    FREE = "free"
    """None: the joint turns or slides by what pushes it, as a caster does."""
    VELOCITY = "velocity"
    """It holds the velocity that motions command, with as much effort as that takes and it has."""
    POSITION = "position"
    """It goes along with the position that motions command."""
    EFFORT = "effort"
    """Its effort is what clients set (`SetJointEfforts`); motions don't move it."""


@dataclass(frozen=True, slots=True)
class JointMotor:
    """Motor of a joint of a robot that is dynamic.

    stiffness (N m/rad, N/m) and damping (N m s/rad, N s/m) are those of a spring and a damper to what is commanded, of
    the mode POSITION; a stiffness of 0 means as stiff as the engine's motors are. max_effort (N m, N) is its greatest
    effort; 0 means that of the joint's limits, and without one there no limit.
    """

    joint: str
    mode: MotorMode = MotorMode.UNSPECIFIED
    stiffness: float = 0.0
    damping: float = 0.0
    max_effort: float = 0.0
