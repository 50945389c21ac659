"""Points that a camera sees: those in its picture, between its nearest and farthest depth, with nothing before them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.registration import ComponentKind

from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.running import ComponentHandle, start
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.sensing.casting import cast_rays
from virtualrobot_kernel.sensing.elements import Elements, elements_of
from virtualrobot_kernel.sensing.lenses import lens_of
from virtualrobot_kernel.sensing.settings import DEFAULT_RAY_CASTER
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.sensing import CameraSensor, Projection
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node

Floats = NDArray[np.float64]

_BEFORE = 1e-4
"""Of a meter and of the distance: what is met by so little before a point is its own surface, in single precision."""


class Sight:
    """Owns a ray caster; used by one thread at a time."""

    def __init__(self, catalog: Catalog, shapes: ShapeLibrary) -> None:
        """Take components and shapes from these."""
        self._catalog, self._shapes = catalog, shapes
        self._caster: ComponentHandle | None = None
        self._elements: dict[int, Elements] = {}

    def seen(self, snapshot: Snapshot, camera: Node, points: Floats) -> NDArray[np.bool_]:
        """Return which of points (n, 3), m in the world, a camera sees: (n,).

        Raises:
            KernelError: when it is no pinhole camera without distortion.
        """
        data = camera.data
        if not (isinstance(data, CameraSensor) and data.projection is Projection.PINHOLE and not any(data.distortion)):
            raise KernelError(f"{camera.name!r} is no camera_sensor that is a pinhole without distortion")
        world_t_camera = snapshot.world_t(camera.uid)
        offsets = points - world_t_camera[:3, 3]
        seen = _in_picture(data, offsets @ world_t_camera[:3, :3])
        asked = np.flatnonzero(seen)
        if not len(asked):
            return seen
        distances = np.linalg.norm(offsets[asked], axis=1)
        directions = offsets[asked] / distances[:, None]
        elements = elements_of(snapshot, self._shapes, self._elements.get(camera.uid), frozenset({camera.uid}))
        self._elements[camera.uid] = elements
        if self._caster is None:
            self._caster = start(self._catalog.find(ComponentKind.RAY_CASTER, DEFAULT_RAY_CASTER), {})
        scene, origin = elements.scene(snapshot.world_t_node), world_t_camera[None, :3, 3]
        hits = cast_rays(self._caster, scene, origin, directions, float(distances.max()), lambda _: True).hits
        seen[asked] = hits.distance >= distances - _BEFORE * (1.0 + distances)
        return seen

    def close(self) -> None:
        """End the caster, if there is one."""
        if self._caster is not None:
            self._caster.close()


def _in_picture(camera: CameraSensor, points: Floats) -> NDArray[np.bool_]:
    """Return which of points (n, 3) of the camera's frame, z forward, are in its picture and range.

    A pixel's area reaches half a pixel to each side of its middle.
    """
    lens = lens_of(camera)
    depths = points[:, 2]
    is_ahead = (depths >= lens.near) & (depths <= lens.far)
    ahead = np.where(is_ahead, depths, 1.0)
    at = lens.intrinsics
    column, row = at.fx * points[:, 0] / ahead + at.cx, at.fy * points[:, 1] / ahead + at.cy
    across = (column >= -0.5) & (column <= lens.width - 0.5)
    return is_ahead & across & (row >= -0.5) & (row <= lens.height - 0.5)
