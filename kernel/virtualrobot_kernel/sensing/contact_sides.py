"""Contact pairs of a sensor: the figures of a watched node, and those that it can touch, as solids at places."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.geometry import CollisionShapes, Solid
from virtualrobot_kernel.world.figures import Figure
from virtualrobot_kernel.world.sensing import ContactSensor
from virtualrobot_kernel.world.structure import FOR_PEOPLE, Kind, Node, Structure
from virtualrobot_kernel.world.visibility import inherited_visibility

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ContactSide:
    """The e figures of some nodes that can be touched: their solids, the nodes (uids), their rows, and the poses."""

    solids: tuple[Solid, ...]
    uids: tuple[int, ...]
    rows: NDArray[np.int64]
    node_t_element: Floats

    def world_t_element(self, world_t_node: Floats) -> Floats:
        """Return where each figure is in the world's frame, (e, 4, 4), with the nodes at `world_t_node` (N, 4, 4)."""
        return world_t_node[self.rows] @ self.node_t_element


def contact_sides(
    structure: Structure,
    tool_states: Mapping[int, str],
    sensor: Node,
    settings: ContactSensor,
    shapes: CollisionShapes,
) -> tuple[ContactSide, ContactSide]:
    """Return what a contact sensor watches, and what that can touch.

    Watched are the named node (none: the sensor's parent) and all below it. Everything else can be touched, but what
    is ignored, what is hidden, and the robot that the watched node belongs to: its links, adapters and tools. A part
    that this robot holds is none of these, and neither is another robot on it.

    Raises UnknownNameError when a node is named that there is not.
    """
    watched = structure.node(settings.watched) if settings.watched else structure.nodes[sensor.parent]
    ignored = {node.uid for name in settings.ignored for node in structure.below(structure.node(name).uid)}
    inside = {node.uid for node in structure.below(watched.uid)}
    robot = structure.robot_of(watched.uid)
    own = {node.uid for node in _own(structure, robot)} if robot is not None else set()
    outside = structure.nodes.keys() - inside - own - ignored
    visibility = inherited_visibility(structure, tool_states)
    ours, theirs = (
        [node for uid, node in structure.nodes.items() if uid in side] for side in (inside - ignored, outside)
    )
    return _felt(structure, ours, visibility, shapes), _felt(structure, theirs, visibility, shapes)


def _own(structure: Structure, robot: Node) -> Iterator[Node]:
    """Yield a robot and what is its own of what hangs below it."""
    waiting = [robot]
    while waiting:
        node = waiting.pop()
        yield node
        below = (structure.nodes[uid] for uid in structure.children.get(node.uid, ()))
        waiting.extend(one for one in below if one.kind not in (Kind.PART, Kind.ROBOT))


def _felt(
    structure: Structure,
    nodes: Iterable[Node],
    visibility: tuple[Mapping[int, bool], Mapping[int, str]],
    shapes: CollisionShapes,
) -> ContactSide:
    hidden, states = visibility
    found: list[tuple[Solid, int, Figure]] = []
    for node in nodes:
        if hidden[node.uid] or node.kind in FOR_PEOPLE:
            continue
        for figure in node.figures:
            if figure.collision and figure.tool_state in ("", states[node.uid]):
                solid = shapes.get(figure.geometry)
                if solid is not None:
                    found.append((solid, node.uid, figure))
    return ContactSide(
        tuple(solid for solid, _, _ in found),
        tuple(uid for _, uid, _ in found),
        np.array([structure.rows[uid] for _, uid, _ in found], np.int64),
        np.array([figure.node_t_figure for _, _, figure in found], np.float64).reshape(-1, 4, 4),
    )
