"""Inventory of what there is to draw: the shapes that nodes show, grouped so that equal ones become one batch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.alarm import reddened
from virtualrobot_kernel.drawing.figure_glb import Rgba
from virtualrobot_kernel.drawing.library import AXIS_ARROW, ShapeKey, ShapeLibrary, Vector, shape_key
from virtualrobot_kernel.world.figures import Figure, Frame, Label, Pose
from virtualrobot_kernel.world.structure import JointType, Kind, LinkData, Node, Structure
from virtualrobot_kernel.world.visibility import inherited_visibility

BatchKey = tuple[ShapeKey, Rgba | None]
"""Instances with equal keys are drawn at once: shape and colour."""

AXIS_COLORS: dict[JointType, Rgba] = {
    JointType.REVOLUTE: (0.85, 0.20, 0.62, 1.0),
    JointType.CONTINUOUS: (0.85, 0.20, 0.62, 1.0),
    JointType.PRISMATIC: (0.95, 0.55, 0.10, 1.0),
    JointType.PLANAR: (0.10, 0.62, 0.65, 1.0),
}
"""Colours of joint axes; a planar joint shows the normal of its plane, a floating one has no axis."""

TARGET_SIZE = 0.06
"""Length of the arrows of a target, in meters."""

FLOOR = 30.0
"""In meters: what is wider is a floor."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """One shape of a node: which, how large, and where in the node's frame."""

    key: BatchKey
    scale: Vector
    node_t_shape: Pose
    tool_state: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Look of a node: shapes in batches, and points, lines and labels one by one."""

    pieces: tuple[Piece, ...]
    annotations: tuple[Figure, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """All visible instances of one shape: rows (n,) of their nodes, poses in those (n, 4, 4), scales (n, 3)."""

    rows: NDArray[np.int64]
    node_t_shape: NDArray[np.float64]
    scale: NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Inventory:
    """Batches that are visible now, and the looks by node, from which the next inventory is made."""

    looks: Mapping[Node, Look]
    visible: Mapping[int, tuple[Piece, ...]]
    annotations: tuple[tuple[int, Figure], ...]
    batches: Mapping[BatchKey, Batch]
    used: frozenset[BatchKey]


def take(
    structure: Structure,
    tool_states: Mapping[int, str],
    axis_pieces: tuple[tuple[int, Piece], ...] = (),
    before: Inventory | None = None,
    red: frozenset[int] = frozenset(),
) -> Inventory:
    """Return what is to be drawn.

    Args:
        structure: the nodes.
        tool_states: state by tool uid; a tool that is not in it is in its first state.
        axis_pieces: (uid, piece) to show besides the figures (see `joint_axes`).
        before: the last inventory; looks of nodes that are still the same objects are taken from it.
        red: nodes (uids) that are red instead of their own colours.
    """
    known = before.looks if before else {}
    looks = {node: known.get(node) or look_of(node) for node in structure.nodes.values()}
    hidden, states = inherited_visibility(structure, tool_states)
    visible: dict[int, tuple[Piece, ...]] = {}
    annotations: list[tuple[int, Figure]] = []
    for uid, node in structure.nodes.items():
        if hidden[uid]:
            continue
        look, state = looks[node], states[uid]
        if pieces := tuple(piece for piece in look.pieces if piece.tool_state in ("", state)):
            visible[uid] = tuple(map(_red, pieces)) if uid in red else pieces
        annotations.extend((uid, figure) for figure in look.annotations if figure.tool_state in ("", state))
    shown = [(uid, piece) for uid, pieces in visible.items() for piece in pieces]
    shown.extend((uid, piece) for uid, piece in axis_pieces if not hidden[uid])
    used = {piece.key for look in looks.values() for piece in look.pieces}
    used.update(piece.key for _, piece in axis_pieces)
    # What was red stays in the browser for the next time.
    used.update({(key[0], reddened(key[1])) for key in used} & (before.used if before else frozenset()))
    used.update(piece.key for uid in red for piece in visible.get(uid, ()))
    return Inventory(looks, visible, tuple(annotations), _batches(structure, shown), frozenset(used))


def _red(piece: Piece) -> Piece:
    return replace(piece, key=(piece.key[0], reddened(piece.key[1])))


def figures_of(node: Node) -> tuple[Figure, ...]:
    """Return a node's figures; a target that has none is a small frame with its name."""
    if node.kind is not Kind.TARGET or node.figures:
        return node.figures
    return Figure(Frame(TARGET_SIZE)), Figure(Label(node.name))


def look_of(node: Node) -> Look:
    """Return what a node's visual figures are made of."""
    pieces, annotations = [], []
    for figure in figures_of(node):
        if not figure.visual:
            continue
        piece = _piece(figure)
        if piece is None:
            annotations.append(figure)
        else:
            pieces.append(piece)
    return Look(tuple(pieces), tuple(annotations))


