"""Solids at places: FCL's collision objects of one thread, and the boxes around them for the broad phase."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import fcl
import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.geometry import Solid
from virtualrobot_kernel.collision.nearest import Floats
from virtualrobot_kernel.collision.tessellation import SEGMENTS
from virtualrobot_kernel.numeric.boxes import follow_nodes, overlapping_boxes
from virtualrobot_kernel.numeric.certainty import Figures
from virtualrobot_kernel.numeric.memory import address_of, read_only


class Placed:
    """Solids and where they are. Used by one thread; the solids themselves are shared.

    FCL's objects are made and put to their places when they are first asked for: most elements never are, since the
    boxes around them are far from each other.

    Attributes:
        solids: (e) the elements.
        world_t_element: (e, 4, 4) where they are.
        first_piece: (e + 1,) the pieces of element i are first_piece[i] to first_piece[i + 1].
        padding: (e) by how much each element counts as thicker, in meters.
        centre: (e, 3) and `half` (e, 3): the box around each element along the world's axes, radius and padding
            included; a half far below 0 for an element without pieces.
        core: centre and half (e, 3) of the box around each core in its element's frame, and `reach` (e, 3) the half
            with radius and padding.
        figures: the same elements as compiled code asks whether they are certainly apart.
        blocks: first block of each element (e + 1,), and centre and half (b, 3) of each in its element's frame.
    """

    def __init__(
        self,
        solids: Sequence[Solid],
        world_t_element: Floats,
        before: Placed | None = None,
        padding: Floats | None = None,
    ) -> None:
        """Place solids (e) at poses (e, 4, 4), each of them thicker by a padding (e,) in meters; None: none is.

        FCL's objects are taken from `before`, which is of no use then, where it has some of the same solids: python-fcl
        0.7 frees an object's memory but for 31 bytes, and scenes change often.
        """
        self.solids = tuple(solids)
        self.first_piece = np.cumsum([0, *(len(solid.pieces) for solid in self.solids)])
        self._first_piece = self.first_piece.tolist()
        self._element = np.repeat(np.arange(len(self.solids)), np.diff(self.first_piece))
        self.core = (
            np.array([solid.centre for solid in self.solids]).reshape(-1, 3),
            np.array([solid.half for solid in self.solids]).reshape(-1, 3),
        )
        thicker = np.zeros(len(self.solids)) if padding is None else padding
        self.padding: list[float] = thicker.tolist()
        self._thickness = np.array([solid.radius for solid in self.solids]).reshape(-1, 1) + thicker[:, None]
        self._objects = before._taken_by(self.solids) if before else {}
        self._moved_since = set(range(len(self.solids)))
        own = [solid.blocks for solid in self.solids]
        own = [(centre, half + more) for (centre, half), more in zip(own, self.padding, strict=True)]
        first_block = np.cumsum([0, *(len(centre) for centre, _ in own)])
        centre, half = (np.concatenate([np.zeros((0, 3)), *(side[i] for side in own)]) for i in (0, 1))
        self.blocks = first_block, centre, half
        self._piece_of_block = (self.first_piece - first_block).tolist()
        self.reach = self.core[1] + self._thickness
        self._trees = np.zeros((len(self.solids), 4), np.int64)
        figures = (
            *self.core,
            self._thickness[:, 0] + np.array([_beyond(solid) for solid in self.solids]),
            np.array([solid.is_box for solid in self.solids], np.bool_),
            np.array([solid.solid is not None for solid in self.solids], np.bool_),
            np.array([_corner(solid) for solid in self.solids]).reshape(-1, 3),
            self._trees,
        )
        self.figures = Figures(*(read_only(array) for array in figures))
        self._moved = np.empty(len(self.solids), np.int64)
        self._overlaps, self._depths = np.empty((256, 4), np.int64), np.empty(256)
        self._boxes: dict[int, tuple[Floats, Floats]] = {}
        self.world_t_element = world_t_element.copy()
        self.centre, self.half = np.empty((len(self.solids), 3)), np.empty((len(self.solids), 3))
        self._bound(np.arange(len(self.solids)))

    def move(self, world_t_element: Floats) -> None:
        """Put the elements elsewhere, (e, 4, 4); only what moved costs."""
        moved = np.flatnonzero((world_t_element != self.world_t_element).any(axis=(1, 2)))
        self.move_some(moved, world_t_element[moved])

    def move_some(self, elements: NDArray[np.int64], world_t_element: Floats) -> None:
        """Put some elements elsewhere, (k, 4, 4)."""
        self.world_t_element[elements] = world_t_element
        self._bound(elements)
        self._moved_since.update(elements.tolist())
        self._boxes.clear()

    def put(self, elements: Sequence[int], world_t_element: Floats) -> None:
        """Put some elements elsewhere, (k, 4, 4), without the boxes around them, till these are put back.

        For who knows which pieces to ask FCL about.
        """
        self.world_t_element[elements] = world_t_element
        self._moved_since.update(elements)
        self._boxes.clear()

    def follow(self, world_t_node: Floats, before: Floats, rows: NDArray[np.int64], node_t_element: Floats) -> None:
        """Put elements at `node_t_element` (e, 4, 4) of the nodes `rows` (e,), as far as these have moved since."""
        local = self.core[0], self.reach
        state = self.world_t_element, self.centre, self.half
        count = follow_nodes(world_t_node, before, rows, node_t_element, *local, *state, self._moved)
        if count:
            self._moved_since.update(self._moved[:count].tolist())
            self._boxes.clear()

    def overlaps(
        self, own: NDArray[np.int64], asked: NDArray[np.bool_], deepest_first: bool = False
    ) -> Iterator[tuple[int, int, int, int]]:
        """Return the pairs of pieces whose boxes overlap: element, element, row, row.

        A solid counts as one piece, its first: its box is around all of it.

        Args:
            own: (k,) elements.
            asked: (k, e) which pairs of one of these and any element are asked.
            deepest_first: whether those come first whose boxes are the deepest in each other: they mostly touch.
        """
        boxes = self.centre, self.half, self.world_t_element, *self.blocks
        count = overlapping_boxes(own, asked, *boxes, self._overlaps, self._depths)
        if count > len(self._overlaps):
            self._overlaps, self._depths = np.empty((2 * count, 4), np.int64), np.empty(2 * count)
            overlapping_boxes(own, asked, *boxes, self._overlaps, self._depths)
        found = self._overlaps[:count]
        if deepest_first and count > 1:
            found = found[np.argsort(-self._depths[:count], kind="stable")]
        return self.pieces(found)

    def pieces(self, overlaps: NDArray[np.int64]) -> Iterator[tuple[int, int, int, int]]:
        """Return the pieces (element, element, row, row) that overlapping blocks (p, 4) are around."""
        to_piece = self._piece_of_block
        return ((i, j, a + to_piece[i], b + to_piece[j]) for i, j, a, b in overlaps.tolist())

    def boxes(self, element: int) -> tuple[Floats, Floats]:
        """Return centre (k, 3) and half (k, 3) of the boxes round an element's pieces, with radius, without padding."""
        found = self._boxes.get(element)
        if found is None:
            solid, turn = self.solids[element], self.world_t_element[element, :3, :3]
            centre = solid.piece_centre @ turn.T + self.world_t_element[element, :3, 3]
            found = self._boxes[element] = centre, solid.piece_half @ np.abs(turn).T + solid.radius
        return found

    def make_trees(self, elements: Iterable[int]) -> None:
        """Make the trees of some elements, as far as nobody has."""
        for element in elements:
            if not self._trees[element, 0]:
                tree = self.solids[element].tree
                self._trees[element] = [number for array in tree for number in (address_of(array), len(array))]

    def piece(self, row: int) -> Any:  # noqa: ANN401 FCL has no types
        """Return FCL's object of a piece of a core."""
        element = int(self._element[row])
        return self._objects_of(element).get(row - int(self.first_piece[element]))

    def piece_of(self, element: int, row: int) -> Any:  # noqa: ANN401 FCL has no types
        """Return FCL's object of a piece whose element is known."""
        return self._objects_of(element).get(row - self._first_piece[element])

    def whole(self, element: int) -> Any:  # noqa: ANN401 FCL has no types
        """Return FCL's object of an element's solid; None for a mesh."""
        return self._objects_of(element).get(-1)

    def rows(self, element: int, row: int) -> range:
        """Return the rows of the pieces that a block at `row` is around: that of a mesh, or all of a solid."""
        return range(row, row + (1 if self.solids[element].solid is None else len(self.solids[element].pieces)))

    def segment(self, element: int) -> Floats:
        """Return the ends (2, 3) of the core of a sphere or a capsule in the world."""
        pose, half = self.world_t_element[element], self.solids[element].half[2]
        return pose[:3, 3] + np.array([[-half], [half]]) * pose[:3, 2]

    def triangles(self, row: int, which: NDArray[np.int64]) -> Floats:
        """Return some triangles (k, 3, 3) of a piece in the world."""
        element = self._element[row]
        piece = self.solids[element].pieces[row - self.first_piece[element]]
        pose = self.world_t_element[element]
        return piece.triangles[which] @ pose[:3, :3].T + pose[:3, 3]

    def _taken_by(self, solids: Sequence[Solid]) -> dict[int, _Objects]:
        """Return objects for elements with these solids, as far as this has some of the same."""
        left: dict[int, list[_Objects]] = {}
        for element, objects in self._objects.items():
            left.setdefault(id(self.solids[element]), []).append(objects)
        return {place: left[id(solid)].pop() for place, solid in enumerate(solids) if left.get(id(solid))}

    def _bound(self, elements: NDArray[np.int64]) -> None:
        turn = self.world_t_element[elements, :3, :3]
        local = self.core[0][elements, :, None], self.core[1][elements, :, None]
        self.centre[elements] = (turn @ local[0])[:, :, 0] + self.world_t_element[elements, :3, 3]
        self.half[elements] = (np.abs(turn) @ local[1])[:, :, 0] + self._thickness[elements]

    def _objects_of(self, element: int) -> _Objects:
        objects = self._objects.get(element)
        if objects is None:
            objects = self._objects[element] = _Objects(self.solids[element])
        if element in self._moved_since:
            self._moved_since.discard(element)
            objects.moved(self.world_t_element[element])
        return objects


