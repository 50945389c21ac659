"""Footholds: where on the ground each foot is set down, and when."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_apps.vehicles.walking.course import placed
from virtualrobot_apps.vehicles.walking.feet import swing_height
from virtualrobot_apps.vehicles.walking.gaits import Gait

Floats = NDArray[np.float64]
Ground = Callable[[Floats], tuple[Floats, Floats]]
"""Heights (m,) in m and unit normals (m, 3) of the ground below places (m, 2) in the world."""

LOOKED_AT = 9
"""Places between two footholds at which a foot's way over the ground is looked at."""


@dataclass(frozen=True, slots=True)
class Stand:
    """Machine that stands: where its feet are below its body, and how it steps.

    feet: (l, 2) x and y (m) of each foot in the frame of the body. height: of the body's frame above the ground (m).
    foot_radius: of the ball that a foot is (m); 0 where it is a point. clearance: height of a step (m). search: how
    far from its place a foot may be set down where the ground is flatter (m). sway: how far the body leans away from
    feet in the air (m). center: x and y of the centre of mass in the frame of the body (m), kept above the middle.
    """

    feet: Floats
    height: float
    foot_radius: float = 0.0
    clearance: float = 0.03
    search: float = 0.0
    sway: float = 0.0
    center: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """Swing of a foot: `begin` and `end` (s), place of its middle (3,) at both, and height (m) that it is lifted by."""

    begin: float
    end: float
    start: Floats
    goal: Floats
    height: float


def flat(height: float = 0.0) -> Ground:
    """Return level ground at a height (m)."""

    def ground(places: Floats) -> tuple[Floats, Floats]:
        return np.full(len(places), height), np.tile([0.0, 0.0, 1.0], (len(places), 1))

    return ground


def slope(angle: float) -> Ground:
    """Return a plane through the origin that rises along x by `angle` (rad)."""

    def ground(places: Floats) -> tuple[Floats, Floats]:
        normal = np.array([-np.sin(angle), 0.0, np.cos(angle)])
        return np.tan(angle) * places[:, 0], np.tile(normal, (len(places), 1))

    return ground


def footholds(
    gait: Gait, stand: Stand, times: Floats, poses: Floats, ground: Ground, until: float
) -> tuple[Floats, list[list[Step]]]:
    """Return where feet stand at first (l, 3), and the steps of each leg.

    A foot is set down where it will be at its place below the body in the middle of its time on the ground; `poses`
    (n, 3) of the body at `times` (n,) say where that is.
    """
    swings = [gait.swings(leg, until) for leg in range(len(stand.feet))]
    owners = [leg for leg, of in enumerate(swings) for _ in of]
    middles = np.array([end + gait.duty_factor * gait.cycle / 2.0 for of in swings for _, end in of])
    bodies = np.stack([np.interp(middles, times, poses[:, axis]) for axis in range(3)], axis=-1).reshape(-1, 3)
    begin = placed(np.tile(poses[0], (len(stand.feet), 1)), stand.feet)
    wanted = np.vstack([begin, placed(bodies, stand.feet[owners])])
    places = _best(wanted, stand, ground)
    first, rest = places[: len(begin)], places[len(begin) :]
    ends: list[Floats] = []
    starts: list[Floats] = []
    for leg, of in enumerate(swings):
        goals = rest[[number for number, owner in enumerate(owners) if owner == leg]].reshape(-1, 3)
        starts += [first[leg], *goals[:-1]][: len(of)]
        ends += list(goals)
    heights = _heights(np.array(starts).reshape(-1, 3), np.array(ends).reshape(-1, 3), stand, ground)
    steps: list[list[Step]] = [[] for _ in swings]
    each = [span for of in swings for span in of]
    for leg, (lifted, down), start, goal, height in zip(owners, each, starts, ends, heights, strict=True):
        steps[leg].append(Step(lifted, down, start, goal, height))
    return first, steps


def _best(wanted: Floats, stand: Stand, ground: Ground) -> Floats:
    """Return places (m, 3) of feet on the ground at places (m, 2), or near them where it is flatter."""
    if stand.search > 0.0:
        offsets = np.linspace(-stand.search, stand.search, 5)
        grid = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
        candidates = wanted[:, None] + grid
        around = max(stand.foot_radius, 0.005) * np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (0, 0)])
        heights = ground((candidates[:, :, None] + around).reshape(-1, 2))[0].reshape(*candidates.shape[:2], -1)
        # What is not flat is as bad as what is far: a slope of 1 for a foot's ball costs a search length.
        rough = np.ptp(heights, axis=2) / (2.0 * np.abs(around).max()) * stand.search
        far = np.linalg.norm(grid, axis=1)
        cost = np.where(np.isfinite(rough), rough, np.inf) + 0.3 * far
        wanted = candidates[np.arange(len(wanted)), cost.argmin(axis=1)]
    heights, normals = ground(wanted)
    if not np.isfinite(heights).all():
        missing = wanted[~np.isfinite(heights)][0]
        raise ValueError(f"there is no ground for a foot at x {missing[0]:.2f} m, y {missing[1]:.2f} m")
    # A ball touches a plane when its middle is a radius off, along the normal.
    return np.column_stack([wanted, heights + stand.foot_radius / normals[:, 2]])


def _heights(starts: Floats, ends: Floats, stand: Stand, ground: Ground) -> list[float]:
    part = np.linspace(0.0, 1.0, LOOKED_AT)
    between = starts[:, None, :2] + (ends - starts)[:, None, :2] * part[:, None]
    heights = ground(between.reshape(-1, 2))[0].reshape(-1, LOOKED_AT) + stand.foot_radius
    return [
        swing_height(start[2], end[2], stand.clearance, np.where(np.isfinite(below), below, -np.inf))
        for start, end, below in zip(starts, ends, heights, strict=True)
    ]
