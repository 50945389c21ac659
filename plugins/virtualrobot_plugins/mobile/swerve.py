"""The craft `swerve`: four wheels, each of which is steered and driven by itself.

While steering angles turn evenly the heading has a closed form, and the position is the integral of it, by six points
of Gauss in parts of a step in which nothing turns by more than half a radian.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.mobile.planar import (
    NEGLIGIBLE,
    Length,
    arc,
    check_pose,
    check_seconds,
    check_twist,
    check_values,
    shifted,
)

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")

_MOST_TURN = 0.5
"""Greatest turn (rad) of a wheel or of the craft in one part of a step."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True, slots=True)
class SwerveSettings:
    """Settings of a craft on four wheels that are steered and driven, with the origin of its base in the middle."""

    wheelbase_meters: Annotated[Length, Meta(description="Distance of front and rear wheels (m).")]
    track_meters: Annotated[Length, Meta(description="Distance of left and right wheels (m).")]
    wheel_radius_meters: Annotated[Length, Meta(description="Radius of the wheels (m).")]
    steering_rate_radians_per_second: Annotated[
        float, Meta(gt=0, le=100, description="How fast wheels are steered where they follow a twist (rad/s).")
    ] = 2.0


class Swerve:
    """Four steer-ahead drives, which turn without end; where they contradict each other they slip.

    The craft then moves by the least squares of the velocities of their places.
    """

    drive_names = (*(f"{corner}_steering" for corner in CORNERS), *(f"{corner}_wheel" for corner in CORNERS))
    passive_names: tuple[str, ...] = ()

    def __init__(self, settings: SwerveSettings) -> None:
        """Take the settings."""
        x, y = settings.wheelbase_meters / 2.0, settings.track_meters / 2.0
        places = ((x, y), (x, -y), (-x, y), (-x, -y))
        # Velocities of the places, ahead and to the left, for a twist of 1 each.
        self._velocities = np.array([row for px, py in places for row in ((1.0, 0.0, -py), (0.0, 1.0, px))])
        self._twists = np.linalg.pinv(self._velocities)
        self._radius, self._rate = settings.wheel_radius_meters, settings.steering_rate_radians_per_second

    def step(
        self, world_t_base: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> tuple[Floats, Floats]:
        """Return where base and drives are; see the module."""
        pose = check_pose(world_t_base)
        check_seconds(seconds)
        angles, rates, speeds = self._checked(drive_states, commands)
        moved = drive_states + commands * seconds
        if not rates.any():
            x, y, turn = (self._twist(angles, speeds) * seconds).tolist()
            return arc(pose, x, y, turn), moved
        fastest = max(float(np.abs(rates).max()), float(np.abs(self._twists[2]).sum() * np.abs(speeds).max()))
        count = math.ceil(fastest * seconds / _MOST_TURN)
        part = seconds / count
        for place in range(count):
            begin = angles + rates * (part * place)
            x = y = 0.0
            for node, weight in zip(_NODES.tolist(), _WEIGHTS.tolist(), strict=True):
                time = part * (1.0 + node) / 2.0
                heading = float(self._way(begin, rates, speeds, time)[2])
                vx, vy, _ = (self._twist(begin + rates * time, speeds) * (part * weight / 2.0)).tolist()
                x += math.cos(heading) * vx - math.sin(heading) * vy
                y += math.sin(heading) * vx + math.cos(heading) * vy
            pose = shifted(pose, x, y, float(self._way(begin, rates, speeds, part)[2]))
        return pose, moved

    def passive_states(
        self, passive_states: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> Floats:
        """Return nothing: all wheels are driven."""
        return check_values("states of passive wheels", passive_states, ()).copy()

    def base_twist(self, drive_states: Floats, commands: Floats, /) -> Floats:
        """Return the twist (3,) at the steering angles as they are."""
        angles, _, speeds = self._checked(drive_states, commands)
        return self._twist(angles, speeds)

    def drive_commands(self, twist: Floats, drive_states: Floats, seconds: float, /) -> Floats:
        """Return rates of steering, and the speeds that the wheels need once the steering angles are there (8,).

        A wheel is steered by a quarter of a turn at most, and rolls back where that is nearer.
        """
        check_twist(twist, sideways=True)
        check_seconds(seconds)
        angles = check_values("states of drives", drive_states, self.drive_names)[: len(CORNERS)].tolist()
        rates, speeds = [], []
        for angle, (vx, vy) in zip(angles, (self._velocities @ twist).reshape(-1, 2).tolist(), strict=True):
            speed = math.hypot(vx, vy)
            if speed <= NEGLIGIBLE:
                rates.append(0.0)
                speeds.append(0.0)
                continue
            left = math.remainder(math.atan2(vy, vx) - angle, 2.0 * math.pi)
            if abs(left) > math.pi / 2.0:
                left, speed = left - math.copysign(math.pi, left), -speed
            rates.append(max(-self._rate, min(self._rate, left / seconds)))
            speeds.append(speed / self._radius)
        return np.array(rates + speeds)

    def _checked(self, states: Floats, commands: Floats) -> tuple[Floats, Floats, Floats]:
        """Return steering angles, their rates, and the speeds of the wheels where they touch the ground (m/s)."""
        count = len(CORNERS)
        angles = check_values("states of drives", states, self.drive_names)[:count]
        told = check_values("commands", commands, self.drive_names)
        return angles, told[:count], told[count:] * self._radius

    def _twist(self, angles: Floats, speeds: Floats) -> Floats:
        return self._twists @ np.column_stack([speeds * np.cos(angles), speeds * np.sin(angles)]).ravel()

    def _way(self, angles: Floats, rates: Floats, speeds: Floats, seconds: float) -> Floats:
        """Return the integral of the twist over a time in which steering angles turn evenly."""
        half = rates * seconds / 2.0
        return self._twist(angles + half, speeds * np.sinc(half / math.pi) * seconds)
