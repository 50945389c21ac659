"""A scene of instances that one thread poses and casts rays into."""

from __future__ import annotations

import ctypes
import functools
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from virtualrobot_sdk.compiled.cache import make_ready
from virtualrobot_sdk.embree.instances import pose_instances
from virtualrobot_sdk.embree.leaves import Leaf, leaf_of
from virtualrobot_sdk.embree.library import DYNAMIC, FAST_BUILD, INSTANCE, ROBUST, EmbreeError, library
from virtualrobot_sdk.embree.packets import trace, trace_hits, trace_shadows
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, Integers
from virtualrobot_sdk.rays import Booleans, Hits, Shape, Singles

_ARGUMENTS = np.array([[0xFFFFFFFF_00000000, 0, 0, 0, 0], [0xFFFFFFFF_00010000, 0, 0, 0, 0]], np.uint64)
"""RTCIntersectArguments for rays anywhere and for a bundle (RTC_RAY_QUERY_FLAG_COHERENT): all kinds of geometry, no
context, no filter, no callback."""


@dataclass(frozen=True, slots=True, eq=False)
class Traced:
    """First hits of n rays, on either side of a surface."""

    distance: Singles
    """(n,) along the ray (m); inf where it meets nothing within the range."""
    element: Integers
    """(n,) row of the element; -1 where it meets nothing."""
    triangle: Integers
    """(n,) row of the shape's triangles; -1 on a curved surface and where a ray meets nothing."""
    uv: Singles
    """(n, 2) weights of the triangle's second and third corner at the hit; 0 where there is no triangle."""
    normal: Singles
    """(n, 3) unit normal in the world's frame as the surface has it, not turned to the ray: where the corners go round
    counter-clockwise as seen from, and outwards of a curved surface; 0 where a ray meets nothing."""


class _Addresses(NamedTuple):
    """Addresses of the functions that compiled code calls."""

    intersect: int
    occluded: int
    set_transform: int
    commit: int


