"""Objects of a planning scene: what MoveIt's programs publish on `/collision_object` stands in the world, and goes."""

from __future__ import annotations

import struct
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.scene.figures import Figure

from virtualrobot_apps.bridges.ros.frames import world_t_frame
from virtualrobot_apps.bridges.ros.hub import Refused
from virtualrobot_apps.bridges.ros.in_order import InOrder
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, matrix_of

COLLISION_OBJECT, OBJECTS = "moveit_msgs/msg/CollisionObject", "/collision_object"

ADD, REMOVE, APPEND, MOVE = range(4)
"""Operations; source: moveit_msgs/CollisionObject."""

_BOX, _SPHERE, _CYLINDER, _CONE = range(1, 5)
_DIMENSIONS = {_BOX: 3, _SPHERE: 1, _CYLINDER: 2, _CONE: 2}
"""Kinds of `shape_msgs/SolidPrimitive` and how many dimensions each has: a height comes before a radius."""


class PlanningScene:
    """Objects that a world hears of; they are put there in the order in which they come, by a thread."""

    def __init__(self, client: Client, say: Callable[[str], None], *, bare: bool = False) -> None:
        """Hear of none yet; `bare` as in FrameNames."""
        self._client, self._say, self._bare = client, say, bare
        self._objects = InOrder("objects", self._work)

    def take(self, value: RosValue, refused: Refused) -> None:
        """Take a `moveit_msgs/CollisionObject`; returns at once. What is refused is said, also to `refused`.

        Raises:
            ValueError: when too many wait.
        """
        self._objects.put((value, refused))

    def _work(self, told: tuple[RosValue, Refused]) -> None:
        value, refused = told
        try:
            self._apply(value)
        except (VirtualRobotError, ValueError) as error:
            self._say(f"{OBJECTS}: {value.id[:80]!r} is not taken: {error}")
            refused(f"{value.id[:80]!r}: {error}")

    def _apply(self, value: RosValue) -> None:
        scene, name = self._client.scene, value.id
        if value.operation not in (ADD, REMOVE, APPEND, MOVE):
            raise ValueError(f"'operation' is 0 (add), 1 (remove), 2 (append) or 3 (move), not {value.operation}")
        objects = [one.name for one in scene.nodes("object")]
        if value.operation == REMOVE and not name:
            raise ValueError("'id' names the object that is removed")
        if value.operation != ADD and name not in objects:
            raise ValueError(f"there is no object {name!r}; known: {', '.join(objects) or 'none'}")
        if value.operation == REMOVE:
            return scene.remove(name)
        pose = world_t_frame(self._client, value.header.frame_id, bare=self._bare) @ matrix_of(value.pose)
        if value.operation == MOVE:
            return scene.node(name).attach("world", pose)
        figures = _figures(value)
        if value.operation == APPEND:
            scene.set_figures(name, [*scene.node(name).figures, *figures])
        else:
            with scene.batch() as batch:
                if name in objects:
                    batch.remove(name)
                batch.add_object(name, figures, pose=pose)
        for mesh, at in zip(value.meshes, value.mesh_poses, strict=True):
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "mesh.stl"
                file.write_bytes(_stl(mesh))
                scene.load(file, parent=name, pose=matrix_of(at, "mesh_poses"))


def _figures(value: RosValue) -> list[Figure]:
    """Return the primitives of an object as figures; planes, which have no end, are refused."""
    if len(value.planes):
        raise ValueError("'planes' have no end, and objects here have one: a box is as good")
    if len(value.primitives) != len(value.primitive_poses) or len(value.meshes) != len(value.mesh_poses):
        raise ValueError("each primitive and each mesh has a pose")
    return [
        _figure(one.type, [float(size) for size in one.dimensions], matrix_of(at, "primitive_poses"))
        for one, at in zip(value.primitives, value.primitive_poses, strict=True)
    ]


def _figure(kind: int, sizes: list[float], pose: NDArray[np.float64]) -> Figure:
    if kind not in _DIMENSIONS:
        raise ValueError(f"a primitive is 1 (box), 2 (sphere), 3 (cylinder) or 4 (cone), not {kind}")
    if len(sizes) != _DIMENSIONS[kind]:
        raise ValueError(f"a primitive of type {kind} has {_DIMENSIONS[kind]} dimensions, not {len(sizes)}")
    if kind == _BOX:
        return virtualrobot.box(*sizes, pose=pose)
    if kind == _SPHERE:
        return virtualrobot.sphere(*sizes, pose=pose)
    height, radius = sizes
    return (virtualrobot.cylinder if kind == _CYLINDER else virtualrobot.cone)(radius, height, pose=pose)


def _stl(mesh: RosValue) -> bytes:
    """Return a `shape_msgs/Mesh` as a file in binary STL; normals are left to readers."""
    vertices = np.array([[one.x, one.y, one.z] for one in mesh.vertices], float).reshape(-1, 3)
    corners = np.array([one.vertex_indices for one in mesh.triangles], np.int64).reshape(-1, 3)
    if not len(corners) or corners.max() >= len(vertices) or not np.isfinite(vertices).all():
        raise ValueError("a mesh has triangles of its own vertices, which are finite")
    return b"\0" * 80 + struct.pack("<I", len(corners)) + b"".join(_triangles(vertices[corners]))


def _triangles(corners: NDArray[np.float64]) -> Iterable[bytes]:
    for triangle in corners.astype("<f4"):
        yield b"\0" * 12 + triangle.tobytes() + b"\0\0"
