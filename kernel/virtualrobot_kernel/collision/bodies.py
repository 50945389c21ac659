"""Collision bodies of a snapshot: the collision figures of its nodes as elements, and which pairs of them are asked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import AllowedPairs, Pair, allowed_pairs
from virtualrobot_kernel.collision.geometry import CollisionShapes, Solid
from virtualrobot_kernel.world.collisions import Allowance
from virtualrobot_kernel.world.figures import Figure
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import FOR_PEOPLE, WORLD_UID, Kind, Structure
from virtualrobot_kernel.world.visibility import inherited_visibility

Floats = NDArray[np.float64]

BODILESS = frozenset(
    {
        *FOR_PEOPLE,
        *(Kind.RANGE_SENSOR, Kind.CAMERA_SENSOR, Kind.CONTACT_SENSOR, Kind.MOTION_SENSOR, Kind.LIGHT),
    }
)
"""Kinds of nodes that touch nothing."""

MadeOf = tuple[Structure, Mapping[int, str], Mapping[Pair, Allowance], Mapping[int, float]]


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """The e elements of a world, in the order of the nodes, and the groups that are asked.

    Attributes:
        figures: (e) of each element; equal geometry shares one solid.
        solids: (e) of each element.
        uids: (e,) the node of each element.
        rows: (e,) the row of that node in the arrays of poses.
        node_t_element: (e, 4, 4) where each element is in its node's frame.
        padding: (e,) by how much each element counts as thicker, in meters: the padding of its node, and the margin of
            its solid.
        robots: (e,) the robot (uid) that each element belongs to; 0: none.
        elements: of each node that has some (uid), its elements.
        groups: of each robot that has elements, (its uid, its elements (k,), whether a pair of one of these and any
            element is asked (k, e)); each pair is asked once, and what belongs to no robot is not asked among itself.
        allowed: what may touch.
        made_of: the structure, tool states, clients' pairs and paddings that it was made of.
    """

    figures: tuple[Figure, ...]
    solids: tuple[Solid, ...]
    uids: NDArray[np.int64]
    rows: NDArray[np.int64]
    node_t_element: Floats
    padding: Floats
    robots: NDArray[np.int64]
    elements: Mapping[int, tuple[int, ...]]
    groups: tuple[tuple[int, NDArray[np.int64], NDArray[np.bool_]], ...]
    allowed: AllowedPairs
    made_of: MadeOf


def made_of(snapshot: Snapshot) -> MadeOf:
    """Return what the bodies of a snapshot follow from."""
    state = snapshot.state
    return snapshot.structure, state.tool_states, state.allowed_pairs, state.collisions.paddings


def collision_figures(snapshot: Snapshot) -> Iterator[tuple[int, Figure]]:
    """Yield each figure that can collide, after its node (uid), in the order of nodes; of a tool those of its state."""
    structure = snapshot.structure
    _, states = inherited_visibility(structure, snapshot.state.tool_states)
    for uid, node in structure.nodes.items():
        if node.figures and node.kind not in BODILESS:
            for figure in node.figures:
                if figure.collision and (not figure.tool_state or figure.tool_state == states[uid]):
                    yield uid, figure


def bodies_of(snapshot: Snapshot, shapes: CollisionShapes) -> Bodies:
    """Return what can collide: figures of the role collision, hidden ones too, and those of each tool's state."""
    structure, tool_states, by_clients, paddings = made_of(snapshot)
    figures: list[Figure] = []
    solids: list[Solid] = []
    uids: list[int] = []
    places: dict[int, list[int]] = {}
    for uid, figure in collision_figures(snapshot):
        solid = shapes.get(figure.geometry)
        if solid is not None:
            places.setdefault(uid, []).append(len(figures))
            figures.append(figure)
            solids.append(solid)
            uids.append(uid)
    elements = {uid: tuple(own) for uid, own in places.items()}
    allowed = allowed_pairs(structure, by_clients)
    robots = np.array([allowed.groups[uid] for uid in uids], np.int64)
    return Bodies(
        figures=tuple(figures),
        solids=tuple(solids),
        uids=np.array(uids, np.int64),
        rows=np.array([structure.rows[uid] for uid in uids], np.int64),
        node_t_element=np.array([figure.node_t_figure for figure in figures], np.float64).reshape(-1, 4, 4),
        padding=np.array([paddings.get(uid, 0.0) + one.margin for uid, one in zip(uids, solids, strict=True)]),
        robots=robots,
        elements=elements,
        groups=_groups(uids, robots, elements, allowed),
        allowed=allowed,
        made_of=(structure, tool_states, by_clients, paddings),
    )


def _groups(
    uids: list[int], group: NDArray[np.int64], elements: Mapping[int, tuple[int, ...]], allowed: AllowedPairs
) -> tuple[tuple[int, NDArray[np.int64], NDArray[np.bool_]], ...]:
    body = np.array([allowed.bodies[uid] for uid in uids], np.int64)
    node = np.array(uids, np.int64)
    place = np.arange(len(uids))
    found = []
    for robot in dict.fromkeys(group[group > 0].tolist()):
        own = np.flatnonzero(group == robot)
        # A pair of two robots is asked by the one whose element comes first.
        asked = (group == 0)[None] | (place[None] > own[:, None])
        rigid = (body[None] == body[own, None]) & ((group == robot)[None] | (body[None] != WORLD_UID))
        asked &= ~rigid & (node[None] != node[own, None])
        found.append((robot, own, asked))
    row_of = {element: (at, row) for at, (_, own, _) in enumerate(found) for row, element in enumerate(own.tolist())}
    for one, other in allowed.pairs:
        for first in elements.get(one, ()):
            for second in elements.get(other, ()):
                for own, against in ((first, second), (second, first)):
                    if own in row_of:
                        at, row = row_of[own]
                        found[at][2][row, against] = False
    return tuple(found)
