"""Extent of what rays meet: boxes around a node, and around everything."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.inventory import FLOOR
from virtualrobot_kernel.sensing.elements import Elements
from virtualrobot_kernel.world.state import Snapshot

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64)


def node_box(elements: Elements, snapshot: Snapshot, uid: int) -> NDArray[np.float64] | None:
    """Return the box (2, 3) around a node and all below it, or None where there is nothing of it, or no such node.

    Lowest and highest corner in meters, in the node's frame and along its axes.
    """
    structure = snapshot.structure
    if uid not in structure.nodes:
        return None
    below = {node.uid for node in structure.below(uid)}
    node_t_world = np.linalg.inv(snapshot.world_t(uid))
    poses = node_t_world @ elements.world_t_element(snapshot.world_t_node)
    boxes = [
        _box(pose, shape.vertices)
        for own, pose, shape in zip(elements.uids.tolist(), poses, elements.shapes, strict=True)
        if own in below and len(shape.vertices)
    ]
    if not boxes:
        return None
    return np.array([np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)])


def world_box(elements: Elements, world_t_node: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return a box (2, 3) that holds everything, or None where there is nothing; meters, along the world's axes.

    It goes by the corners of each shape's own box, so it may be wider than needed. Floors count only where there is
    nothing else.
    """
    corners: dict[str, NDArray[np.float64]] = {}
    each = []
    for pose, shape in zip(elements.world_t_element(world_t_node), elements.shapes, strict=True):
        if not len(shape.vertices):
            continue
        if shape.key not in corners:
            low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
            corners[shape.key] = low + CORNERS * (high - low)
        each.append(_box(pose, corners[shape.key]))
    if not each:
        return None
    boxes = np.array(each)
    small = boxes[np.ptp(boxes, axis=1).max(axis=1) < FLOOR]
    boxes = small if len(small) else boxes
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _box(pose: NDArray[np.float64], points: NDArray) -> NDArray[np.float64]:
    moved = points @ pose[:3, :3].T
    return np.array([moved.min(axis=0), moved.max(axis=0)]) + pose[:3, 3]
