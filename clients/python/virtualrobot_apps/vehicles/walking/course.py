"""Courses: where the body of a walking machine is over time, seen from above, as it is told to go."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from virtualrobot_apps.vehicles.walking.feet import blend

Floats = NDArray[np.float64]
SUBSTEPS = 4


@dataclass(frozen=True, slots=True)
class Part:
    """Part of a course: for so many seconds at a speed forward and to the left (m/s), turning to the left (rad/s)."""

    seconds: float
    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        """Raise ValueError for numbers that make no course."""
        if not 0.0 < self.seconds < math.inf:
            raise ValueError(f"a part of a course lasts longer than 0 s, not {self.seconds:g}")
        if not all(map(math.isfinite, (self.forward, self.left, self.turn))):
            raise ValueError(f"speeds are finite, not {self.forward:g}, {self.left:g} and {self.turn:g}")

    @property
    def twist(self) -> tuple[float, float, float]:
        """Speed forward, to the left (m/s) and turning rate (rad/s)."""
        return self.forward, self.left, self.turn


def duration(parts: Sequence[Part], ramp: float) -> float:
    """Return how long a course takes (s): its parts, and the time to stop."""
    return sum(part.seconds for part in parts) + ramp


def twists(times: Floats, parts: Sequence[Part], ramp: float) -> Floats:
    """Return speeds forward and to the left and turning rates (n, 3) at times (n,) from the start of a course.

    From one part to the next, from rest to the first and from the last to rest they change smoothly within `ramp` (s).
    What is lost at the start is made up for at the end, so that a straight part of v for T ends v T farther.
    """
    told = np.zeros((len(times), 3))
    begin, before = 0.0, np.zeros(3)
    for seconds, twist in [*((part.seconds, part.twist) for part in parts), (0.0, (0.0, 0.0, 0.0))]:
        told += (np.array(twist) - before) * blend((times - begin) / ramp)[:, None]
        begin, before = begin + seconds, np.array(twist)
    return told


def course(
    times: Floats, parts: Sequence[Part], ramp: float, start: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> Floats:
    """Return x, y (m) and heading (rad) (n, 3) of the body at times (n,), which rise from 0, along exact arcs."""
    poses = np.empty((len(times), 3))
    poses[0] = x, y, heading = start
    fine = np.concatenate([np.linspace(a, b, SUBSTEPS, endpoint=False) for a, b in pairwise(times)])
    steps = np.diff(np.append(fine, times[-1]))
    told = twists(fine + steps / 2.0, parts, ramp)
    for number, ((forward, left, turn), step) in enumerate(zip(told.tolist(), steps.tolist(), strict=True), 1):
        half = turn * step / 2.0
        chord = step * float(np.sinc(half / np.pi))
        cos, sin = math.cos(heading + half), math.sin(heading + half)
        x += chord * (forward * cos - left * sin)
        y += chord * (forward * sin + left * cos)
        heading += 2.0 * half
        if number % SUBSTEPS == 0:
            poses[number // SUBSTEPS] = x, y, heading
    return poses


def placed(poses: Floats, places: Floats) -> Floats:
    """Return where places (..., 2) in the frame of the body are, for poses (..., 3) of it, seen from above."""
    cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = places[..., 0], places[..., 1]
    return np.stack([poses[..., 0] + cos * x - sin * y, poses[..., 1] + sin * x + cos * y], axis=-1)
