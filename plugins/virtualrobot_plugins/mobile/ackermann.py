"""The craft `ackermann`: a car, whose front wheels are steered so that all four roll about one point.

Drives are the steering angle and the driven wheel of the left side; linkage and differential gear make the right one
follow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta

from virtualrobot_plugins.mobile.planar import Length
from virtualrobot_plugins.mobile.steered import Follower, Steered


@dataclass(frozen=True, slots=True)
class AckermannSettings:
    """Settings of a car; the origin of its base is in the middle of the rear axle."""

    wheelbase_meters: Annotated[Length, Meta(description="Distance of the axles (m).")]
    track_meters: Annotated[Length, Meta(description="Distance of left and right wheels (m).")]
    wheel_radius_meters: Annotated[Length, Meta(description="Radius of the wheels (m).")]
    driven: Annotated[Literal["rear", "front"], Meta(description="Which axle is driven; the other one is passive.")] = (
        "rear"
    )
    steering_limit_radians: Annotated[
        float, Meta(gt=0, le=1.2, description="Greatest angle of the left front wheel to both sides (rad).")
    ] = 0.6
    steering_rate_radians_per_second: Annotated[
        float, Meta(gt=0, le=100, description="How fast it is steered where it follows a twist (rad/s).")
    ] = 2.0


class Ackermann(Steered):
    """A car: front wheels steered about one point, one axle driven through a differential gear."""

    def __init__(self, settings: AckermannSettings) -> None:
        """Take the settings."""
        half, front = settings.track_meters / 2.0, settings.driven == "front"
        wheels = (
            Follower("front_left_wheel", True, half),
            Follower("front_right_wheel", True, -half),
            Follower("rear_left_wheel", False, half),
            Follower("rear_right_wheel", False, -half),
        )
        driven = wheels[0] if front else wheels[2]
        steering = Follower("front_right_steering", True, -half, is_steering=True)
        super().__init__(
            driven=driven.name,
            steering="front_left_steering",
            followers=(steering, *(wheel for wheel in wheels if wheel is not driven)),
            wheelbase=settings.wheelbase_meters,
            wheel_radius=settings.wheel_radius_meters,
            is_front_driven=front,
            limit=settings.steering_limit_radians,
            rate=settings.steering_rate_radians_per_second,
            left=half,
        )
