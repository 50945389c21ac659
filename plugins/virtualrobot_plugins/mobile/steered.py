"""Crafts with one steering drive and one driven wheel: exact arcs, and steering at a constant rate.

While the steering angle turns evenly the heading has a closed form, and the position is the integral of it, by six
points of Gauss. A step in which the steering comes to its stop is made in two.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.mobile.planar import (
    NEGLIGIBLE,
    arc,
    check_pose,
    check_seconds,
    check_twist,
    check_values,
    shifted,
)

_NODES, _WEIGHTS = (part.tolist() for part in np.polynomial.legendre.leggauss(6))


class Follower(NamedTuple):
    """Passive wheel or steering angle: where it stands in the base's frame (m), `front` at the steered axle."""

    name: str
    front: bool
    left: float
    is_steering: bool = False


class Steered:
    """Craft with its rear axle at the origin of its base, and driven and steered wheel on one line forward."""

    def __init__(
        self,
        *,
        driven: str,
        steering: str,
        followers: tuple[Follower, ...],
        wheelbase: float,
        wheel_radius: float,
        is_front_driven: bool,
        limit: float,
        rate: float,
        left: float = 0.0,
    ) -> None:
        """Take the geometry.

        Args:
            driven: name of the driven wheel.
            steering: name of the steering drive.
            followers: what turns with the craft.
            wheelbase: distance of the axles (m).
            wheel_radius: of all wheels (m).
            is_front_driven: whether the driven wheel is the steered one.
            limit: greatest steering angle to both sides (rad).
            rate: greatest speed of steering (rad/s), for `drive_commands`.
            left: how far left of the base's origin the line of the driven and the steered wheel is (m).
        """
        self.drive_names = (steering, driven)
        self.passive_names = tuple(follower.name for follower in followers)
        self._followers = followers
        self._wheelbase, self._radius, self._front = wheelbase, wheel_radius, is_front_driven
        self._limit, self._rate, self._left = limit, rate, left

    def step(
        self, world_t_base: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> tuple[Floats, Floats]:
        """Return where base and drives are; see the module."""
        pose = shifted(check_pose(world_t_base), 0.0, self._left, 0.0)
        angle, wheel, rate, speed = self._checked(drive_states, commands, seconds)
        for begin, turning, part in self._parts(angle, rate, seconds):
            if turning == 0.0:
                way = self._speed(begin, speed) * part
                pose = arc(pose, way, 0.0, way * math.tan(begin) / self._wheelbase)
                continue
            x = y = 0.0
            for node, weight in zip(_NODES, _WEIGHTS, strict=True):
                time = part * (1.0 + node) / 2.0
                way = self._speed(begin + turning * time, speed) * part * weight / 2.0
                heading = self._turn(begin, turning, speed, time)
                x, y = x + way * math.cos(heading), y + way * math.sin(heading)
            pose = shifted(pose, x, y, self._turn(begin, turning, speed, part))
        return shifted(pose, 0.0, -self._left, 0.0), np.array([self._end(drive_states, commands, seconds), wheel])

    def passive_states(
        self, passive_states: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> Floats:
        """Return where passive wheels and steering angles (p,) are after the step."""
        states = check_values("states of passive wheels", passive_states, self.passive_names).copy()
        angle, _, rate, speed = self._checked(drive_states, commands, seconds)
        end = self._end(drive_states, commands, seconds)
        for place, one in enumerate(self._followers):
            if one.is_steering:
                across, along = self._velocity(one, end, 1.0)
                states[place] = math.atan2(across, along)
                continue
            for begin, turning, part in self._parts(angle, rate, seconds):
                for node, weight in zip(_NODES, _WEIGHTS, strict=True):
                    now = begin + turning * part * (1.0 + node) / 2.0
                    across, along = self._velocity(one, now, self._speed(now, speed))
                    rolled = math.copysign(math.hypot(across, along), along) / self._radius
                    states[place] += rolled * part * weight / 2.0
        return states

    def base_twist(self, drive_states: Floats, commands: Floats, /) -> Floats:
        """Return the twist (3,) at the steering angle as it is."""
        angle, _, _, speed = self._checked(drive_states, commands, 1.0)
        way = self._speed(angle, speed)
        turn = way * math.tan(angle) / self._wheelbase
        return np.array([way + turn * self._left, 0.0, turn])

    def drive_commands(self, twist: Floats, drive_states: Floats, seconds: float, /) -> Floats:
        """Return the rate of steering, and the speed that the wheel needs once the steering angle is there."""
        vx, _, omega = check_twist(twist, sideways=False)
        angle = float(check_values("states of drives", drive_states, self.drive_names)[0])
        check_seconds(seconds)
        line = vx - omega * self._left
        if abs(vx) <= NEGLIGIBLE:
            if abs(omega) > NEGLIGIBLE:
                raise ArgumentError(
                    f"it cannot turn on the spot, at {omega:g} rad/s; it turns as it drives", omega=omega
                )
            return np.zeros(2)
        wanted = math.atan2(omega * self._wheelbase * math.copysign(1.0, line), abs(line))
        if abs(wanted) > self._limit or line * vx <= 0.0:
            least = self._wheelbase / math.tan(self._limit) + math.copysign(self._left, omega * vx)
            raise ArgumentError(
                f"it cannot turn at {omega:g} rad/s while it drives at {vx:g} m/s, on a radius of "
                f"{abs(vx / omega):.3g} m; its smallest to that side is {least:.3g} m",
                radius=abs(vx / omega),
                least=least,
            )
        rate = max(-self._rate, min(self._rate, (wanted - angle) / seconds))
        return np.array([rate, line / (self._radius * (math.cos(wanted) if self._front else 1.0))])

    def _checked(self, states: Floats, commands: Floats, seconds: float) -> tuple[float, float, float, float]:
        """Return the steering angle, the wheel's angle at the end, and both commands."""
        check_seconds(seconds)
        angle, wheel = check_values("states of drives", states, self.drive_names).tolist()
        rate, speed = check_values("commands", commands, self.drive_names).tolist()
        if abs(angle) >= math.pi / 2.0:
            raise ArgumentError(f"the steering angle is {angle:g} rad; it must be below 90 degrees", angle=angle)
        return angle, wheel + speed * seconds, rate, speed

    def _end(self, states: Floats, commands: Floats, seconds: float) -> float:
        """Return the steering angle after a step: no farther out than its stop, or than it was."""
        angle, end = float(states[0]), float(states[0] + commands[0] * seconds)
        most = max(self._limit, abs(angle))
        return max(-most, min(most, end))

    def _parts(self, angle: float, rate: float, seconds: float) -> Iterator[tuple[float, float, float]]:
        """Yield parts of a step: the steering angle at its begin, its rate (0 at the stop), and how long it is."""
        most = math.copysign(max(self._limit, abs(angle)), rate)
        to_stop = (most - angle) / rate if rate else math.inf
        if to_stop >= seconds:
            yield angle, rate, seconds
            return
        if to_stop > 0.0:
            yield angle, rate, to_stop
        yield most, 0.0, seconds - to_stop

    def _speed(self, angle: float, speed: float) -> float:
        """Return the speed (m/s) at the rear axle, on the line of the driven wheel."""
        return self._radius * speed * (math.cos(angle) if self._front else 1.0)

    def _turn(self, angle: float, rate: float, speed: float, seconds: float) -> float:
        """Return how far it has turned (rad) while the steering angle went on at a rate other than 0."""
        # The difference of the cosines, without losing digits of small ones.
        less = 2.0 * math.sin(angle + rate * seconds / 2.0) * math.sin(rate * seconds / 2.0)
        turned = less if self._front else -math.log1p(-less / math.cos(angle))
        return self._radius * speed / (self._wheelbase * rate) * turned

    def _velocity(self, one: Follower, angle: float, line: float) -> tuple[float, float]:
        """Return how fast a follower's place moves, to the left and forward, at a speed of the line (m/s)."""
        turn = line * math.tan(angle) / self._wheelbase
        return turn * self._wheelbase if one.front else 0.0, line + turn * (self._left - one.left)
