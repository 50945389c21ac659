"""The library Embree 4 (www.embree.org): where it is found, what of it is called, and what its errors mean.

Only plain functions of its C interface are used, so that nothing has to be compiled against it; names and numbers are
those of its headers rtcore_*.h.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import functools
import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

TRIANGLES, CURVED, INSTANCE = 0, 120, 121
"""RTC_GEOMETRY_TYPE_TRIANGLE, _USER and _INSTANCE."""
INDICES, VERTICES = 0, 1
"""RTC_BUFFER_TYPE_INDEX and _VERTEX."""
UINT3, FLOAT3, FLOAT3X4 = 0x5003, 0x9003, 0x9134
"""RTC_FORMAT_UINT3, _FLOAT3 and _FLOAT3X4_ROW_MAJOR."""
DYNAMIC, ROBUST = 1, 4
"""RTC_SCENE_FLAG_DYNAMIC and _ROBUST."""
FAST_BUILD, GOOD_BUILD = 0, 1
"""RTC_BUILD_QUALITY_LOW and _MEDIUM."""
_SETTINGS = b"threads=1"
"""A scene is built by the thread that asks for it: the tick and the API keep the other cores."""
_VERSION_MAJOR = 1
"""RTC_DEVICE_PROPERTY_VERSION_MAJOR."""

_POINTER, _NUMBER, _SIZE = ctypes.c_void_p, ctypes.c_uint, ctypes.c_size_t
_FUNCTIONS: dict[str, tuple[type | None, tuple[type, ...]]] = {
    "rtcAttachGeometryByID": (None, (_POINTER, _POINTER, _NUMBER)),
    "rtcCommitGeometry": (None, (_POINTER,)),
    "rtcCommitScene": (None, (_POINTER,)),
    "rtcDetachGeometry": (None, (_POINTER, _NUMBER)),
    "rtcGetDeviceError": (ctypes.c_int, (_POINTER,)),
    "rtcGetDeviceProperty": (ctypes.c_ssize_t, (_POINTER, ctypes.c_int)),
    "rtcIntersect16": (None, (_POINTER, _POINTER, _POINTER, _POINTER)),
    "rtcNewDevice": (_POINTER, (ctypes.c_char_p,)),
    "rtcNewGeometry": (_POINTER, (_POINTER, ctypes.c_int)),
    "rtcNewScene": (_POINTER, (_POINTER,)),
    "rtcOccluded16": (None, (_POINTER, _POINTER, _POINTER, _POINTER)),
    "rtcReleaseGeometry": (None, (_POINTER,)),
    "rtcReleaseScene": (None, (_POINTER,)),
    "rtcSetGeometryBoundsFunction": (None, (_POINTER, _POINTER, _POINTER)),
    "rtcSetGeometryInstancedScene": (None, (_POINTER, _POINTER)),
    "rtcSetGeometryIntersectFunction": (None, (_POINTER, _POINTER)),
    "rtcSetGeometryOccludedFunction": (None, (_POINTER, _POINTER)),
    "rtcSetGeometryTransform": (None, (_POINTER, _NUMBER, ctypes.c_int, _POINTER)),
    "rtcSetGeometryUserData": (None, (_POINTER, _POINTER)),
    "rtcSetGeometryUserPrimitiveCount": (None, (_POINTER, _NUMBER)),
    "rtcSetNewGeometryBuffer": (_POINTER, (_POINTER, ctypes.c_int, _NUMBER, ctypes.c_int, _SIZE, _SIZE)),
    "rtcSetSceneBuildQuality": (None, (_POINTER, ctypes.c_int)),
    "rtcSetSceneFlags": (None, (_POINTER, ctypes.c_int)),
}
_ERRORS = {
    2: "an argument is invalid",
    3: "the operation is invalid now",
    4: "there is not enough memory",
    5: "this processor is not supported: it needs SSE2 or NEON",
    6: "it was cancelled",
}


class EmbreeError(RuntimeError):
    """Embree could not be loaded, or did not do what it was asked for; the message says why."""


class Library(NamedTuple):
    """Embree, loaded; it stays for as long as the process runs.

    Attributes:
        functions: its functions, with the types of their arguments; a call lets go of the GIL.
        device: Embree's device, on which all scenes are made; threads may share it.
        path: the file.
    """

    functions: ctypes.CDLL
    device: int
    path: str

    def check(self, doing: str) -> None:
        """Raise EmbreeError when a call of this thread since the last check went wrong; `doing` says at what."""
        code = self.functions.rtcGetDeviceError(self.device)
        if code:
            said = _ERRORS.get(code, "unknown error")
            raise EmbreeError(f"Embree failed at {doing}: {said} (error {code}; {self.path})")


@functools.cache
def library() -> Library:
    """Return Embree, loaded at the first call.

    Raises EmbreeError with what was tried, when there is none or none of version 4.
    """
    tried: list[str] = []
    for candidate in candidates():
        try:
            return _load(candidate)
        except (OSError, AttributeError, EmbreeError) as error:
            tried.append(f"{candidate}: {error}")
    said = "; ".join(tried) if tried else "there is neither embreex nor a library of the system"
    raise EmbreeError(f"the library Embree 4 is not to be had ({said}): pip install embreex")


def candidates() -> Iterator[str]:
    """Yield the files that may be Embree: the one that the wheel embreex carries comes first, then the system's."""
    found = importlib.util.find_spec("embreex")
    if found is not None and found.origin is not None:
        package = Path(found.origin).parent
        # auditwheel, delocate and delvewheel put it there, its dependencies beside it.
        patterns = {"darwin": (package / ".dylibs", "libembree4*.dylib")}.get(
            sys.platform,
            (package.parent / "embreex.libs", "embree4*.dll" if sys.platform == "win32" else "libembree4*"),
        )
        yield from (str(file) for file in sorted(patterns[0].glob(patterns[1])))
    name = ctypes.util.find_library("embree4")
    if name is not None:
        yield name


def _load(path: str) -> Library:
    functions = ctypes.CDLL(path)
    for name, (returned, arguments) in _FUNCTIONS.items():
        function = getattr(functions, name)
        function.restype, function.argtypes = returned, arguments
    device = functions.rtcNewDevice(_SETTINGS)
    if not device:
        code = functions.rtcGetDeviceError(None)
        raise EmbreeError(f"Embree made no device: {_ERRORS.get(code, 'unknown error')} (error {code})")
    version = functions.rtcGetDeviceProperty(device, _VERSION_MAJOR)
    if version != 4:
        raise EmbreeError(f"it is of version {version}, not 4")
    return Library(functions, device, path)
