"""Ways of crafts to a goal: lines and arcs, no narrower than their component turns, as few and as short as can be."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.crafts.craft import CraftAtWork
from virtualrobot_kernel.crafts.words import TURNS, Word, best_of_all, shortest
from virtualrobot_kernel.errors import KernelError, Reason

Floats = NDArray[np.float64]

NARROWEST, WIDEST = 1e-3, 1e5
"""Radii (m) between which a component is asked for its least one; one that needs more goes straight ahead only."""

HALVINGS = 60
"""Halvings of the range in which the least radius is."""

MARGIN = 1e-9
"""Part by which arcs are wider than the component says it just can."""

LEVEL = 1e-9
"""Largest difference from 1 of the z axis's height of a base that stands level."""


class Goal(NamedTuple):
    """Place of a craft's base in the frame of its joint: x, y (m), and the heading (rad; None: as it comes).

    `back`: it may go back on its way. `radius` (m): the arcs are no narrower; 0: as narrow as it can turn.
    """

    x: float
    y: float
    heading: float | None
    back: bool = False
    radius: float = 0.0


class Way(NamedTuple):
    """Parts (n, 3) of a way: forward and to the left (m), and turn (rad); its word, and the radius of its arcs (m)."""

    parts: Floats
    word: str
    radius: float

    @property
    def length(self) -> float:
        """Return its length (m)."""
        return float(np.hypot(self.parts[:, 0], self.parts[:, 1]).sum())


def least_radius(craft: CraftAtWork, q: Floats, *, back: bool) -> float:
    """Return the radius (m) of the narrowest circle on which a craft goes to both sides; 0: it turns on the spot.

    It is what its component makes commands for; inf where that is no circle at all. `back`: it has to go back, too.
    """
    if craft.can(np.array([0.0, 0.0, 1.0]), q) and craft.can(np.array([0.0, 0.0, -1.0]), q):
        return 0.0

    def goes(curvature: float) -> bool:
        ways = (1.0, -1.0) if back else (1.0,)
        return all(craft.can(np.array([way, 0.0, side * curvature]), q) for way in ways for side in (1.0, -1.0))

    low, high = 1.0 / WIDEST, 1.0 / NARROWEST
    if not goes(low):
        return math.inf
    for _ in range(HALVINGS):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if goes(middle) else (low, middle)
    return 1.0 / low


def way_to(craft: CraftAtWork, q: Floats, goal: Goal) -> Way:
    """Return the shortest way of a craft from coordinates q (nq,) to a goal.

    What turns on the spot turns, goes straight, and turns again, unless the goal names a radius; else the way is a word
    of Dubins, or where it may go back of Reeds and Shepp. Raises KernelError, in words, for a base that is tilted, and
    for a radius that is narrower than the craft turns.
    """
    name = craft.node.name
    begin = craft.pose(q)
    if begin[2, 2] < 1.0 - LEVEL:
        tilt = math.acos(max(-1.0, min(1.0, float(begin[2, 2]))))
        raise KernelError(
            f"{name!r} is tilted by {tilt:.3g} rad; a way in the plane begins with the base level",
            reason=Reason.WRONG_STATE,
            robot=name,
        )
    least = least_radius(craft, q, back=goal.back)
    if math.isinf(least):
        raise KernelError(f"{name!r} goes on no circle, so no way leads it to a goal aside; give its parts", robot=name)
    if goal.radius and goal.radius < least:
        raise KernelError(
            f"{name!r} turns on circles of {least:.4g} m or more, not of {goal.radius:.4g} m",
            robot=name,
            radius=goal.radius,
            least=least,
        )
    center = begin @ craft.base_t_center
    if not least and not goal.radius:
        return _on_the_spot(craft, center, begin, goal)
    radius = max(least * (1.0 + MARGIN), goal.radius)

    def seen(heading: float) -> tuple[float, float, float]:
        x, y, turn = _seen_from(center, _centre_at(craft, goal.x, goal.y, heading))
        return x / radius, y / radius, turn

    if goal.heading is None:
        word = best_of_all(seen, back=goal.back)
    else:
        word = shortest(*seen(goal.heading), back=goal.back)
    return Way(_parts(word, radius), word.name, radius)


def _on_the_spot(craft: CraftAtWork, center: Floats, begin: Floats, goal: Goal) -> Way:
    """Return a turn, a straight line and a turn; back, where that is less to turn and the goal allows it."""
    heading = goal.heading
    if heading is None:
        # Its middle goes straight to the place, or as near to it as it stands from it.
        beside = craft.base_t_center[:2, 3]
        across, up = (goal.x - center[0, 3], goal.y - center[1, 3])
        if math.hypot(*beside) > LEVEL:
            heading = math.atan2(-up, -across) - math.atan2(beside[1], beside[0])
        elif math.hypot(across, up) > LEVEL:
            heading = math.atan2(up, across) - craft.craft.heading
        else:
            heading = math.atan2(begin[1, 0], begin[0, 0])
    x, y, turn = _seen_from(center, _centre_at(craft, goal.x, goal.y, heading))
    far = math.hypot(x, y)
    ways: list[tuple[float, float, float]] = []
    for forward in (1.0, -1.0) if goal.back else (1.0,):
        first = math.atan2(forward * y, forward * x) if far > LEVEL else 0.0
        if far <= LEVEL:
            far = 0.0
        ways.append((first, forward * far, math.remainder(turn - first, math.tau)))
    first, straight, last = min(ways, key=lambda way: abs(way[0]) + abs(way[2]))
    parts = [(0.0, 0.0, first), (straight, 0.0, 0.0), (0.0, 0.0, last)]
    kept = [part for part in parts if any(abs(value) > LEVEL for value in part)]
    return Way(np.array(kept).reshape(-1, 3), "", 0.0)


def _centre_at(craft: CraftAtWork, x: float, y: float, heading: float) -> Floats:
    """Return where the component has its base (4, 4) when the robot's base is there."""
    cosine, sine = math.cos(heading), math.sin(heading)
    pose = np.eye(4)
    pose[:2, :2] = [[cosine, -sine], [sine, cosine]]
    pose[:2, 3] = x, y
    return pose @ craft.base_t_center


def _seen_from(center: Floats, there: Floats) -> tuple[float, float, float]:
    """Return a pose as x, y and turn from another one, both level."""
    across, up = (there[:2, 3] - center[:2, 3]).tolist()
    cosine, sine = center[0, 0], center[1, 0]
    turn = math.atan2(there[1, 0], there[0, 0]) - math.atan2(sine, cosine)
    return float(cosine * across + sine * up), float(cosine * up - sine * across), math.remainder(turn, math.tau)


def _parts(word: Word, radius: float) -> Floats:
    rows = [
        (radius * length, 0.0, TURNS[letter] * length)
        for letter, length in zip(word.letters, word.lengths, strict=True)
    ]
    return np.array(rows).reshape(-1, 3)
