"""Joint limits from what a model file tells: files know position, speed and effort, motions need acceleration and jerk.

The kernel's rule, in one place: full speed is reached in a quarter of a second at constant acceleration, and full
acceleration in a tenth of a second at constant jerk. It gives the defaults of `JointLimits` (2, 8, 80) too. Industrial
arms are in this range: a KUKA iiwa at 1.7 rad/s gets 6.9 rad/s^2.
"""

from __future__ import annotations

import numpy as np

from virtualrobot_kernel.world.structure import JointLimits

ACCELERATION_PER_VELOCITY = 4.0
"""Acceleration in rad/s^2 (m/s^2) for each rad/s (m/s) of greatest speed: 1/s."""

JERK_PER_ACCELERATION = 10.0
"""Jerk in rad/s^3 (m/s^3) for each rad/s^2 (m/s^2) of greatest acceleration: 1/s."""


def joint_limits(
    lower: float = -np.inf, upper: float = np.inf, velocity: float = 0.0, effort: float = 0.0
) -> JointLimits:
    """Return limits with acceleration and jerk in proportion to `velocity`; a velocity of 0 means unknown.

    Positions in rad or m, velocity in rad/s or m/s, effort in N m or N (0: unknown).
    """
    if velocity == 0.0:
        return JointLimits(lower=lower, upper=upper, effort=effort)
    acceleration = ACCELERATION_PER_VELOCITY * velocity
    return JointLimits(lower, upper, velocity, acceleration, JERK_PER_ACCELERATION * acceleration, effort)
