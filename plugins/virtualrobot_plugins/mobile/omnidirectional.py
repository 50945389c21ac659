"""The craft `omnidirectional`: three or four swedish wheels on a circle round the middle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta

from virtualrobot_plugins.mobile.planar import Length
from virtualrobot_plugins.mobile.rolling import Rolling


@dataclass(frozen=True, slots=True)
class OmnidirectionalSettings:
    """Settings of a craft with three or four swedish wheels at equal angles round the origin of its base."""

    radius_meters: Annotated[Length, Meta(description="Distance of the wheels from the middle (m).")]
    wheel_radius_meters: Annotated[Length, Meta(description="Radius of the wheels (m).")]
    wheels: Annotated[Literal[3, 4], Meta(description="How many there are.")] = 3
    first_angle_radians: Annotated[
        float,
        Meta(ge=-6.3, le=6.3, description="Direction of the first wheel from the middle; others to the left."),
    ] = 0.0


class Omnidirectional(Rolling):
    """Three or four swedish wheels; each rolls to the left of its direction from the middle."""

    def __init__(self, settings: OmnidirectionalSettings) -> None:
        """Take the settings."""
        count = settings.wheels
        angles = settings.first_angle_radians + np.arange(count) * (2.0 * math.pi / count)
        rates = np.column_stack([-np.sin(angles), np.cos(angles), np.full(count, settings.radius_meters)])
        names = tuple(f"wheel_{number}" for number in range(1, count + 1))
        super().__init__(names, rates / settings.wheel_radius_meters)
