"""Leaf scenes: what Embree prepares of a shape, once for all threads, for as long as anybody uses it."""

from __future__ import annotations

import ctypes
import threading
import weakref
from concurrent.futures import Future

import numpy as np

from virtualrobot_sdk.embree.curved import bound, intersect, occlude
from virtualrobot_sdk.embree.library import (
    CURVED,
    FLOAT3,
    GOOD_BUILD,
    INDICES,
    ROBUST,
    TRIANGLES,
    UINT3,
    VERTICES,
    Library,
    library,
)
from virtualrobot_sdk.embree.quadrics import surface_of
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.rays import Round, Shape

_lock = threading.Lock()
_leaves: weakref.WeakValueDictionary[str, Leaf] = weakref.WeakValueDictionary()
_in_the_making: dict[str, Future[Leaf]] = {}


class Leaf:
    """The committed scene of one shape; immutable. It is released when nobody keeps the object."""

    __slots__ = ("__weakref__", "_numbers", "scene", "surface")

    def __init__(self, shape: Shape) -> None:
        """Build the scene; raises ArgumentError when the shape is none, and EmbreeError."""
        _check(shape)
        self.surface = surface_of(shape.primitive)
        # Embree keeps its address.
        self._numbers = np.array(self.surface)
        embree = library()
        functions = embree.functions
        self.scene: int = functions.rtcNewScene(embree.device)
        weakref.finalize(self, functions.rtcReleaseScene, self.scene).atexit = False
        functions.rtcSetSceneFlags(self.scene, ROBUST)
        functions.rtcSetSceneBuildQuality(self.scene, GOOD_BUILD)
        if shape.primitive is not None or len(shape.triangles):
            geometry = _triangles(embree, shape) if shape.primitive is None else _curved(embree, self._numbers)
            functions.rtcCommitGeometry(geometry)
            functions.rtcAttachGeometryByID(self.scene, geometry, 0)
            functions.rtcReleaseGeometry(geometry)
        functions.rtcCommitScene(self.scene)
        embree.check(
            f"a shape of {len(shape.triangles)} triangles" if shape.primitive is None else f"{shape.primitive}"
        )


def leaf_of(shape: Shape) -> Leaf:
    """Return the leaf of a shape: the one that is there for its key, or a new one.

    Threads that ask at the same time for what is not there wait for the first of them. Raises as `Leaf` does.
    """
    with _lock:
        leaf = _leaves.get(shape.key)
        if leaf is not None:
            return leaf
        making = _in_the_making.get(shape.key)
        is_first = making is None
        if making is None:
            making = _in_the_making[shape.key] = Future()
    if not is_first:
        return making.result()
    try:
        leaf = Leaf(shape)
    except BaseException as error:
        with _lock:
            del _in_the_making[shape.key]
        making.set_exception(error)
        raise
    with _lock:
        _leaves[shape.key] = leaf
        del _in_the_making[shape.key]
    making.set_result(leaf)
    return leaf


def leaves_in_use() -> int:
    """Return how many leaves there are in this process."""
    with _lock:
        return len(_leaves)


def _triangles(embree: Library, shape: Shape) -> int:
    """Return a geometry with copies of the triangles: Embree reads past the end of a buffer that it does not own."""
    functions = embree.functions
    geometry = functions.rtcNewGeometry(embree.device, TRIANGLES)
    for kind, layout, rows in (
        (VERTICES, FLOAT3, np.ascontiguousarray(shape.vertices, np.float32)),
        (INDICES, UINT3, np.ascontiguousarray(shape.triangles, np.int32)),
    ):
        room = functions.rtcSetNewGeometryBuffer(geometry, kind, 0, layout, 12, len(rows))
        if not room:
            functions.rtcReleaseGeometry(geometry)
            embree.check(f"a shape of {len(shape.triangles)} triangles and {len(shape.vertices)} vertices")
        ctypes.memmove(room, rows.ctypes.data, rows.nbytes)
    return geometry


def _curved(embree: Library, numbers: np.ndarray) -> int:
    """Return a geometry of one curved surface, as `surface_of` has it."""
    functions = embree.functions
    geometry = functions.rtcNewGeometry(embree.device, CURVED)
    functions.rtcSetGeometryUserPrimitiveCount(geometry, 1)
    functions.rtcSetGeometryUserData(geometry, numbers.ctypes.data)
    functions.rtcSetGeometryBoundsFunction(geometry, bound.address, None)
    functions.rtcSetGeometryIntersectFunction(geometry, intersect.address)
    functions.rtcSetGeometryOccludedFunction(geometry, occlude.address)
    return geometry


def _check(shape: Shape) -> None:
    """Raise ArgumentError for sizes that are none, and for arrays that Embree would read wrongly or past their ends."""
    curved = shape.primitive
    if curved is not None:
        least = 0.0 if curved.kind in (Round.SPHERE, Round.CAPSULE) else np.nextafter(0.0, 1.0)
        if not (0.0 < curved.radius < np.inf and least <= curved.length < np.inf):
            raise ArgumentError(
                f"a {curved.kind.value} has radius {curved.radius} and length {curved.length}; both must be finite "
                "and above 0",
                radius=curved.radius,
                length=curved.length,
            )
        return
    vertices, triangles = shape.vertices, shape.triangles
    for name, array in (("vertices", vertices), ("triangles", triangles)):
        if array.ndim != 2 or array.shape[1] != 3:
            raise ArgumentError(f"the {name} of a shape have shape {array.shape}; it must be (m, 3)", shape=array.shape)
    if not np.isfinite(vertices).all():
        row = int(np.flatnonzero(~np.isfinite(vertices).all(axis=1))[0])
        raise ArgumentError(f"vertex {row} of a shape is {vertices[row].tolist()}; it must be finite", vertex=row)
    if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(vertices):
        row = int(np.flatnonzero(((triangles < 0) | (triangles >= len(vertices))).any(axis=1))[0])
        raise ArgumentError(
            f"triangle {row} of a shape has the corners {triangles[row].tolist()}; its vertices are 0 to "
            f"{len(vertices) - 1}",
            triangle=row,
        )
