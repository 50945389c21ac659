"""Elements that rays can meet: the visible figures of a snapshot at their places. What only people see is left out."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.rays import RayScene, Shape

from virtualrobot_kernel.numeric.scan import composed
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.figures import Figure, Material
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import FOR_PEOPLE, Kind, Structure
from virtualrobot_kernel.world.visibility import inherited_visibility

NO_MATERIAL = Material()
"""Of a figure that says none."""
HOUSING_MARGIN = 0.002
"""A sensor that is so little outside the box about a figure of its link, in meters, looks out of it all the same."""


@dataclass(frozen=True, slots=True, eq=False)
class Elements:
    """The e visible figures of a world, in the order of the nodes; equal worlds give equal orders.

    Attributes:
        shapes: (e) of each figure; equal figures share one.
        figures: (e) the figures, with their materials.
        uids: (e,) the node of each figure.
        rows: (e,) the row of that node in the arrays of poses.
        node_t_element: (e, 4, 4) where each figure is in its node's frame.
        reflectance: (e,) of each figure's material.
        made_of: the structure and tool states that it was made of, and where the unseen nodes were on their parents.
        nodes: the uids of the nodes that have figures, each once; derived.
        node_of: (e,) the place in `nodes` of each figure's node; derived.
    """

    shapes: tuple[Shape, ...]
    figures: tuple[Figure, ...]
    uids: NDArray[np.int64]
    rows: NDArray[np.int64]
    node_t_element: NDArray[np.float64]
    reflectance: NDArray[np.float64]
    made_of: tuple[Structure, Mapping[int, str], bytes]
    nodes: tuple[int, ...] = field(init=False)
    node_of: NDArray[np.int32] = field(init=False)

    def __post_init__(self) -> None:
        """Derive the nodes."""
        nodes, node_of = np.unique(self.uids, return_inverse=True)
        object.__setattr__(self, "nodes", tuple(nodes.tolist()))
        object.__setattr__(self, "node_of", node_of.astype(np.int32))

    def world_t_element(self, world_t_node: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where each figure is in the world's frame, (e, 4, 4), with the nodes at `world_t_node` (N, 4, 4)."""
        found = np.empty_like(self.node_t_element)
        composed(np.ascontiguousarray(world_t_node), self.rows, self.node_t_element, found)
        return found

    def scene(self, world_t_node: NDArray[np.float64]) -> RayScene:
        """Return the scene that ray casters take."""
        return RayScene(self.shapes, self.world_t_element(world_t_node))

    def with_figures(self, added: Sequence[tuple[int, Figure, Shape]]) -> Elements:
        """Return these with more figures of nodes (uids), and their shapes, none of which has a reflectance."""
        if not added:
            return self
        rows = self.made_of[0].rows
        return replace(
            self,
            shapes=(*self.shapes, *(shape for _, _, shape in added)),
            figures=(*self.figures, *(figure for _, figure, _ in added)),
            uids=np.append(self.uids, [uid for uid, _, _ in added]),
            rows=np.append(self.rows, [rows[uid] for uid, _, _ in added]),
            node_t_element=np.concatenate([self.node_t_element, [figure.node_t_figure for _, figure, _ in added]]),
            reflectance=np.append(self.reflectance, np.zeros(len(added))),
        )


def elements_of(
    snapshot: Snapshot, library: ShapeLibrary, before: Elements | None = None, unseen: frozenset[int] = frozenset()
) -> Elements:
    """Return what rays can meet in a snapshot.

    Args:
        snapshot: the world.
        library: makes the shapes.
        before: what this returned last for the same `unseen`; it is returned again where nothing but poses has changed.
        unseen: nodes (uids) whose own figures are left out, such as the sensor's, and with them their housing: the
            figures of a link that such a node stands in.
    """
    structure, tool_states = snapshot.structure, snapshot.state.tool_states
    stand = [uid for uid in sorted(unseen) if uid in structure.rows]
    places = b"".join(snapshot.state.parent_t_node[structure.rows[uid]].tobytes() for uid in stand)
    if before is not None:
        made_of = before.made_of
        if made_of[0] is structure and made_of[1] is tool_states and made_of[2] == places:
            return before
    housings = {structure.nodes[uid].parent: snapshot.state.parent_t_node[structure.rows[uid]] for uid in stand}
    hidden, states = inherited_visibility(structure, tool_states)
    found: list[tuple[Figure, Shape, int]] = []
    for uid, node in structure.nodes.items():
        if hidden[uid] or uid in unseen or node.kind in FOR_PEOPLE:
            continue
        for figure in node.figures:
            if figure.visual and figure.tool_state in ("", states[uid]):
                shape = library.get(figure.geometry)
                if shape is not None and not (
                    uid in housings and node.kind is Kind.LINK and _holds(figure, shape, housings[uid])
                ):
                    found.append((figure, shape, uid))
    reflectance = [(figure.material or NO_MATERIAL).reflectance for figure, _, _ in found]
    return Elements(
        shapes=tuple(shape for _, shape, _ in found),
        figures=tuple(figure for figure, _, _ in found),
        uids=np.array([uid for _, _, uid in found], np.int64),
        rows=np.array([structure.rows[uid] for _, _, uid in found], np.int64),
        node_t_element=np.array([figure.node_t_figure for figure, _, _ in found], np.float64).reshape(-1, 4, 4),
        reflectance=np.array(reflectance, np.float64),
        made_of=(structure, tool_states, places),
    )


def without(elements: Elements, ignored: Collection[int]) -> Elements:
    """Return the elements but those of some nodes (uids)."""
    if not ignored:
        return elements
    kept = np.flatnonzero(~np.isin(elements.uids, list(ignored)))
    return Elements(
        shapes=tuple(elements.shapes[i] for i in kept),
        figures=tuple(elements.figures[i] for i in kept),
        uids=elements.uids[kept],
        rows=elements.rows[kept],
        node_t_element=elements.node_t_element[kept],
        reflectance=elements.reflectance[kept],
        made_of=elements.made_of,
    )


def _holds(figure: Figure, shape: Shape, node_t_sensor: NDArray[np.float64]) -> bool:
    """Return whether the origin of a sensor lies in the box about a figure, in the figure's frame."""
    if not len(shape.vertices):
        return False
    place = np.linalg.solve(figure.node_t_figure, node_t_sensor[:, 3])[:3]
    low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
    return bool((place > low - HOUSING_MARGIN).all() and (place < high + HOUSING_MARGIN).all())
