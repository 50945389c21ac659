"""Points that a sensor sees: in a camera's picture, or by a beam of a range sensor, with nothing before them."""

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
from virtualrobot_kernel.sensing.patterns import beams_of
from virtualrobot_kernel.sensing.settings import DEFAULT_RAY_CASTER, Presets, RangeSettings, range_settings
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.sensing import CameraSensor, Projection, RangeSensor
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node

Floats = NDArray[np.float64]

_BEFORE = 1e-4
"""Of a meter and of the distance: what is met by so little before a point is its own surface, in single precision."""


_AT_ONCE = 2_000_000
"""Number of distances between points and beams that are computed together."""


class Sight:
    """Owns a ray caster; used by one thread at a time."""

    def __init__(self, catalog: Catalog, shapes: ShapeLibrary, presets: Presets) -> None:
        """Take components, shapes and the range sensors that can be bought from these."""
        self._catalog, self._shapes, self._presets = catalog, shapes, presets
        self._caster: ComponentHandle | None = None
        self._elements: dict[int, Elements] = {}

    def seen(self, snapshot: Snapshot, sensor: Node, points: Floats, within: float) -> NDArray[np.bool_]:
        """Return which of points (n, 3), m in the world, a sensor sees: (n,).

        A camera sees what is in its picture; a range sensor, between its least and greatest range, what one of its
        beams passes within so many meters. Each looks with the usual ray caster, whatever the sensor has.

        Raises:
            KernelError: when it is neither a pinhole camera without distortion nor a range sensor.
        """
        world_t_sensor, data = snapshot.world_t(sensor.uid), sensor.data
        local = (points - world_t_sensor[:3, 3]) @ world_t_sensor[:3, :3]
        if isinstance(data, RangeSensor):
            seen, starts = _passed(range_settings(data, self._presets), local, within)
        elif isinstance(data, CameraSensor) and data.projection is Projection.PINHOLE and not any(data.distortion):
            seen, starts = _in_picture(data, local), np.zeros_like(local)
        else:
            raise KernelError(
                f"{sensor.name!r} is no camera_sensor that is a pinhole without distortion, and no range_sensor"
            )
        asked = np.flatnonzero(seen)
        if not len(asked):
            return seen
        origins = starts[asked] @ world_t_sensor[:3, :3].T + world_t_sensor[:3, 3]
        offsets = points[asked] - origins
        distances = np.linalg.norm(offsets, axis=1)
        # Where a point is at the sensor itself, nothing is before it, whichever way it looks.
        directions = np.where(distances[:, None] > 0.0, offsets, 1.0)
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        elements = elements_of(snapshot, self._shapes, self._elements.get(sensor.uid), frozenset({sensor.uid}))
        self._elements[sensor.uid] = elements
        if self._caster is None:
            self._caster = start(self._catalog.find(ComponentKind.RAY_CASTER, DEFAULT_RAY_CASTER), {})
        scene, most = elements.scene(snapshot.world_t_node), max(float(distances.max()), _BEFORE)
        hits = cast_rays(self._caster, scene, origins, directions, most, lambda _: True).hits
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


def _passed(settings: RangeSettings, points: Floats, within: float) -> tuple[NDArray[np.bool_], Floats]:
    """Return which of points (n, 3) of the sensor's frame a beam passes, and where the nearest beam of each begins."""
    beams = beams_of(settings.pattern)
    starts, ways = beams.origins, beams.directions
    begun = np.einsum("ij,ij->i", np.broadcast_to(starts, ways.shape), ways)
    rows = max(1, _AT_ONCE // len(ways))
    seen, found = np.zeros(len(points), np.bool_), np.zeros_like(points)
    for first in range(0, len(points), rows):
        some = points[first : first + rows]
        along = some @ ways.T - begun
        square = (some**2).sum(axis=1)[:, None] - 2.0 * some @ starts.T + (starts**2).sum(axis=1)
        off = np.where(along >= 0.0, square - along**2, np.inf)
        nearest = off.argmin(axis=1)
        found[first : first + rows] = starts[nearest if len(starts) > 1 else np.zeros_like(nearest)]
        at = np.linalg.norm(some - found[first : first + rows], axis=1)
        in_range = (at >= settings.min_range_meters) & (at <= settings.max_range_meters)
        seen[first : first + rows] = in_range & (off.min(axis=1) <= within**2)
    return seen, found
