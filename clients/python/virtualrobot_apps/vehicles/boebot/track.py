"""A black line on the floor: straight pieces and arcs, one after the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

WIDTH = 0.02
"""Width of the line (m): a tape of 3/4 inch."""

PIECES: Sequence[tuple[float, float]] = (
    (1.0, 0.0),
    (math.pi * 0.4, math.pi),
    (0.2, 0.0),
    (math.pi / 3.0 * 0.25, math.pi / 3.0),
    (math.pi / 1.5 * 0.25, -math.pi / 1.5),
    (math.pi / 3.0 * 0.25, math.pi / 3.0),
    (math.pi * 0.4, math.pi),
    (4.0 * 0.25 * math.sin(math.pi / 3.0) - 0.8, 0.0),
)
"""A closed way with bends to both sides: length (m) of each piece, and how far it turns to the left meanwhile (rad)."""


@dataclass(frozen=True, eq=False)
class Track:
    """A way over the floor as places close to each other.

    places: (n, 2) in the world (m). headings: (n,) of the way there (rad). ways: (n,) length from the start (m).
    """

    places: Floats
    headings: Floats
    ways: Floats

    @classmethod
    def of(cls, pieces: Sequence[tuple[float, float]] = PIECES, step: float = 0.01) -> Track:
        """Return the track of pieces (length, turn) from the origin along x, with places `step` (m) apart at most."""
        places, headings, ways = [np.zeros(2)], [0.0], [0.0]
        for length, turn in pieces:
            count = max(1, math.ceil(length / step))
            part, bend = length / count, turn / count
            chord = part * float(np.sinc(bend / (2.0 * math.pi)))
            for _ in range(count):
                middle = headings[-1] + 0.5 * bend
                places.append(places[-1] + chord * np.array([math.cos(middle), math.sin(middle)]))
                headings.append(headings[-1] + bend)
                ways.append(ways[-1] + part)
        return cls(np.array(places), np.array(headings), np.array(ways))

    @property
    def length(self) -> float:
        """Return the whole way (m)."""
        return float(self.ways[-1])

    def pose(self, way: float) -> tuple[float, float, float]:
        """Return x, y (m) and heading (rad) at a way (m) from the start."""
        x, y = (float(np.interp(way, self.ways, self.places[:, axis])) for axis in range(2))
        return x, y, float(np.interp(way, self.ways, self.headings))

    def nearest(self, place: Floats, begin: float, end: float) -> tuple[float, float]:
        """Return the way (m) to the point nearest to a place, between two ways, and how far left of it that is."""
        first, last = np.searchsorted(self.ways, [begin, end])
        near = slice(max(0, int(first) - 1), int(last) + 1)
        at = near.start + int(np.argmin(np.linalg.norm(self.places[near] - place, axis=1)))
        ahead = np.array([math.cos(self.headings[at]), math.sin(self.headings[at])])
        off = place - self.places[at]
        way = float(self.ways[at] + ahead @ off)
        return way, float(ahead[0] * off[1] - ahead[1] * off[0])
