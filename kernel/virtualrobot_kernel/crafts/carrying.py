"""Bases of crafts along a way of their drives that is known ahead: where they will be, and how far they go at the most.

The way is cut until a component's step over a piece comes where its two steps over the halves come; lines and arcs are
not cut for that, only so that a way forth and back is seen.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.crafts.craft import CraftAtWork
from virtualrobot_kernel.errors import KernelError

Floats = NDArray[np.float64]

At = Callable[[float], Floats]
"""Coordinates (nq,) at a time."""

Travel = Callable[[float, float], Floats]
"""Distances that coordinates (nq,) go at the most between two times."""

LONGEST = 0.25
"""Time (s) of the longest piece of a way that is looked at as a whole."""

PIECES = 20_000
"""Number of pieces of a long way at the least, so that long ones are not longer than needed."""

SAME = 1e-6
"""Error (m, rad) of a base at a piece's end that is none."""

EXACT = 1e-7
"""Errors (m, rad) of a way that are none."""

DEEPEST = 12
"""Number of times that a piece is halved at the most."""


class CarriedBase:
    """Base of a craft on a way of its drives; any thread may ask.

    `places`: of its coordinates in q. `wobble` (m, rad): how far it may be from where it is told at the most.
    """

    def __init__(
        self,
        craft: CraftAtWork,
        at: At,
        travel: Travel,
        times: Sequence[float],
        given_up: Callable[[], bool] = lambda: False,
    ) -> None:
        """Follow the craft from where it is at the first of rising times, between which its drives stand in parts.

        Raises KernelError with what the component does wrong, and when nobody waits for it any more.
        """
        self._craft, self._at, self._travel, self._given_up = craft, at, travel, given_up
        self.wobble = 0.0
        first = at(times[0])
        self.places = np.array(craft.base_coordinates)
        self._times: list[float] = [times[0]]
        self._states: list[Floats] = [craft.states(first)]
        self._poses: list[Floats] = [craft.pose(first) @ craft.base_t_center]
        self._coordinates: list[Floats] = [first[self.places]]
        self._seconds = max(LONGEST, (times[-1] - times[0]) / PIECES)
        for begin, end in pairwise(times):
            if end > begin:
                self._follow(end)
        self._gains = self._found_gains()

    def coordinates(self, time: float) -> Floats:
        """Return the coordinates of the base at a time."""
        row = self._row(time)
        states = self._craft.states(self._at(time))
        if row == len(self._times) - 1 or not (states != self._states[row]).any():
            return self._coordinates[row]
        pose = self._stepped(self._poses[row], self._states[row], states, max(time - self._times[row], 1e-9))
        return self._placed(self._coordinates[row], self._poses[row], pose)

    def most(self, first: float, last: float) -> Floats:
        """Return how far the coordinates of the base go at the most between two times."""
        drives = self._craft.drives
        way = self._travel(first, last)[drives.q] / np.abs(drives.ratio)
        if not way.any():
            return np.zeros(len(self.places))
        shift, turn = (self._gains[self._row(first) : self._row(last) + 1].max(axis=0) @ way).tolist()
        return np.array([shift, shift, turn] if self._craft.is_planar else [*[shift] * 3, *[turn / 2.0] * 4])

    def rates(self, q: Floats, rates: Floats) -> Floats:
        """Return the rates of its coordinates at coordinates q (nq,) whose drives have `rates` (nq,)."""
        craft = self._craft
        twist = craft.twist(craft.states(q), rates[craft.drives.q] / craft.drives.ratio)
        found = craft.rates(craft.pose(q) @ craft.base_t_center, twist)
        return np.array([*found, *[0.0] * (len(self.places) - len(found))])

    def _row(self, time: float) -> int:
        return min(max(bisect_right(self._times, time) - 1, 0), len(self._times) - 1)

    def _follow(self, until: float) -> None:
        """Go on to a time in pieces."""
        count = max(1, int(np.ceil((until - self._times[-1]) / self._seconds)))
        for end in np.linspace(self._times[-1], until, count + 1)[1:].tolist():
            if self._given_up():
                raise KernelError("nobody waits for this any more")
            self._piece(end, DEEPEST)

    def _piece(self, end: float, depth: int) -> None:
        begin, states, pose = self._times[-1], self._states[-1], self._poses[-1]
        middle = (begin + end) / 2.0
        half, whole = (self._craft.states(self._at(time)) for time in (middle, end))
        if not (half != states).any() and not (whole != states).any():
            self._keep(end, whole, pose)
            return
        seconds = end - begin
        once = self._stepped(pose, states, whole, seconds)
        inside = self._stepped(pose, states, half, seconds / 2.0)
        twice = self._stepped(inside, half, whole, seconds / 2.0)
        off = float(np.abs(once - twice).max())
        if off > SAME and depth:
            self._piece(middle, depth - 1)
            self._piece(end, depth - 1)
            return
        self.wobble += off
        self._keep(middle, half, inside)
        self._keep(end, whole, twice)

    def _keep(self, time: float, states: Floats, pose: Floats) -> None:
        self._coordinates.append(self._placed(self._coordinates[-1], self._poses[-1], pose))
        self._times.append(time)
        self._states.append(states)
        self._poses.append(pose)

    def _placed(self, before: Floats, begin: Floats, end: Floats) -> Floats:
        """Return the coordinates of the base when the component's is at `end`, having turned there from `begin`."""
        return np.array(self._craft.coordinates(before, end @ self._craft.center_t_base, begin, end))

    def _stepped(self, pose: Floats, states: Floats, after: Floats, seconds: float) -> Floats:
        return self._craft.stepped(pose, states, (after - states) / seconds, seconds)[0]

    def _found_gains(self) -> Floats:
        """Return how far the base goes (m) and turns (rad) at the most by each drive, from each time on: (k, 2, m)."""
        craft = self._craft
        arm = float(np.linalg.norm(craft.center_t_base[:2, 3]))
        known: dict[bytes, Floats] = {}
        gains = []
        for states in self._states:
            if (key := states.tobytes()) not in known:
                twists = np.array([craft.twist(states, command) for command in np.eye(len(states))])
                turn = np.abs(twists[:, 2])
                known[key] = np.array([np.hypot(twists[:, 0], twists[:, 1]) + turn * arm, turn])
            gains.append(known[key])
        ends = np.array(gains)
        # A steering angle between two of them turns it no faster than at the greater one.
        return np.maximum(ends, np.concatenate([ends[1:], ends[-1:]]))


