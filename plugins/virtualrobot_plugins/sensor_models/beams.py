"""Rays of a beam: evenly spread over a laser's spot or a sonar's cone, the axis first."""

from __future__ import annotations

import math

import numpy as np
from virtualrobot_sdk.kinematics import Floats

AXIS = np.array([[1.0, 0.0, 0.0]])
"""(1, 3) the axis of a beam."""
_GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))


def spot(rays: int, width: float, height: float) -> Floats:
    """Return unit directions (rays, 3) spread evenly over a small elliptical spot, the first on its axis.

    `width` and `height` (rad) are its full angles along y and z. Ray i stands for the i-th of as many parts of equal
    area (H. Vogel, A better way to construct the sunflower head, Mathematical Biosciences 44, 1979).
    """
    part, around = _sunflower(rays)
    across = np.sqrt(part)
    y = np.tan(0.5 * width * across) * np.cos(around)
    z = np.tan(0.5 * height * across) * np.sin(around)
    directions = np.stack([np.ones(rays), y, z], axis=1)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def cone(rays: int, half_angle: float) -> Floats:
    """Return unit directions (rays, 3) that share the solid angle of a cone evenly, the first on its axis.

    `half_angle` (rad) is that between axis and surface; the rays follow Vogel's spiral as in `spot`.
    """
    part, around = _sunflower(rays)
    x = 1.0 - (1.0 - math.cos(half_angle)) * part
    across = np.sqrt(np.maximum(1.0 - x * x, 0.0))
    return np.stack([x, across * np.cos(around), across * np.sin(around)], axis=1)


def _sunflower(rays: int) -> tuple[Floats, Floats]:
    """Return for each ray which part of the area lies inside it, (rays,), 0 for the first, and its angle around."""
    number = np.arange(rays, dtype=np.float64)
    part = (number + 0.5) / rays
    part[0] = 0.0
    return part, number * _GOLDEN_ANGLE
