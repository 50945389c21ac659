"""The craft `bicycle`: a steered wheel ahead of another one, either of them driven.

It turns by omega = v / R with R = wheelbase / tan(steering angle), v at the rear wheel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta

from virtualrobot_plugins.mobile.planar import Length
from virtualrobot_plugins.mobile.steered import Follower, Steered


@dataclass(frozen=True, slots=True)
class BicycleSettings:
    """Settings of a craft with a wheel ahead of the other; the origin of its base is at the rear wheel."""

    wheelbase_meters: Annotated[Length, Meta(description="Distance of the wheels (m).")]
    wheel_radius_meters: Annotated[Length, Meta(description="Radius of the wheels (m).")]
    driven: Annotated[
        Literal["rear", "front"], Meta(description="Which wheel is driven; the other one is passive.")
    ] = "rear"
    steering_limit_radians: Annotated[
        float, Meta(gt=0, le=1.5, description="Greatest steering angle to both sides (rad).")
    ] = 0.7
    steering_rate_radians_per_second: Annotated[
        float, Meta(gt=0, le=100, description="How fast it is steered where it follows a twist (rad/s).")
    ] = 2.0


class Bicycle(Steered):
    """A steered wheel ahead of another one; the driven one may be either."""

    def __init__(self, settings: BicycleSettings) -> None:
        """Take the settings."""
        front = settings.driven == "front"
        wheels = ("rear_wheel", "front_wheel")
        super().__init__(
            driven=wheels[front],
            steering="steering",
            followers=(Follower(wheels[not front], not front, 0.0),),
            wheelbase=settings.wheelbase_meters,
            wheel_radius=settings.wheel_radius_meters,
            is_front_driven=front,
            limit=settings.steering_limit_radians,
            rate=settings.steering_rate_radians_per_second,
        )
