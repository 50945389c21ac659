"""The ray caster `embree`: fast, without the GIL, and exact on curved surfaces."""

from __future__ import annotations

import logging

import numpy as np
from virtualrobot_sdk.compiled.cache import make_ready
from virtualrobot_sdk.embree import TopScene, unavailable
from virtualrobot_sdk.embree.packets import are_rays
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.ray_checks import check_rays
from virtualrobot_sdk.rays import Hits, RayScene

from virtualrobot_plugins.ray_casters.embreex_scene import EmbreexScene

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
        self._known: tuple[Floats, ...] = ()
        """Rays that were looked at before and cannot have changed since: arrays of their own that nobody may write."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        """Return the first hits, as `RayCaster` says."""
        starts, along = np.ascontiguousarray(origins, np.float64), np.ascontiguousarray(directions, np.float64)
        is_right = starts.shape == along.shape and along.ndim == 2 and along.shape[1] == 3 and max_range > 0.0
        is_known = is_right and self._known and starts is self._known[0] and along is self._known[1]
        if not is_known:
            if not is_right or not are_rays(starts, along):
                check_rays(scene, origins, directions, max_range)
            is_kept = all(array.base is None and not array.flags.writeable for array in (starts, along))
            self._known = (starts, along) if is_kept else ()
        self._scene.place(scene.shapes, scene.world_t_element)
        return self._scene.hits(starts, along, max_range)


def _instead(reason: str) -> EmbreexScene:
    """Return what takes the engine's place, and tell the log why."""
    try:
        scene = EmbreexScene()
    except ImportError as error:
        raise ArgumentError(f"Embree casts no rays: {reason}; and there is no embreex either: {error}") from error
    log.warning(
        "the library Embree can't be driven (%s): the interface of embreex casts rays instead, slower and with curved "
        "surfaces as triangles",
        reason,
    )
    return scene
