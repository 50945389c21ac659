"""Solids at places: FCL's collision objects of one thread, and the boxes around them for the broad phase."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import fcl
import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.geometry import Solid
from virtualrobot_kernel.collision.nearest import Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Objects:
    """FCL's objects of one element: of its core's pieces, and of its solid (None for a mesh)."""

    pieces: tuple[Any, ...]
    whole: Any

    @staticmethod
    def of(solid: Solid) -> _Objects:
        """Return new objects."""
        pieces = tuple(fcl.CollisionObject(piece.model, fcl.Transform()) for piece in solid.pieces)
        return _Objects(pieces, fcl.CollisionObject(solid.solid, fcl.Transform()) if solid.solid else None)


class Placed:
    """Solids and where they are. Used by one thread; the solids themselves are shared.

    Attributes:
        solids: (e) the elements.
        world_t_element: (e, 4, 4) where they are.
        first_piece: (e + 1,) the pieces of element i are first_piece[i] to first_piece[i + 1].
        centre: (p, 3) and `half` (p, 3): the box around each piece along the world's axes, radius included.
    """

    def __init__(self, solids: Sequence[Solid], world_t_element: Floats, before: Placed | None = None) -> None:
        """Place solids (e) at poses (e, 4, 4).

        FCL's objects are taken from `before`, which is of no use then, where it has some of the same solids: python-fcl
        0.7 frees an object's memory but for 31 bytes, and scenes change often.
        """
        self.solids = tuple(solids)
        counts = [len(solid.pieces) for solid in self.solids]
        self.first_piece = np.cumsum([0, *counts])
        self._element = np.repeat(np.arange(len(counts)), counts)
        parts = [(piece, solid.radius) for solid in self.solids for piece in solid.pieces]
        self._local_centre = np.array([piece.centre for piece, _ in parts]).reshape(-1, 3)
        self._local_half = np.array([piece.half for piece, _ in parts]).reshape(-1, 3)
        self._radius = np.array([radius for _, radius in parts]).reshape(-1, 1)
        left: dict[int, list[_Objects]] = {}
        for solid, objects in zip(before.solids, before._objects, strict=True) if before else ():
            left.setdefault(id(solid), []).append(objects)
        self._objects = [left[id(solid)].pop() if left.get(id(solid)) else _Objects.of(solid) for solid in self.solids]
        self._pieces = [piece for objects in self._objects for piece in objects.pieces]
        self.world_t_element = np.full((len(self.solids), 4, 4), np.nan)
        self.centre, self.half = np.empty((len(parts), 3)), np.empty((len(parts), 3))
        self.move(world_t_element)

    def move(self, world_t_element: Floats) -> None:
        """Put the elements elsewhere, (e, 4, 4); only what moved costs."""
        moved = np.flatnonzero((world_t_element != self.world_t_element).any(axis=(1, 2)))
        self.world_t_element = world_t_element
        for element in moved.tolist():
            pose = world_t_element[element]
            place = fcl.Transform(pose[:3, :3], pose[:3, 3])
            own = slice(self.first_piece[element], self.first_piece[element + 1])
            for at in (*self._objects[element].pieces, self._objects[element].whole):
                if at is not None:
                    at.setTransform(place)
            self.centre[own] = self._local_centre[own] @ pose[:3, :3].T + pose[:3, 3]
            self.half[own] = self._local_half[own] @ np.abs(pose[:3, :3]).T + self._radius[own]

    def boxes(self) -> tuple[Floats, Floats]:
        """Return centre and half (e, 3) of the box around each element; one without pieces is far from all."""
        count = np.diff(self.first_piece)
        centre, half = np.zeros((len(count), 3)), np.full((len(count), 3), -np.inf)
        if len(self.centre):
            start = self.first_piece[:-1][count > 0]
            lower = np.minimum.reduceat(self.centre - self.half, start)
            upper = np.maximum.reduceat(self.centre + self.half, start)
            centre[count > 0], half[count > 0] = 0.5 * (lower + upper), 0.5 * (upper - lower)
        return centre, half

    def piece(self, row: int) -> Any:  # noqa: ANN401 FCL has no types
        """Return FCL's object of a piece of a core."""
        return self._pieces[row]

    def whole(self, element: int) -> Any:  # noqa: ANN401 FCL has no types
        """Return FCL's object of an element's solid; None for a mesh."""
        return self._objects[element].whole

    def triangles(self, row: int, which: NDArray[np.int64]) -> Floats:
        """Return some triangles (k, 3, 3) of a piece in the world."""
        element = self._element[row]
        piece = self.solids[element].pieces[row - self.first_piece[element]]
        pose = self.world_t_element[element]
        return piece.triangles[which] @ pose[:3, :3].T + pose[:3, 3]


def piece_distance(first: Placed, second: Placed, row: int, to: int) -> tuple[float, Floats]:
    """Return how far the pieces of two cores are apart (m; at most 0 where they cut), and the points (2, 3) there."""
    result = fcl.DistanceResult()
    request = fcl.DistanceRequest(enable_nearest_points=True)
    return fcl.distance(first.piece(row), second.piece(to), request, result), np.array(result.nearest_points)