def figures_only(structure: Structure, figures: Iterable[tuple[int, Figure]]) -> Inventory:
    """Return an inventory of nothing but these figures (uid, figure), each in the frame of its node."""
    shown = [(uid, piece) for uid, figure in figures if (piece := _piece(figure)) is not None]
    return Inventory({}, {}, (), _batches(structure, shown), frozenset(piece.key for _, piece in shown))


def _piece(figure: Figure) -> Piece | None:
    shape = shape_key(figure.geometry)
    if shape is None:
        return None
    color = figure.material.color if figure.material else None
    return Piece((shape[0], color), shape[1], figure.node_t_figure, figure.tool_state)


def joint_axes(structure: Structure, robots: tuple[int, ...], library: ShapeLibrary) -> tuple[tuple[int, Piece], ...]:
    """Return (link uid, arrow along the axis of its joint) for each moving joint of the robots."""
    found = []
    for robot in robots:
        for uid in structure.robots[robot].links if robot in structure.robots else ():
            node = structure.nodes[uid]
            data = node.data
            if not isinstance(data, LinkData) or data.joint.type not in AXIS_COLORS:
                continue
            length = _reach(look_of(node), library)
            key = (AXIS_ARROW, AXIS_COLORS[data.joint.type])
            found.append((uid, Piece(key, (length, length, length), turned_to(data.joint.axis))))
    return tuple(found)


def turned_to(axis: Vector) -> Pose:
    """Return a pose (4, 4) at the origin whose z is along the unit vector `axis`."""
    z = np.asarray(axis, np.float64)
    x = np.cross((0.0, 1.0, 0.0) if abs(z[1]) < 0.9 else (1.0, 0.0, 0.0), z)
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2] = x, np.cross(z, x), z
    return pose


def node_bounds(
    structure: Structure, inventory: Inventory, world_t_node: NDArray[np.float64], library: ShapeLibrary, uid: int
) -> NDArray[np.float64] | None:
    """Return the box (2, 3) around what is visible of a node and all below it, or None when nothing is.

    Lowest and highest corner in meters, in the node's frame and along its axes.
    """
    node_t_world = np.linalg.inv(world_t_node[structure.rows[uid]])
    boxes = [
        _box(node_t_world @ world_t_node[structure.rows[below.uid]] @ piece.node_t_shape, piece.scale, points)
        for below in structure.below(uid)
        for piece in inventory.visible.get(below.uid, ())
        if len(points := library.get(piece.key[0]).points)
    ]
    if not boxes:
        return None
    return np.array([np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)])


def world_bounds(
    inventory: Inventory, world_t_node: NDArray[np.float64], library: ShapeLibrary
) -> NDArray[np.float64] | None:
    """Return a box (2, 3) that holds everything visible, or None when nothing is; meters, along the world's axes.

    It is quick and may be wider than needed, since it goes by the corners of each shape's own box. Floors
    count only where there is nothing else.
    """
    boxes = []
    for (shape, _), batch in inventory.batches.items():
        corners = library.get(shape).corners
        if shape == AXIS_ARROW or len(corners) == 0:
            continue
        poses = world_t_node[batch.rows] @ batch.node_t_shape
        linear = poses[:, :3, :3] * batch.scale[:, None, :]
        places = corners @ linear.transpose(0, 2, 1) + poses[:, None, :3, 3]
        boxes.append(np.stack([places.min(axis=1), places.max(axis=1)], axis=1))
    if not boxes:
        return None
    each = np.concatenate(boxes)
    small = each[np.ptp(each, axis=1).max(axis=1) < FLOOR]
    each = small if len(small) else each
    return np.stack([each[:, 0].min(axis=0), each[:, 1].max(axis=0)])


def _box(frame_t_shape: NDArray[np.float64], scale: Vector, points: NDArray[np.float32]) -> NDArray[np.float64]:
    linear = (frame_t_shape[:3, :3] * scale).astype(np.float32)
    moved = points @ linear.T
    return np.array([moved.min(axis=0), moved.max(axis=0)]) + frame_t_shape[:3, 3]


def _reach(look: Look, library: ShapeLibrary) -> float:
    """Return the length in meters of half an axis that sticks out of its link and of the one before it.

    It is 1.5 times as long as the link's shapes reach from the origin of its joint, 0.15 m at least.
    """
    corners = [
        (library.get(piece.key[0]).corners * piece.scale) @ piece.node_t_shape[:3, :3].T + piece.node_t_shape[:3, 3]
        for piece in look.pieces
    ]
    return 1.5 * max([0.1, *(float(np.linalg.norm(places, axis=1).max()) for places in corners if len(places))])


def _batches(structure: Structure, shown: list[tuple[int, Piece]]) -> dict[BatchKey, Batch]:
    groups: dict[BatchKey, list[tuple[int, Piece]]] = {}
    for uid, piece in shown:
        groups.setdefault(piece.key, []).append((structure.rows[uid], piece))
    return {
        key: Batch(
            np.array([row for row, _ in group], np.int64),
            np.array([piece.node_t_shape for _, piece in group]),
            np.array([piece.scale for _, piece in group], np.float32),
        )
        for key, group in groups.items()
    }