class CarriedBases:
    """All coordinates of a world on a known way of joints, with the bases of crafts where their drives take them.

    `wobble` (nq,): how far they may be from where they are told; None: as good as not at all.
    """

    def __init__(self, at: At, travel: Travel, bases: Sequence[CarriedBase], count: int) -> None:
        """Take a way on which bases stand, and those that move; `count` is that of all coordinates."""
        self._at, self._travel, self._bases = at, travel, bases
        self.places = np.concatenate([base.places for base in bases])
        wobble = np.zeros(count)
        for base in bases:
            wobble[base.places] = base.wobble
        self.wobble = wobble if (wobble > EXACT).any() else None

    def at(self, time: float) -> Floats:
        """Return all coordinates (nq,) at a time."""
        found = self._at(time).copy()
        for base in self._bases:
            found[base.places] = base.coordinates(time)
        return found

    def travel(self, first: float, last: float) -> Floats:
        """Return how far coordinates (nq,) go at the most between two times."""
        found = self._travel(first, last).copy()
        for base in self._bases:
            found[base.places] = base.most(first, last)
        return found

    def rates(self, q: Floats, rates: Floats) -> Floats:
        """Return the rates of the coordinates `places`, at coordinates q (nq,) whose drives have `rates` (nq,).

        Those of a quaternion's x, y, z are the angular velocity (rad/s).
        """
        return np.concatenate([base.rates(q, rates) for base in self._bases])
