"""Coats: triangles on nodes that are coloured by a value at each corner, such as a film that grows while a gun sprays.

They are no part of the world: what they show comes ten times a second, is neither journalled nor saved, and nothing is
planned or touched by it. Pictures show them, and range sensors pass through them.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from itertools import count

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.rays import Shape, make_shape

from virtualrobot_kernel.errors import KernelError, LimitError, UnknownNameError
from virtualrobot_kernel.sensing.color_maps import ColorMap, palette
from virtualrobot_kernel.sensing.elements import Elements
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Figure, Mesh
from virtualrobot_kernel.world.listeners import Listeners
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.visibility import inherited_visibility

MOST_COATS = 100
MOST_CORNERS = 1_000_000
"""Largest numbers of coats, and of corners, or of triangles, of all of them."""

WHITE = (1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """Triangles of a coat, which stay the same while its values change.

    Attributes:
        vertices: (n, 3) m, in the node's frame.
        faces: (m, 3) rows of these.
        normals: (n, 3) unit vectors, made of the triangles.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32] = field(init=False)

    def __post_init__(self) -> None:
        """Make the normals."""
        corners = self.vertices[self.faces].astype(np.float64)
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        rows, weights = self.faces.reshape(-1), np.repeat(across, 3, axis=0)
        sums = np.stack([np.bincount(rows, weights[:, axis], len(self.vertices)) for axis in range(3)], axis=1)
        lengths = np.linalg.norm(sums, axis=1, keepdims=True)
        normals = np.where(lengths > 0.0, sums / np.maximum(lengths, 1e-300), [0.0, 0.0, 1.0])
        object.__setattr__(self, "normals", normals.astype(np.float32))


@dataclass(frozen=True, slots=True)
class Legend:
    """Legend of a coat: the colours, the quantity at the values 1 and 255, its unit, and the title."""

    color_map: ColorMap = ColorMap.VIRIDIS
    low: float = 0.0
    high: float = 1.0
    unit: str = ""
    title: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Coat:
    """Coat of the node `uid`; `values` (n,) are of its corners: 0 where there is nothing, 1 to 255 the legend's."""

    name: str
    uid: int
    skin: Skin
    values: NDArray[np.uint8]
    legend: Legend

    @property
    def faces(self) -> NDArray[np.int32]:
        """Return the triangles (k, 3) that are drawn: something is at all their corners."""
        return self.skin.faces[(self.values[self.skin.faces] > 0).all(axis=1)]

    @property
    def colors(self) -> NDArray[np.uint8]:
        """Return the colours (n, 3) of the corners, sRGB."""
        return palette(self.legend.color_map)[self.values]

    def is_repainted(self, before: Coat) -> bool:
        """Return whether it differs from what it was before in its values at most."""
        return (self.uid, self.skin, self.legend) == (before.uid, before.skin, before.legend)


Shown = Mapping[str, Coat]


class Coats:
    """Holds the coats of nodes by name; any thread may read, change and listen."""

    def __init__(self) -> None:
        """Begin without any."""
        self._changing = threading.Lock()
        self._coats: Shown = {}
        self._listeners: Listeners[[Shown]] = Listeners()

    def get(self) -> Shown:
        """Return all coats by name; what is returned never changes."""
        return self._coats

    def set(self, coat: Coat, living: Collection[int]) -> None:
        """Have a coat in place of one of the same name, and forget those of nodes that are not `living` (uids).

        Raises KernelError for a coat that can't be shown, LimitError for too many.
        """
        _check(coat)
        with self._changing:
            kept = {name: one for name, one in self._coats.items() if one.uid in living and name != coat.name}
            _check_sizes((*kept.values(), coat))
            self._coats = shown = {**kept, coat.name: coat}
        self._listeners.tell(shown)

    def paint(self, name: str, first: int, values: NDArray[np.uint8]) -> None:
        """Give values to corners from the row `first` on; raises UnknownNameError, and KernelError for too many."""
        with self._changing:
            coat = self._coats.get(name)
            if coat is None:
                raise UnknownNameError("coat", name, self._coats)
            end = first + len(values)
            if end > len(coat.values):
                raise KernelError(
                    f"the coat {name!r} has {len(coat.values)} corners; {len(values)} values from row {first} on are "
                    f"{end - len(coat.values)} too many",
                    field="values",
                    corners=len(coat.values),
                    first=first,
                    values=len(values),
                )
            painted = np.concatenate([coat.values[:first], values, coat.values[end:]])
            self._coats = shown = {**self._coats, name: replace(coat, values=painted)}
        self._listeners.tell(shown)

    def remove(self, names: Collection[str]) -> None:
        """Take coats away, all where no name is given; raises UnknownNameError, before any is gone, for a wrong one."""
        with self._changing:
            for name in names:
                if name not in self._coats:
                    raise UnknownNameError("coat", name, self._coats)
            self._coats = shown = {name: one for name, one in self._coats.items() if names and name not in names}
        self._listeners.tell(shown)

    def subscribe(self, listener: Callable[[Shown], None]) -> Callable[[], None]:
        """Call `listener` with all coats after each change, in the changing thread; return what ends it."""
        return self._listeners.add(listener)


