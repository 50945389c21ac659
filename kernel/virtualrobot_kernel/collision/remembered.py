"""Distances that were measured, kept with how the two elements stood to each other: bounds for all places near."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.nearest import Floats
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.numeric.gaps import remembered_distances

Integers = NDArray[np.int64]

KEPT = 12
"""How many distances of a pair are kept; the oldest makes room."""

MOST = 2048
"""Of how many pairs some are kept; one more, and all are forgotten."""


class Remembered:
    """The last measured distances of pairs of elements. Used by one thread.

    Measuring takes FCL up to milliseconds. What was measured holds for other places too, less how far the elements
    have moved against each other since: so a robot that goes along slowly is seldom measured again.
    """

    def __init__(self, placed: Placed) -> None:
        """Keep nothing yet of the elements of `placed`; where these are is told with each call."""
        self._core = placed.core
        self._slots: dict[tuple[int, int], int] = {}
        self._forget(16)

    def slots(self, pairs: Integers) -> Integers:
        """Return where what is known of pairs (k, 2) is kept, (k,); -1 for those of which nothing is."""
        if not self._slots:
            return np.full(len(pairs), -1)
        return np.array([self._slots.get((one, other), -1) for one, other in pairs.tolist()], np.int64)

    def bounds(self, pairs: Integers, world_t_element: Floats) -> Floats:
        """Return lower bounds (k,) of the distances of pairs (k, 2) of elements that are at poses (e, 4, 4)."""
        found, slots = np.zeros(len(pairs)), self.slots(pairs)
        if (slots >= 0).any():
            remembered_distances(
                pairs, slots, world_t_element, *self._core, self._first_t_second, self._distances, found
            )
        return found

    def add(self, one: int, other: int, world_t_element: Floats, distance: float) -> None:
        """Keep the distance (m) of two elements that are at these poses (e, 4, 4)."""
        slot = self._slots.get((one, other))
        if slot is None:
            if len(self._slots) == MOST:
                self._forget(16)
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

    def _forget(self, room: int) -> None:
        self._slots.clear()
        self._first_t_second = np.zeros((room, KEPT, 3, 4))
        self._distances = np.full((room, KEPT), -1.0)
        self._next = np.zeros(room, np.int64)
