"""Following a way: of arcs that the vehicle can drive now the one that keeps to it best and touches nothing.

D. Fox, W. Burgard, S. Thrun, The Dynamic Window Approach to Collision Avoidance, IEEE Robotics & Automation Magazine
4, 1997; what it scores is how far an arc leads from the places where the vehicle should be at the same times.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.poses import Floats, arc, between, moved, wrapped
from virtualrobot_apps.seeing.navigation.regions import apart

HORIZON, STEPS = 1.6, 8
"""Time (s) that an arc is looked at for, and number of its places."""
SPEEDS, TURNS = 6, 25
"""Number of speeds and of turning rates that are tried."""
MARGIN = 0.03
"""Least distance (m) of the footprint from obstacles along an arc."""
NEAR = 0.35
"""Distance (m) from obstacles from which on it slows down."""
RANGE, CELL = 3.0, 0.05
"""Half the edge of the area (m) in which obstacles count, and the edge of its cells."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a vehicle: speed (m/s), turning rate (rad/s) and their rates of change (m/s2, rad/s2)."""

    speed: float = 0.5
    turn: float = 1.0
    acceleration: float = 0.8
    turn_acceleration: float = 2.5


class Surroundings:
    """Distances to obstacles about a vehicle, in its own frame."""

    def __init__(self, obstacles: Floats) -> None:
        """Take points (n, 2) about the base (m)."""
        count = round(2.0 * RANGE / CELL)
        free = np.ones((count, count), bool)
        keys = np.floor((obstacles + RANGE) / CELL).astype(int) if len(obstacles) else np.zeros((0, 2), int)
        keys = keys[((keys >= 0) & (keys < count)).all(axis=1)]
        free[keys[:, 1], keys[:, 0]] = False
        # From the middle of a cell to the edge of the next obstacle's.
        field = np.minimum(apart(~free) * CELL, 2.0 * RANGE)
        self._field = np.maximum(field - 0.5 * CELL, 0.0)

    def clearance(self, points: Floats) -> Floats:
        """Return how far points (..., 2) are from obstacles (m); beyond the area as at its edge."""
        keys = np.clip(np.floor((points + RANGE) / CELL).astype(int), 0, len(self._field) - 1)
        return self._field[keys[..., 1], keys[..., 0]]

    @property
    def turned(self) -> Surroundings:
        """The same ones for a base that looks backwards."""
        other = Surroundings.__new__(Surroundings)
        other._field = self._field[::-1, ::-1]
        return other


@dataclass(frozen=True, slots=True)
class Choice:
    """Twist to drive now, v (m/s) and omega (rad/s), and how near it comes to obstacles (m)."""

    twist: tuple[float, float]
    clearance: float


