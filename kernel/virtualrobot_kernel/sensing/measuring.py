"""Distances between points that move with nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.state import Snapshot

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class NodePoint:
    """A point that moves with a node: the node's uid, and meters in its frame."""

    uid: int
    point: Vector


@dataclass(frozen=True, slots=True)
class Measurement:
    """A distance that is shown; the name is unique within the view."""

    name: str
    first: NodePoint
    second: NodePoint


def is_there(snapshot: Snapshot, measurement: Measurement) -> bool:
    """Return whether both nodes of a measurement are in the world."""
    nodes = snapshot.structure.nodes
    return measurement.first.uid in nodes and measurement.second.uid in nodes


def world_point(snapshot: Snapshot, place: NodePoint) -> NDArray[np.float64]:
    """Return where a point is in the world's frame (3,), meters; raise KernelError when its node was removed."""
    row = snapshot.structure.rows.get(place.uid)
    if row is None:
        raise KernelError(
            "the node of a measured point has been removed; measure from another one",
            reason=Reason.UNKNOWN_NAME,
            uid=place.uid,
        )
    world_t_node = snapshot.world_t_node[row]
    return world_t_node[:3, :3] @ np.array(place.point) + world_t_node[:3, 3]


def ends(snapshot: Snapshot, first: NodePoint, second: NodePoint) -> NDArray[np.float64]:
    """Return both points in the world's frame (2, 3), meters; raise KernelError when a node was removed."""
    return np.stack([world_point(snapshot, first), world_point(snapshot, second)])


def length(points: NDArray[np.float64]) -> float:
    """Return the distance in meters between two points (2, 3)."""
    return float(np.linalg.norm(points[1] - points[0]))