class TopScene:
    """Elements at their places, ready for rays; owned by one thread, which alone may call it.

    Shapes are prepared once for all threads of the process; what is this scene's own are instances of them. Rays are
    traced by compiled code without the GIL. A surface that a ray starts on may be met at distance 0 or not.
    """

    def __init__(self) -> None:
        """Make an empty scene; raises EmbreeError where Embree can't be had, which `unavailable` tells before."""
        embree = library()
        make_ready()
        self._library, self._functions, self._addresses = embree, embree.functions, _addresses()
        self._scene: int = embree.functions.rtcNewScene(embree.device)
        self._functions.rtcSetSceneFlags(self._scene, DYNAMIC | ROBUST)
        self._functions.rtcSetSceneBuildQuality(self._scene, FAST_BUILD)
        self._functions.rtcCommitScene(self._scene)
        embree.check("a new scene")
        self._release = weakref.finalize(self, self._functions.rtcReleaseScene, self._scene)
        self._release.atexit = False
        self._keys: list[str] = []
        self._leaves: list[Leaf] = []
        # Attached instances belong to the scene.
        self._instances = np.empty(0, np.uint64)
        self._poses = np.empty((0, 4, 4))
        self._rotations = np.empty((0, 9), np.float32)
        self._surfaces = np.empty((0, 3))

    def __enter__(self) -> TopScene:
        """Return the scene."""
        return self

    def __exit__(self, *error: object) -> None:
        """Free it."""
        self.close()

    def close(self) -> None:
        """Free the scene, and the shapes that no other scene uses; it takes no further calls but this one."""
        self._release()
        self._leaves.clear()

    def place(self, shapes: Sequence[Shape], world_t_element: Floats) -> None:
        """Have the elements `shapes` (e) at `world_t_element` (e, 4, 4), rigid transforms; e may be 0.

        Only what moved is posed anew, and only a shape whose key changed is exchanged. Raises ArgumentError, before
        anything has changed, for a shape that is none and poses of another number or not finite; EmbreeError.
        """
        self._check_open()
        poses = np.ascontiguousarray(world_t_element, np.float64)
        if poses.shape != (len(shapes), 4, 4):
            raise ArgumentError(
                f"the poses of {len(shapes)} elements have shape {poses.shape}; it must be ({len(shapes)}, 4, 4)"
            )
        if not np.isfinite(poses).all():
            i = int(np.flatnonzero(~np.isfinite(poses).all(axis=(1, 2)))[0])
            raise ArgumentError(f"the pose of element {i} is {poses[i].tolist()}; it must be finite", element=i)
        keys = [shape.key for shape in shapes]
        is_new = np.zeros(len(keys), np.bool_)
        is_changed = keys != self._keys
        try:
            if is_changed:
                self._exchange(shapes, keys, is_new)
            moved = pose_instances(
                *(self._addresses.set_transform, self._addresses.commit, self._instances, is_new, poses),
                *(self._poses, self._rotations),
            )
            if is_changed or moved:
                self._functions.rtcCommitScene(self._scene)
            self._library.check(f"a scene of {len(keys)} elements")
        except EmbreeError:
            self.close()  # half of it may be done
            raise

    def cast(self, origins: ArrayLike, directions: ArrayLike, max_range: float = np.inf) -> Traced:
        """Return what n rays first meet within `max_range` (m).

        Args:
            origins: (n, 3), or (1, 3) for all rays, in meters in the world.
            directions: (n, 3) unit vectors in the world. Rays are not checked; one that is not finite meets nothing.
            max_range: above 0, may be inf.

        Raises ArgumentError for arrays of other shapes.
        """
        self._check_open()
        starts, along = _rays(origins, directions)
        n = len(along)
        traced = Traced(
            *(np.empty(n, np.float32), np.empty(n, np.int32), np.empty(n, np.int32)),
            *(np.empty((n, 2), np.float32), np.empty((n, 3), np.float32)),
        )
        trace(
            *(self._addresses.intersect, self._scene, _ARGUMENTS.ctypes.data, starts, along, float(max_range)),
            *(self._rotations, self._poses, self._surfaces),
            *(traced.distance, traced.element, traced.triangle, traced.uv, traced.normal),
        )
        return traced

    def hits(self, origins: Floats, directions: Floats, max_range: float = np.inf) -> Hits:
        """Return what `cast` does as a ray caster answers: in double precision, normals turned to the rays' origins.

        Rays are float64; curved surfaces are met in double precision, triangles in single. Raises ArgumentError for
        arrays of other shapes.
        """
        self._check_open()
        starts, along = _rays(origins, directions, np.float64)
        n = len(along)
        triangle = np.empty(n, np.int32)
        hits = Hits(np.empty(n), np.empty(n, np.int32), np.empty((n, 3)), triangle)
        trace_hits(
            *(self._addresses.intersect, self._scene, _ARGUMENTS.ctypes.data, starts, along, float(max_range)),
            *(self._rotations, self._poses, self._surfaces),
            *(hits.distance, hits.element, triangle, hits.normal),
        )
        return hits

    def occluded(self, origins: ArrayLike, directions: ArrayLike, distances: ArrayLike) -> Booleans:
        """Return (n,) whether each ray meets anything nearer than its own `distances` (n,) in meters, which may be inf.

        For the rays see `cast`. Raises ArgumentError for arrays of other shapes.
        """
        self._check_open()
        starts, along = _rays(origins, directions)
        ends = np.ascontiguousarray(distances, np.float32)
        if ends.shape != (len(along),):
            raise ArgumentError(f"{len(along)} rays have distances of shape {ends.shape}; it must be ({len(along)},)")
        is_occluded = np.empty(len(along), np.bool_)
        trace_shadows(
            *(self._addresses.occluded, self._scene, _ARGUMENTS.ctypes.data, starts, along, ends), is_occluded
        )
        return is_occluded

    def _check_open(self) -> None:
        if not self._release.alive:
            raise EmbreeError("the scene is closed")

    def _exchange(self, shapes: Sequence[Shape], keys: list[str], is_new: Booleans) -> None:
        """Make, exchange and remove instances, and mark those without a pose; all shapes are prepared before."""
        functions, before = self._functions, self._keys
        leaves = [
            self._leaves[i] if i < len(before) and before[i] == keys[i] else leaf_of(shape)
            for i, shape in enumerate(shapes)
        ]
        instances = np.zeros(len(keys), np.uint64)
        kept = min(len(keys), len(before))
        instances[:kept] = self._instances[:kept]
        for i in range(len(keys), len(before)):
            functions.rtcDetachGeometry(self._scene, i)
        for i, leaf in enumerate(leaves):
            if i >= kept:
                instance = functions.rtcNewGeometry(self._library.device, INSTANCE)
                functions.rtcSetGeometryInstancedScene(instance, leaf.scene)
                functions.rtcAttachGeometryByID(self._scene, instance, i)
                functions.rtcReleaseGeometry(instance)
                instances[i] = instance
            elif leaf is not self._leaves[i]:
                functions.rtcSetGeometryInstancedScene(int(instances[i]), leaf.scene)
            else:
                continue
            is_new[i] = True
        poses, rotations = np.empty((len(keys), 4, 4)), np.empty((len(keys), 9), np.float32)
        poses[:kept], rotations[:kept] = self._poses[:kept], self._rotations[:kept]
        self._keys, self._leaves, self._instances, self._poses, self._rotations = (
            keys,
            leaves,
            instances,
            poses,
            rotations,
        )
        self._surfaces = np.array([leaf.surface for leaf in leaves]).reshape(-1, 3)


@functools.cache
def _addresses() -> _Addresses:
    functions = library().functions
    names = "rtcIntersect16", "rtcOccluded16", "rtcSetGeometryTransform", "rtcCommitGeometry"
    return _Addresses(*(ctypes.cast(getattr(functions, name), ctypes.c_void_p).value or 0 for name in names))


def _rays(origins: ArrayLike, directions: ArrayLike, dtype: type = np.float32) -> tuple[np.ndarray, np.ndarray]:
    """Return both contiguous; raises ArgumentError for other shapes than (n, 3) or (1, 3), and (n, 3)."""
    starts, along = np.ascontiguousarray(origins, dtype), np.ascontiguousarray(directions, dtype)
    if along.ndim != 2 or along.shape[1] != 3:
        raise ArgumentError(f"directions have shape {along.shape}; it must be (n, 3)", shape=along.shape)
    if starts.shape not in ((len(along), 3), (1, 3)):
        n = len(along)
        raise ArgumentError(f"origins have shape {starts.shape}; it must be ({n}, 3) or (1, 3)", shape=starts.shape)
    return starts, along
