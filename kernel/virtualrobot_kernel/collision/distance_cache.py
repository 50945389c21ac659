"""Cache of measured distances, kept with how the two elements stood to each other: bounds for all places near."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.nearest import Floats
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.numeric.distance_bounds import cached_distance_bounds

Integers = NDArray[np.int64]

KEPT = 32
"""Number of distances of a pair that are kept; the oldest makes room."""

MOST = 2048
"""Of how many pairs some are kept; when there are more, all are forgotten before the next way."""


LEAST = 1e-4
"""Distances below this (m) are not kept: they would hold for hardly any other place."""


class DistanceCache:
    """The last measured distances of pairs of elements. Used by one thread.

    Measuring takes FCL up to milliseconds. What was measured holds for other places too, less how far the elements
    have moved against each other since: so a robot that goes along slowly is seldom measured again.
    """

    def __init__(self, placed: Placed) -> None:
        """Keep nothing yet of the elements of `placed`; where these are is told with each call."""
        self._core = placed.core
        self._slots: dict[tuple[int, int], int] = {}
        self._forget(16)

    @property
    def kept(self) -> tuple[Floats, Floats]:
        """Return where the second was seen from the first, (s, KEPT, 3, 4), and distances (s, KEPT); -1: none."""
        return self._first_t_second, self._distances

    def slots(self, pairs: Integers) -> Integers:
        """Return where what is known of pairs (k, 2) is kept, (k,), until `slots` is called again; -1 for nothing."""
        if len(self._slots) > MOST:
            self._forget(16)
        if not self._slots:
            return np.full(len(pairs), -1)
        return np.array([self._slots.get((one, other), -1) for one, other in pairs.tolist()], np.int64)

    def bound(self, one: int, other: int, slot: int, world_t_element: Floats) -> float:
        """Return a lower bound of the distance of two elements that are at poses (e, 4, 4)."""
        found = np.zeros(1)
        pair = np.array([[one, other]])
        cached_distance_bounds(pair, np.array([slot]), world_t_element, *self._core, *self.kept, found)
        return float(found[0])

    def add(self, one: int, other: int, world_t_element: Floats, distance: float) -> int:
        """Keep the distance (m) of two elements that are at these poses (e, 4, 4); return where, as `slots` does."""
        slot = self._slots.get((one, other), -1)
        if distance < LEAST:
            return slot
        if slot < 0:
            if len(self._slots) == len(self._distances):
                self._first_t_second = np.concatenate([self._first_t_second, np.zeros_like(self._first_t_second)])
                self._distances = np.concatenate([self._distances, np.full_like(self._distances, -1.0)])
                self._next = np.concatenate([self._next, np.zeros_like(self._next)])
            slot = self._slots[one, other] = len(self._slots)
        place = self._next[slot]
        self._next[slot] = (place + 1) % KEPT
        turn, there = world_t_element[one, :3, :3].T, world_t_element[other, :3]
        self._first_t_second[slot, place, :, :3] = turn @ there[:, :3]
        self._first_t_second[slot, place, :, 3] = turn @ (there[:, 3] - world_t_element[one, :3, 3])
        self._distances[slot, place] = distance
        return slot

    def _forget(self, room: int) -> None:
        self._slots.clear()
        self._first_t_second = np.zeros((room, KEPT, 3, 4))
        self._distances = np.full((room, KEPT), -1.0)
        self._next = np.zeros(room, np.int64)
