"""Embree alone, as fast as it goes from Python: instances and packets of 16 from a compiled loop, nothing checked.

The yardstick of the ray engine. It writes rays into packets and leaves distance, ids and normals in them, in the frame
of each instance; nobody reads them out. It stays as it is, so that results of different days can be compared.
"""

from __future__ import annotations

import ctypes
from pathlib import Path

import embreex
import numba
import numpy as np
from numpy.typing import NDArray

from benchmarks.ray_cell import RayCell

_RAYS, _NUMBERS = 16, 22
_PACKET = _RAYS * _NUMBERS
_TRIANGLES, _INSTANCE = 0, 121
_INDEX, _VERTEX, _FLOAT3, _UINT3, _FLOAT3X4 = 0, 1, 0x9003, 0x5003, 0x9134
_DYNAMIC, _LOW_QUALITY = 1, 0

_FOLDER = Path(embreex.__file__).parent
_LIBRARY = ctypes.CDLL(str(next(_FOLDER.parent.glob("embreex.libs/libembree4*"))))
_POINTER, _UINT, _INT = ctypes.c_void_p, ctypes.c_uint, ctypes.c_int
for _name, _result, _arguments in (
    ("rtcNewDevice", _POINTER, [ctypes.c_char_p]),
    ("rtcNewScene", _POINTER, [_POINTER]),
    ("rtcNewGeometry", _POINTER, [_POINTER, _INT]),
    ("rtcSetNewGeometryBuffer", _POINTER, [_POINTER, _INT, _UINT, _INT, ctypes.c_size_t, ctypes.c_size_t]),
    ("rtcCommitGeometry", None, [_POINTER]),
    ("rtcAttachGeometry", _UINT, [_POINTER, _POINTER]),
    ("rtcReleaseGeometry", None, [_POINTER]),
    ("rtcCommitScene", None, [_POINTER]),
    ("rtcSetSceneFlags", None, [_POINTER, _INT]),
    ("rtcSetSceneBuildQuality", None, [_POINTER, _INT]),
    ("rtcSetGeometryInstancedScene", None, [_POINTER, _POINTER]),
    ("rtcSetGeometryTransform", None, [_POINTER, _UINT, _INT, _POINTER]),
    ("rtcIntersect16", None, [_POINTER, _POINTER, _POINTER, _POINTER]),
):
    _function = getattr(_LIBRARY, _name)
    _function.restype, _function.argtypes = _result, _arguments
_intersect16 = _LIBRARY.rtcIntersect16


@numba.njit(nogil=True, fastmath=True)
def _cast(scene, numbers, address, valid, directions, origin, max_range, packets):  # noqa: ANN001, ANN202
    integers = numbers.view(np.uint32)
    x, y, z = origin
    for packet in range(packets):
        start = packet * _PACKET
        for lane in range(_RAYS):
            ray, at = packet * _RAYS + lane, start + lane
            numbers[at], numbers[at + 16], numbers[at + 32], numbers[at + 48] = x, y, z, 0.0
            numbers[at + 64] = directions[ray, 0]
            numbers[at + 80] = directions[ray, 1]
            numbers[at + 96] = directions[ray, 2]
            numbers[at + 112], numbers[at + 128] = 0.0, max_range
            integers[at + 144], integers[at + 160], integers[at + 176] = 0xFFFFFFFF, ray, 0
            integers[at + 288] = integers[at + 304] = 0xFFFFFFFF
        _intersect16(valid, scene, address + start * 4, 0)


class BareEmbree:
    """Holds the native scene of a cell until the process ends."""

    def __init__(self, cell: RayCell, directions: NDArray[np.float64]) -> None:
        """Build the scene, and packets for rays along `directions` (n, 3), n a multiple of 16."""
        self._device = _LIBRARY.rtcNewDevice(b"")
        self._top = _LIBRARY.rtcNewScene(self._device)
        _LIBRARY.rtcSetSceneFlags(self._top, _DYNAMIC)
        _LIBRARY.rtcSetSceneBuildQuality(self._top, _LOW_QUALITY)
        self._instances = []
        for shape, pose in zip(cell.shapes, cell.world_t_element, strict=True):
            instance = _LIBRARY.rtcNewGeometry(self._device, _INSTANCE)
            _LIBRARY.rtcSetGeometryInstancedScene(instance, self._leaf(shape.vertices, shape.triangles))
            self._place(instance, pose)
            _LIBRARY.rtcAttachGeometry(self._top, instance)
            self._instances.append(instance)
        _LIBRARY.rtcCommitScene(self._top)
        self._directions = np.ascontiguousarray(directions, np.float32)
        self._packets = len(directions) // _RAYS
        self._numbers = _aligned(self._packets * _PACKET)
        self._valid = _aligned(_RAYS).view(np.int32)
        self._valid[:] = -1

    def move(self, poses: NDArray[np.float64], first: int) -> None:
        """Place the elements from the row `first` on anew."""
        for row in range(first, len(poses)):
            self._place(self._instances[row], poses[row])
        _LIBRARY.rtcCommitScene(self._top)

    def cast(self, origin: NDArray[np.float64], max_range: float) -> None:
        """Cast all rays from one place."""
        numbers, valid = self._numbers, self._valid
        where = (self._top, numbers, numbers.ctypes.data, valid.ctypes.data)
        _cast(*where, self._directions, tuple(origin.tolist()), max_range, self._packets)

    def distances(self) -> NDArray[np.float32]:
        """Return what the last cast found, (n,)."""
        return self._numbers.reshape(self._packets, _NUMBERS, _RAYS)[:, 8].reshape(-1).copy()

    def _leaf(self, vertices: NDArray[np.float32], triangles: NDArray[np.int32]) -> int:
        scene = _LIBRARY.rtcNewScene(self._device)
        geometry = _LIBRARY.rtcNewGeometry(self._device, _TRIANGLES)
        for slot, kind, values in ((_VERTEX, _FLOAT3, vertices), (_INDEX, _UINT3, triangles.astype(np.uint32))):
            place = _LIBRARY.rtcSetNewGeometryBuffer(geometry, slot, 0, kind, 12, len(values))
            ctypes.memmove(place, np.ascontiguousarray(values).ctypes.data, values.nbytes)
        _LIBRARY.rtcCommitGeometry(geometry)
        _LIBRARY.rtcAttachGeometry(scene, geometry)
        _LIBRARY.rtcReleaseGeometry(geometry)
        _LIBRARY.rtcCommitScene(scene)
        return scene

    def _place(self, instance: int, pose: NDArray[np.float64]) -> None:
        rows = np.ascontiguousarray(pose[:3], np.float32)
        _LIBRARY.rtcSetGeometryTransform(instance, 0, _FLOAT3X4, rows.ctypes.data)
        _LIBRARY.rtcCommitGeometry(instance)


def _aligned(numbers: int) -> NDArray[np.float32]:
    """Return float32 numbers that begin at a multiple of 64 bytes."""
    room = np.zeros(numbers * 4 + 64, np.uint8)
    start = -room.ctypes.data % 64
    return room[start : start + numbers * 4].view(np.float32)
