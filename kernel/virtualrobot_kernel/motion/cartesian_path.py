"""Cartesian paths, those of a tool centre point: their protocol, and the base of those that turn about one axis."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from virtualrobot_sdk.poses import rotation_matrix, rotation_vector

from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.polynomial import Array

#: Below these a path has no length (m) or no turn (rad): moving is pointless and the axis undefined.
SHORTEST_LENGTH, SMALLEST_ANGLE = 1e-9, 1e-9


@dataclass(frozen=True, eq=False)
class CartesianPath(ABC):
    """Poses base_t_tcp(u), u in [0, 1], from `base_t_start` (4, 4) to the goal, twice continuously differentiable.

    `kind` and `noun` are what the motion and its path are called. Just outside of [0, 1] a path goes on smoothly.
    """

    kind: ClassVar[str]
    noun: ClassVar[str]

    base_t_start: Array

    @property
    @abstractmethod
    def length(self) -> float:
        """Length of the way of the position in m."""

    @property
    @abstractmethod
    def angle(self) -> float:
        """Angle that the orientation turns in all, in rad."""

    @abstractmethod
    def travelled(self, u: float) -> tuple[float, float]:
        """Return how much of length (m) and angle (rad) is done at the fraction `u`."""

    @abstractmethod
    def pose(self, u: float) -> Array:
        """Return base_t_tcp (4, 4) at the fraction `u`."""

    @abstractmethod
    def twist(self, u: float) -> Array:
        """Return the derivative (6,) of the pose by u at `u`: m, then rad, base frame, at the TCP."""

    @property
    def stations(self) -> tuple[tuple[float, str], ...]:
        """Named fractions, in the order in which the arm's reach is checked at them."""
        return ((1.0, "goal"),)

    @property
    def knots(self) -> tuple[float, ...]:
        """Fractions, rising, between 0 and 1, where a derivative of the path jumps."""
        return ()

    def deviation(self, u: float, base_t_tcp: Array) -> Array:
        """Return the twist (6,) that takes `base_t_tcp` to the path's pose at `u`: m and rad in the base frame."""
        wanted = self.pose(u)
        turn = rotation_vector(wanted[:3, :3] @ base_t_tcp[:3, :3].T)
        return np.concatenate([wanted[:3, 3] - base_t_tcp[:3, 3], turn])

    def place(self, u: float) -> tuple[str, dict[str, object]]:
        """Return the place of `u`, as words and as metadata: fraction, millimetres, degrees, pose in the base frame.

        The pose is told as position and rotation vector, three numbers each, in m and rad.
        """
        pose = self.pose(u)
        x, y, z = pose[:3, 3]
        way, turn = self.travelled(u)
        travelled, whole = way * 1e3, self.length * 1e3
        turned, angle = np.degrees(turn), np.degrees(self.angle)
        words = (
            f"at {100.0 * u:.1f}% of the {self.noun} ({travelled:.1f} of {whole:.1f} mm, {turned:.1f} of {angle:.1f} "
            f"degrees, TCP at x {x:.4f}, y {y:.4f}, z {z:.4f} m in the base frame)"
        )
        position = f"{x:.6f}, {y:.6f}, {z:.6f}"
        return words, {
            "fraction": f"{u:.6f}",
            "millimeters": f"{travelled:.3f}",
            "degrees": f"{turned:.3f}",
            "position": position,
            "rotation": ", ".join(f"{part:.9f}" for part in rotation_vector(pose[:3, :3])),
        }


@dataclass(frozen=True, eq=False)
class RelatedPath(CartesianPath):
    """Path that follows from another one, `inner`, whose frame moves or is carried: its ways are those of that one."""

    inner: CartesianPath

    @property
    def length(self) -> float:
        """Length of the inner way in m."""
        return self.inner.length

    @property
    def angle(self) -> float:
        """Angle that the orientation turns on the inner way, in rad."""
        return self.inner.angle

    def travelled(self, u: float) -> tuple[float, float]:
        """Return how much of length (m) and angle (rad) is done at the fraction `u`."""
        return self.inner.travelled(u)

    @property
    def stations(self) -> tuple[tuple[float, str], ...]:
        """Named fractions of the inner path."""
        return self.inner.stations

    @property
    def knots(self) -> tuple[float, ...]:
        """Fractions where a derivative of the inner path jumps."""
        return self.inner.knots


@dataclass(frozen=True, eq=False)
class ConstantSpeedPath(CartesianPath):
    """Path with constant speed |dp/du| of the position, whose orientation turns about one fixed axis (slerp).

    rotation (3,): rotation(u) = Rot(u * rotation) R_start, the rotation vector in rad in the base frame.
    """

    rotation: Array

    @abstractmethod
    def position(self, u: float) -> Array:
        """Return the position (3,) at the fraction `u` in m, base frame."""

    def tangential(self, limits: CartesianLimits, speed: float) -> tuple[float, float, float]:
        """Return the greatest velocity, and with `speed` (0, 1] of it acceleration and jerk along the path.

        In m/s, m/s² and m/s³: with these the acceleration and jerk of the position, in space, keep `limits`.
        """
        del speed
        return limits.velocity, limits.acceleration, limits.jerk

    @property
    def angle(self) -> float:
        """Angle that the orientation turns, in rad."""
        return float(np.linalg.norm(self.rotation))

    def travelled(self, u: float) -> tuple[float, float]:
        """Return how much of length (m) and angle (rad) is done at the fraction `u`."""
        return u * self.length, u * self.angle

    def pose(self, u: float) -> Array:
        """Return base_t_tcp (4, 4) at the fraction `u`."""
        pose = self.base_t_start.copy()
        pose[:3, 3] = self.position(u)
        pose[:3, :3] = rotation_matrix(u * self.rotation) @ pose[:3, :3]
        return pose


def turn_between(base_t_start: Array, base_t_goal: Array) -> Array:
    """Return the rotation vector (3,) in rad, base frame, that turns one pose (4, 4) to another the shorter way."""
    rotation = rotation_vector(base_t_goal[:3, :3] @ base_t_start[:3, :3].T)
    return np.zeros(3) if np.linalg.norm(rotation) < SMALLEST_ANGLE else rotation
