"""The craft `differential`: two driven wheels on one axis (Siegwart and Nourbakhsh, Autonomous Mobile Robots, 3.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

from virtualrobot_plugins.mobile.planar import Length
from virtualrobot_plugins.mobile.rolling import Rolling


@dataclass(frozen=True, slots=True)
class DifferentialSettings:
    """Settings of a craft with two driven wheels; the origin of its base is in the middle between them."""

    track_meters: Annotated[Length, Meta(description="Distance of the wheels (m).")]
    wheel_radius_meters: Annotated[Length, Meta(description="Radius of the left wheel, and of the right one (m).")]
    right_wheel_radius_meters: Annotated[
        float, Meta(ge=0, le=100, description="Radius of the right wheel (m), where it is another one; 0: the same.")
    ] = 0.0


class Differential(Rolling):
    """Two driven wheels on one axis; casters carry the rest. It turns on the spot and never moves to the side."""

    def __init__(self, settings: DifferentialSettings) -> None:
        """Take the settings."""
        half, left = settings.track_meters / 2.0, settings.wheel_radius_meters
        right = settings.right_wheel_radius_meters or left
        rates = np.array([[1.0 / left, 0.0, -half / left], [1.0 / right, 0.0, half / right]])
        super().__init__(("left_wheel", "right_wheel"), rates)
