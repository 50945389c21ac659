"""The craft `tricycle`: a wheel ahead that steers and drives, and two passive wheels on the rear axle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from virtualrobot_plugins.mobile.planar import Length
from virtualrobot_plugins.mobile.steered import Follower, Steered


@dataclass(frozen=True, slots=True)
class TricycleSettings:
    """Settings of a craft on three wheels; the origin of its base is in the middle of the rear axle."""

    wheelbase_meters: Annotated[Length, Meta(description="Distance of the front wheel from the rear axle (m).")]
    track_meters: Annotated[Length, Meta(description="Distance of the rear wheels (m).")]
    wheel_radius_meters: Annotated[Length, Meta(description="Radius of the wheels (m).")]
    steering_limit_radians: Annotated[
        float, Meta(gt=0, le=1.5, description="Greatest steering angle to both sides (rad).")
    ] = 1.2
    steering_rate_radians_per_second: Annotated[
        float, Meta(gt=0, le=100, description="How fast it is steered where it follows a twist (rad/s).")
    ] = 2.0


class Tricycle(Steered):
    """A steer-ahead drive at the front and two passive rear wheels, as a forklift has them."""

    def __init__(self, settings: TricycleSettings) -> None:
        """Take the settings."""
        half = settings.track_meters / 2.0
        super().__init__(
            driven="front_wheel",
            steering="steering",
            followers=(Follower("rear_left_wheel", False, half), Follower("rear_right_wheel", False, -half)),
            wheelbase=settings.wheelbase_meters,
            wheel_radius=settings.wheel_radius_meters,
            is_front_driven=True,
            limit=settings.steering_limit_radians,
            rate=settings.steering_rate_radians_per_second,
        )