class _Objects:
    """FCL's objects of one element: one for each piece, the last one for its solid, None for a mesh.

    Each is put to the element's place when it is asked for.
    """

    __slots__ = ("_at", "_objects", "_place", "_time")

    def __init__(self, solid: Solid) -> None:
        """Make them; `moved` says where they are."""
        self._objects = [fcl.CollisionObject(piece.model, fcl.Transform()) for piece in solid.pieces]
        self._objects.append(fcl.CollisionObject(solid.solid, fcl.Transform()) if solid.solid else None)
        self._at = [0] * len(self._objects)
        self._time, self._place = 0, fcl.Transform()

    def moved(self, pose: Floats) -> None:
        """Say that the element is at another pose (4, 4)."""
        self._time += 1
        self._place = fcl.Transform(pose[:3, :3], pose[:3, 3])

    def get(self, place: int) -> Any:  # noqa: ANN401 FCL has no types
        """Return the object of a piece, or that of the solid (-1), at its place."""
        found = self._objects[place]
        if self._at[place] != self._time and found is not None:
            self._at[place] = self._time
            found.setTransform(self._place)
        return found


def _beyond(solid: Solid) -> float:
    """Return by how much a round solid stands out of the triangles of its core, in m."""
    return 0.0 if solid.circles is None else max(solid.circles[1:]) * (1.0 - float(np.cos(np.pi / SEGMENTS)))


def _corner(solid: Solid) -> Floats:
    return solid.pieces[0].triangles[0, 0] if solid.pieces else np.zeros(3)


def piece_distance(first: Placed, second: Placed, row: int, to: int) -> tuple[float, Floats]:
    """Return how far the pieces of two cores are apart (m; at most 0 where they cut), and the points (2, 3) there."""
    result = fcl.DistanceResult()
    request = fcl.DistanceRequest(enable_nearest_points=True)
    return fcl.distance(first.piece(row), second.piece(to), request, result), np.array(result.nearest_points)
