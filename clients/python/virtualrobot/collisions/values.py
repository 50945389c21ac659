"""Two nodes that touch, as values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.showing import shown
from virtualrobot.v1 import collision_pb2, geometry_pb2


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Collision:
    """Two nodes that touch and may not.

    Attributes:
        first: the name of a node, and `second` that of another one.
        points: (k, 3) points of contact in the world's frame (m); none where only pairs were asked for.
        normals: (k, 3) unit normals there, from the first to the second.
        depth: least distance (m) by which one must be moved until they only touch; None where only pairs
            were asked for.
        depth_approximate: true where it is not exact: a mesh that isn't convex counted as its convex hull, or several
            figures of the nodes touch.
    """

    first: str
    second: str
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    depth: float | None
    depth_approximate: bool

    @property
    def _brief(self) -> str:
        """Return it in a few words, among others."""
        return f"{self.first!r} touches {self.second!r}"


def collision_of(pair: collision_pb2.CollisionPair) -> Collision:
    """Return two nodes that touch from a message."""
    return Collision(
        pair.first,
        pair.second,
        np.array([point_of(contact.point) for contact in pair.contacts]).reshape(-1, 3),
        np.array([point_of(contact.normal) for contact in pair.contacts]).reshape(-1, 3),
        pair.depth_meters if pair.HasField("depth_meters") else None,
        pair.depth_approximate,
    )


def where(collision: Collision) -> str:
    """Return where and how deep two nodes touch in words, as far as it is told."""
    at = f" at {', '.join(f'{value:z.3f}' for value in collision.points[0])}" if len(collision.points) else ""
    if collision.depth is None:
        return at
    return f"{at}, {'about ' if collision.depth_approximate else ''}{1e3 * collision.depth:.1f} mm deep"


def point_of(vector: geometry_pb2.Vector3) -> tuple[float, float, float]:
    """Return a vector's x, y and z."""
    return vector.x, vector.y, vector.z
