"""The craft `mecanum`: four wheels with rollers at 45 degrees (Lynch and Park, Modern Robotics, 13.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

from virtualrobot_plugins.mobile.planar import Length
from virtualrobot_plugins.mobile.rolling import Rolling


@dataclass(frozen=True, slots=True)
class MecanumSettings:
    """Settings of a craft with four mecanum wheels; the origin of its base is in the middle of them."""

    wheelbase_meters: Annotated[Length, Meta(description="Distance of front and rear wheels (m).")]
    track_meters: Annotated[Length, Meta(description="Distance of left and right wheels (m).")]
    wheel_radius_meters: Annotated[Length, Meta(description="Radius of the wheels (m).")]


class Mecanum(Rolling):
    """Four mecanum wheels; seen from above, the axes of their upper rollers make an O round the middle."""

    def __init__(self, settings: MecanumSettings) -> None:
        """Take the settings."""
        arm = (settings.wheelbase_meters + settings.track_meters) / 2.0
        signs = ((-1.0, -1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0))
        rates = np.array([[1.0, across, side * arm] for across, side in signs]) / settings.wheel_radius_meters
        super().__init__(("front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"), rates)
