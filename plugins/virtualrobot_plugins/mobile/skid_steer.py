"""The craft `skid_steer`: four driven wheels that point forward and slip to the side as it turns.

It moves as one on two wheels that stand farther apart (A. Mandow et al., Experimental kinematics for wheeled skid-steer
mobile robots, IROS 2007).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

from virtualrobot_plugins.mobile.planar import Length
from virtualrobot_plugins.mobile.rolling import Rolling


@dataclass(frozen=True, slots=True)
class SkidSteerSettings:
    """Settings of a craft with four driven wheels; the origin of its base is in the middle of them."""

    track_meters: Annotated[Length, Meta(description="Distance of left and right wheels (m).")]
    wheel_radius_meters: Annotated[Length, Meta(description="Radius of the wheels (m).")]
    slip: Annotated[
        float,
        Meta(
            ge=1, le=10, description="How many times farther apart wheels would stand that turn it as fast unslipped."
        ),
    ] = 1.0


class SkidSteer(Rolling):
    """Four driven wheels that point forward; those of a side are told the same, or contradict each other and slip."""

    def __init__(self, settings: SkidSteerSettings) -> None:
        """Take the settings."""
        forward = 1.0 / settings.wheel_radius_meters
        turning = settings.track_meters * settings.slip / 2.0 * forward
        rates = np.array([[forward, 0.0, side * turning] for side in (-1.0, 1.0, -1.0, 1.0)])
        super().__init__(("front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"), rates)
