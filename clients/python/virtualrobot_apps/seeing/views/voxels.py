"""Voxels about a body: what scans have told of each, and where what is unknown begins.

A voxel that a ray has passed is free, one with an echo is occupied, and others are unknown.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.seeing.given import finite, mask

Floats = NDArray[np.float64]
_ndimage: Any = ndimage

UNKNOWN, FREE, OCCUPIED = np.uint8(0), np.uint8(1), np.uint8(2)
STRIDE, GLANCE = 0.5, 0.75
"""Distance between places on a ray that is taken in, and on one that is only imagined, in edges of a voxel."""
MOST = 20_000_000
"""Most voxels."""
_CROSS, _CUBE = ndimage.generate_binary_structure(3, 1), np.ones((3, 3, 3), bool)


class Voxels:
    """States of the voxels of a box, and how many echoes each has had; low is its lowest corner, in the world (m)."""

    def __init__(self, low: ArrayLike, high: ArrayLike, edge: float) -> None:
        """Begin with nothing known between two corners (3,), voxels having an edge (m)."""
        self.low, self.edge = np.asarray(low, np.float64), float(edge)
        size = np.asarray(high, np.float64) - self.low
        if not (edge > 0.0 and np.isfinite(size).all() and (size >= edge).all()):
            raise InvalidArgumentError(f"a box from {low} to {high} has no room for voxels of {edge} m")
        shape = np.ceil(size / edge - 1e-9).astype(int)
        if shape.prod() > MOST:
            raise InvalidArgumentError(f"{shape.prod():,} voxels are more than {MOST:,}: an edge of {edge} m is short")
        self.states = np.zeros(shape, np.uint8)
        self.counts, self._sums = np.zeros(shape, np.int32), np.zeros((*shape, 3))

    def take(self, origin: Floats, ends: Floats, met: NDArray[np.bool_]) -> int:
        """Take in rays from a place (3,) to their ends (n, 3), where an echo is or not; return those in the box.

        Raises:
            InvalidArgumentError: for numbers that are not finite, and for a mask of another length.
        """
        (origin,), ends = finite([origin], 3, "origins"), finite(ends, 3, "ends of rays")
        met = mask(met, len(ends), "met")
        for places in self._along(origin, ends, np.where(met, -0.5, 0.0) * self.edge):
            self.states[tuple(places.T)] = np.maximum(self.states[tuple(places.T)], FREE)
        echoes = ends[met]
        keys, inside = self._keys(echoes)
        at = tuple(keys[inside].T)
        self.states[at] = OCCUPIED
        np.add.at(self.counts, at, 1)
        np.add.at(self._sums, at, echoes[inside])
        return int(inside.sum())

    def frontier(self) -> NDArray[np.bool_]:
        """Return unknown voxels beside free ones and next to surface: there the surface that is known has an edge."""
        beside = _ndimage.binary_dilation(self.states == FREE, _CROSS)
        near = _ndimage.binary_dilation(self.states == OCCUPIED, _CUBE)
        return (self.states == UNKNOWN) & beside & near

    def first_met(self, origin: Floats, along: Floats, reach: float) -> NDArray[np.int64]:
        """Return flat places of the first voxels that aren't free on rays (n, 3) of length 1 from a place; -1: none."""
        near, far = self._span(origin, along)
        found = np.full(len(along), -1, np.int64)
        crossing = np.flatnonzero((near < np.minimum(far, reach)) & (far > 0.0))
        if not len(crossing):
            return found
        begin, end = np.maximum(near[crossing], 0.0), np.minimum(far[crossing], reach)
        marks = begin[:, None] + np.arange(0.0, float((end - begin).max()), GLANCE * self.edge)
        inside, flat = marks < end[:, None], np.zeros(marks.shape, np.int64)
        for axis, size in enumerate(self.states.shape):
            start, step = (origin[axis] - self.low[axis]) / self.edge, along[crossing, axis] / self.edge
            keys = np.clip((start + marks * step[:, None]).astype(np.int64), 0, size - 1)
            flat = flat * size + keys
        known = self.states.ravel().take(np.where(inside, flat, 0))
        stops = inside & (known != FREE)
        first = stops.argmax(axis=1)
        some = stops.any(axis=1)
        found[crossing[some]] = flat[some, first[some]]
        return found

    def middles(self, mask: NDArray[np.bool_]) -> Floats:
        """Return the middles (n, 3) of some voxels (m)."""
        return self.low + (np.argwhere(mask) + 0.5) * self.edge

    def surface(self) -> tuple[Floats, NDArray[np.int64]]:
        """Return vertices (n, 3) (m) and triangles (m, 3) between occupied voxels and free ones, wound to what is free.

        Vertices lie at the middle of the echoes of the voxels around them.
        """
        occupied, free = np.pad(self.states == OCCUPIED, 1), np.pad(self.states == FREE, 1)
        sides, sums, counts = [], np.pad(self._sums, ((1, 1),) * 3 + ((0, 0),)), np.pad(self.counts, 1)
        square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
        for axis in range(3):
            others = [(axis + 1) % 3, (axis + 2) % 3]
            for way in (1, -1):
                cells = np.argwhere(occupied & np.roll(free, -way, axis))
                corners = np.repeat(cells[:, None], 4, axis=1)
                corners[..., axis] += way > 0
                corners[..., others] += square[::way]
                sides.append(corners)
        corners = np.vstack(sides)
        if not len(corners):
            return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
        unique, number = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
        around = unique[:, None] - np.argwhere(_CUBE[:2, :2, :2])
        at = tuple(np.moveaxis(around, -1, 0))
        weight = counts[at].sum(axis=1)
        vertices = sums[at].sum(axis=1) / weight[:, None]
        quads = number.reshape(-1, 4)
        return vertices, np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])

    def _keys(self, points: Floats) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        keys = np.floor((points - self.low) / self.edge).astype(np.int64)
        return keys, np.asarray(((keys >= 0) & (keys < self.states.shape)).all(axis=1), bool)

    def _span(self, origin: Floats, along: Floats) -> tuple[Floats, Floats]:
        """Return where rays (n, 3) come into the box and leave it (slabs, Kay and Kajiya 1986)."""
        along = np.where(np.abs(along) < 1e-12, 1e-12, along)
        high = self.low + np.array(self.states.shape) * self.edge
        first, second = (self.low - origin) / along, (high - origin) / along
        return np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)

    def _along(self, origin: Floats, ends: Floats, longer: Floats) -> list[NDArray[np.int64]]:
        """Return voxels that rays pass, up to their ends and so much further (m)."""
        away = ends - origin
        lengths = np.linalg.norm(away, axis=1)
        along = away / np.maximum(lengths, 1e-9)[:, None]
        near, far = self._span(origin, along)
        begin, end = np.maximum(near, 0.0), np.minimum(far, lengths + longer)
        some = np.flatnonzero(begin < end)
        found = []
        for part in np.array_split(some, max(1, len(some) // 4000)):
            if not len(part):
                continue
            steps = np.arange(0.0, float((end - begin)[part].max()), STRIDE * self.edge)
            marks = begin[part, None] + steps
            rays, at = np.nonzero(marks < end[part, None])
            keys, inside = self._keys(origin + marks[rays, at, None] * along[part[rays]])
            found.append(keys[inside])
        return found