@dataclass(frozen=True, slots=True, eq=False)
class CoatMesh(Mesh):
    """Mesh of no file: the triangles of a coat that are drawn, as they are coloured now."""

    part: Submesh | None = None


_numbers = count(1)


def with_coats(elements: Elements, snapshot: Snapshot, coats: Shown, unseen: Collection[int] = frozenset()) -> Elements:
    """Return elements with the coats of those nodes that are there, neither hidden nor `unseen` (uids)."""
    if not coats:
        return elements
    structure = snapshot.structure
    hidden, _ = inherited_visibility(structure, snapshot.state.tool_states)
    added: list[tuple[int, Figure, Shape]] = []
    for coat in coats.values():
        if coat.uid not in structure.nodes or hidden[coat.uid] or coat.uid in unseen or not len(faces := coat.faces):
            continue
        skin = coat.skin
        colors = np.concatenate([coat.colors, np.full((len(coat.values), 1), 255, np.uint8)], axis=1)
        part = Submesh(skin.vertices, faces, skin.normals, WHITE, colors)
        figure = Figure(CoatMesh(f"virtualrobot:coat/{next(_numbers)}", "", part=part))
        added.append((coat.uid, figure, make_shape(skin.vertices, faces)))
    return elements.with_figures(added)


def _check(coat: Coat) -> None:
    skin, legend = coat.skin, coat.legend
    if not coat.name.strip():
        raise KernelError("a coat has no name; give it one", field="coat.name")
    if not len(skin.faces):
        raise KernelError(
            f"the coat {coat.name!r} has no triangles; give rows of its vertices, three for each", field="coat.faces"
        )
    if len(coat.values) != len(skin.vertices):
        raise KernelError(
            f"the coat {coat.name!r} has {len(coat.values)} values and {len(skin.vertices)} vertices; give a byte for "
            "each, or none",
            field="coat.values",
            values=len(coat.values),
            vertices=len(skin.vertices),
        )
    for name in ("low", "high"):
        if not math.isfinite(getattr(legend, name)):
            raise KernelError(f"coat.{name} must be a finite number, not {getattr(legend, name)}", field=f"coat.{name}")
    if legend.low >= legend.high:
        raise KernelError(
            f"the coat {coat.name!r} is coloured from {legend.low:g} to {legend.high:g}; `low` must be below `high`",
            field="coat.low",
            low=legend.low,
            high=legend.high,
        )


def _check_sizes(coats: Collection[Coat]) -> None:
    sizes = {
        "coats": (len(coats), MOST_COATS),
        "corners": (sum(len(one.values) for one in coats), MOST_CORNERS),
        "triangles": (sum(len(one.skin.faces) for one in coats), MOST_CORNERS),
    }
    for what, (asked, most) in sizes.items():
        if asked > most:
            raise LimitError(
                f"all coats would have {asked:,} {what}; at most {most:,} are shown: make triangles larger, or remove "
                "coats",
                asked=asked,
                limit=most,
            )
