"""Motions in the plane of the base, and the checks of arguments that all crafts make."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.arrays import is_finite
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats

RIGIDITY = 1e-6
"""Largest error of a base's pose from a rigid transform."""

NEGLIGIBLE = 1e-9
"""Parts of a twist (m/s, rad/s) that count as none."""

Length = Annotated[float, Meta(gt=0, le=100)]
"""Settings that are a length in meters."""


def shifted(pose: Floats, x: float, y: float, turn: float) -> Floats:
    """Return a pose (4, 4) after a shift in its own plane (m) and then a turn to the left (rad)."""
    cosine, sine = math.cos(turn), math.sin(turn)
    return pose @ np.array([[cosine, -sine, 0, x], [sine, cosine, 0, y], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def arc(pose: Floats, x: float, y: float, turn: float) -> Floats:
    """Return a pose (4, 4) after an arc: a constant twist whose parts add up to x, y (m) and `turn` (rad)."""
    half = turn / 2.0
    chord = math.sin(half) / half if half else 1.0
    cosine, sine = chord * math.cos(half), chord * math.sin(half)
    return shifted(pose, cosine * x - sine * y, sine * x + cosine * y, turn)


def check_pose(pose: Floats) -> Floats:
    """Return a pose; raise ArgumentError for what is no rigid one."""
    if not isinstance(pose, np.ndarray) or pose.shape != (4, 4):
        raise ArgumentError(f"the base's pose must be an array (4, 4), not {np.shape(pose)}")
    # In plain numbers: NumPy takes ten times as long for so few.
    (a, b, c, x), (d, e, f, y), (g, h, i, z), last = pose.tolist()
    off = (a * a + d * d + g * g - 1.0, b * b + e * e + h * h - 1.0, a * b + d * e + g * h)
    off += (c - (d * h - e * g), f - (g * b - h * a), i - (a * e - b * d))
    if not (max(map(abs, off)) <= RIGIDITY and math.isfinite(sum(off) + x + y + z) and last == [0.0, 0.0, 0.0, 1.0]):
        raise ArgumentError(f"the base's pose is no rigid transform: {pose.tolist()}")
    return pose


def check_values(what: str, values: Floats, names: tuple[str, ...]) -> Floats:
    """Return values, one for each name; raise ArgumentError for another count and for what is not finite."""
    if np.shape(values) != (len(names),):
        raise ArgumentError(f"{what} must be {len(names)} numbers ({', '.join(names)}), not {np.shape(values)}")
    if not is_finite(values):
        raise ArgumentError(f"{what} are {values.tolist()}; they must be finite")
    return values


def check_seconds(seconds: float) -> None:
    """Raise ArgumentError for a time that is not above 0."""
    if not 0.0 < seconds < math.inf:
        raise ArgumentError(f"the time of a step is {seconds} s; it must be a finite number above 0", seconds=seconds)


def check_twist(twist: Floats, sideways: bool) -> tuple[float, float, float]:
    """Return vx, vy and omega; raise ArgumentError for what is none, and to the side where that cannot be."""
    vx, vy, omega = check_values("a twist", twist, ("vx", "vy", "omega")).tolist()
    if not sideways and abs(vy) > NEGLIGIBLE:
        raise ArgumentError(f"it cannot move to the side, at {vy:g} m/s; its wheels roll forward only", vy=vy)
    return vx, vy, omega