def choose(
    pose: Floats,
    twist: tuple[float, float],
    way: Floats,
    surroundings: Surroundings,
    footprint: Footprint,
    limits: Limits,
) -> Choice | None:
    """Return how to drive along a way (n, 2) from a pose (3,), at a twist now; None where no arc is free.

    `way` is in the frame of `pose`'s map, from about the vehicle on to its end.
    """
    window = 0.4
    v_now, w_now = twist
    v = np.linspace(
        max(0.0, v_now - limits.acceleration * window), min(limits.speed, v_now + limits.acceleration * window), SPEEDS
    )
    reach = limits.turn_acceleration * window
    w = np.linspace(max(-limits.turn, w_now - reach), min(limits.turn, w_now + reach), TURNS)
    pairs = np.stack(np.meshgrid(np.unique(np.append(v, 0.0)), np.unique(np.append(w, 0.0)), indexing="ij"), axis=-1)
    pairs = pairs.reshape(-1, 2)
    times = np.linspace(HORIZON / STEPS, HORIZON, STEPS)
    places = arc(pairs[:, None, :], times[None, :])  # (pairs, steps, 3) in the frame of the base
    outline = footprint.outline()
    cells = surroundings.clearance(moved(places, outline[None, None]))
    nearest = cells.min(axis=2)  # (pairs, steps)
    here = float(surroundings.clearance(outline).min())
    # What stands nearer already may stay as near: else nothing could ever leave it.
    least = min(MARGIN, 0.5 * here)
    free = (nearest > least).all(axis=1)
    if not free.any():
        return None
    pairs, places, nearest = pairs[free], places[free], nearest[free]
    rest = moved(between(pose, np.zeros(3)), way)
    at = int(np.argmin(np.hypot(*rest.T)))
    rest = rest[at:]
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(rest, axis=0).T))])
    slow = np.clip((here - MARGIN) / (NEAR - MARGIN), 0.25, 1.0)
    wanted = limits.speed * slow
    ahead = rest[min(int(np.searchsorted(along, 0.3)), len(rest) - 1)]
    bearing = np.arctan2(ahead[1], ahead[0])
    if abs(bearing) > 0.9:  # it turns first
        wanted *= 0.1
    marks = np.minimum(wanted * times, along[-1])
    refs = np.column_stack([np.interp(marks, along, rest[:, column]) for column in (0, 1)])
    # In units of the speed that is wanted: what lags behind counts as much where it goes slowly, between obstacles.
    off = np.hypot(places[..., 0] - refs[:, 0], places[..., 1] - refs[:, 1]).mean(axis=1) / slow
    end = places[:, -1]
    # Each arc is judged by the way ahead of its own end: one that stands would look round the next corner for ever.
    passed = along[np.argmin(np.hypot(end[:, None, 0] - rest[:, 0], end[:, None, 1] - rest[:, 1]), axis=1)]
    marks = np.minimum(passed + 0.4, along[-1])
    targets = np.column_stack([np.interp(marks, along, rest[:, column]) for column in (0, 1)])
    to = targets - end[:, :2]
    heading = np.abs(wrapped(np.arctan2(to[:, 1], to[:, 0]) - end[:, 2]))
    heading = np.where(np.hypot(*to.T) < 0.05, 0.0, heading)
    shy = 0.02 / (nearest.min(axis=1) + 0.05)
    score = off + 0.12 * heading + shy + 0.01 * np.abs(pairs[:, 1] - w_now)
    best = int(np.argmin(score))
    return Choice((float(pairs[best, 0]), float(pairs[best, 1])), float(nearest[best].min()))


def turning(
    angle: float, twist: tuple[float, float], surroundings: Surroundings, footprint: Footprint, limits: Limits
) -> Choice | None:
    """Return how to turn on the spot by an angle (rad); None where the footprint would touch something."""
    rate = float(np.clip(2.0 * angle, -limits.turn, limits.turn))
    nearest = _nearest_turning(np.linspace(0.0, np.clip(angle, -0.5, 0.5), 6), surroundings, footprint)
    return None if nearest is None else Choice((0.0, rate), nearest)


def backwards(
    pose: Floats,
    twist: tuple[float, float],
    way: Floats,
    surroundings: Surroundings,
    footprint: Footprint,
    limits: Limits,
) -> Choice | None:
    """Return how to drive backwards along a way (n, 2), as `choose` does ahead: for a base that looks the other way."""
    back = np.array([pose[0], pose[1], wrapped(pose[2] + np.pi)])
    choice = choose(back, (-twist[0], twist[1]), way, surroundings.turned, footprint.turned, limits)
    return None if choice is None else Choice((-choice.twist[0], choice.twist[1]), choice.clearance)


def can_turn(angle: float, surroundings: Surroundings, footprint: Footprint) -> bool:
    """Return whether the footprint touches nothing while it turns on the spot by an angle (rad), this way or that."""
    ends = (angle, angle - np.copysign(2.0 * np.pi, angle))
    turns = (np.linspace(0.0, end, 2 + int(abs(end) / 0.1)) for end in ends)
    return any(_nearest_turning(one, surroundings, footprint) is not None for one in turns)


def _nearest_turning(angles: Floats, surroundings: Surroundings, footprint: Footprint) -> float | None:
    """Return how near (m) the footprint comes to obstacles at angles (n,), from 0 on; None where it would touch one."""
    places = np.column_stack([np.zeros((len(angles), 2)), angles])
    cells = surroundings.clearance(moved(places, footprint.outline()[None])).min(axis=1)
    return None if cells.min() <= min(MARGIN, 0.5 * cells[0]) else float(cells.min())


def ahead_of(pose: Floats, way: Floats, meters: float) -> Floats:
    """Return the stretch of a way (n, 2) from the point nearest to a pose on, so long (m)."""
    apart = np.hypot(way[:, 0] - pose[0], way[:, 1] - pose[1])
    start = int(np.argmin(apart))
    along = np.cumsum(np.hypot(*np.diff(way[start:], axis=0).T))
    return way[start : start + 2 + int(np.searchsorted(along, meters))]
