"""The ray caster `embree`: fast, without the GIL, and exact on curved surfaces."""

from __future__ import annotations

import logging
import math
from typing import Any

import numpy as np
from numba import float32, float64
from virtualrobot_sdk.compiled.cache import array_of, compiled, make_ready, output_of
from virtualrobot_sdk.embree import TopScene, unavailable
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.ray_checks import UNIT, check_rays
from virtualrobot_sdk.rays import Hits, RayScene

from virtualrobot_plugins.ray_casters.embreex_scene import EmbreexScene

Array = np.ndarray[Any, np.dtype[Any]]
log = logging.getLogger("virtualrobot_plugins.rays")


class EmbreeCaster:
    """Embree in packets of 16 rays, without the GIL, in single precision; curved surfaces are met as they are meant.

    Where its library can't be driven, the interface of the package embreex takes its place: slower, and curved surfaces
    are met by their triangles; the log says so.
    """

    def __init__(self) -> None:
        """Make an empty scene; raises ArgumentError where there is neither Embree nor embreex."""
        make_ready()
        reason = unavailable()
        self._scene = _instead(reason) if reason else TopScene()

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        """Return the first hits, as `RayCaster` says."""
        n = len(directions) if directions.ndim == 2 else 0
        starts, along = np.ascontiguousarray(origins, np.float64), np.ascontiguousarray(directions, np.float64)
        singles = np.empty((2, n, 3), np.float32)
        is_right = starts.shape == along.shape == (n, 3) and max_range > 0.0
        if not is_right or not _to_singles(starts, along, singles):
            check_rays(scene, origins, directions, max_range)
        self._scene.place(scene.shapes, scene.world_t_element)
        found = self._scene.cast(singles[0], singles[1], max_range)
        distance, normal = np.empty(n), np.empty((n, 3))
        _to_hits(along, found.distance, found.normal, distance, normal)
        return Hits(distance, found.element, normal, found.triangle)


def _instead(reason: str) -> EmbreexScene:
    """Return what takes the engine's place, and tell the log why."""
    try:
        scene = EmbreexScene()
    except ImportError as error:
        raise ArgumentError(
            f"rays can't be cast by Embree: {reason}; and embreex is not to be had ({error})"
        ) from error
    log.warning(
        "the library Embree can't be driven (%s): the interface of embreex casts rays instead, slower and with curved "
        "surfaces as triangles",
        reason,
    )
    return scene


@compiled(array_of(float64, 2), array_of(float64, 2), output_of(float32, 3))
def _to_singles(origins: Array, directions: Array, singles: Array) -> bool:
    """Write origins and directions (n, 3) to `singles` (2, n, 3); return whether all are finite and of unit length."""
    are_rays = True
    for i in range(len(directions)):
        squared = 0.0
        total = 0.0
        for axis in range(3):
            squared += directions[i, axis] * directions[i, axis]
            total += origins[i, axis]
            singles[0, i, axis] = origins[i, axis]
            singles[1, i, axis] = directions[i, axis]
        # Half of the error of the square is that of the length; one that is not finite compares as false.
        if not (abs(squared - 1.0) <= 2.0 * UNIT and math.isfinite(total)):
            are_rays = False
    return are_rays


@compiled(
    array_of(float64, 2), array_of(float32, 1), array_of(float32, 2), output_of(float64, 1), output_of(float64, 2)
)
def _to_hits(directions: Array, distance: Array, normal: Array, distances: Array, normals: Array) -> None:
    """Write distances (n,) and unit normals (n, 3), turned to the rays' origins, in double precision."""
    for i in range(len(directions)):
        distances[i] = distance[i]
        squared = 0.0
        slope = 0.0
        for axis in range(3):
            value = np.float64(normal[i, axis])
            squared += value * value
            slope += value * directions[i, axis]
        factor = 1.0 / math.sqrt(squared) if squared > 0.0 else 0.0
        if slope > 0.0:
            factor = -factor
        for axis in range(3):
            normals[i, axis] = factor * normal[i, axis]
