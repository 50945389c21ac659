"""Parsed meshes on the disk, from kernel to kernel: by their content and by what parsed them, bounded in size.

What lies there is never believed unread: a file begins with the checksum of the rest, and one that is broken, or gone,
costs parsing alone.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import logging
import os
import threading
import zlib
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray
from platformdirs import user_cache_dir

from virtualrobot_kernel.formats.assets import MEBIBYTE
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.whole_files import write_whole

log = logging.getLogger(__name__)

LEAST_BYTES = 16 * 1024
"""Size of the smallest mesh file that is kept; smaller ones are parsed as fast as they are looked up."""

LIMIT_BYTES = 512 * MEBIBYTE
"""Size of all files together, from which on those that were not asked for longest are deleted."""

_PACKAGES = ("numpy", "pillow", "pycollada", "trimesh")
"""Packages that what comes of a mesh depends on."""

_CHECKSUM_BYTES = 4
_ENDING = ".mesh"


class _Part(msgspec.Struct, array_like=True):
    """A submesh as it is written; its texture is there itself, or it is the file that the mesh names `textured_by`."""

    vertices: bytes
    faces: bytes
    normals: bytes | None
    color: tuple[float, float, float, float] | None
    vertex_colors: bytes | None
    uv: bytes | None
    texture: bytes | None
    textured_by: str | None


class MeshCache:
    """Cache of submeshes in a folder; any thread and any number of kernels may ask."""

    def __init__(self, folder: Path | None = None, limit_bytes: int = LIMIT_BYTES) -> None:
        """Keep at most about `limit_bytes` in `folder`, which is made when something is put; None: the user's."""
        self._folder = folder or Path(user_cache_dir("virtualrobot")) / "meshes"
        self._limit = limit_bytes
        self._unseen = limit_bytes  # bytes put since the folder was looked at; at first it is not known
        self._lock = threading.Lock()

    def get(self, content: tuple, dependents: Mapping[str, bytes]) -> tuple[Submesh, ...] | None:
        """Return what came of a mesh with this content and these files that it names, or None."""
        path = self._path(content)
        try:
            data = path.read_bytes()
            rest = memoryview(data)[_CHECKSUM_BYTES:]
            if zlib.crc32(rest).to_bytes(_CHECKSUM_BYTES, "little") != data[:_CHECKSUM_BYTES]:
                return None
            parts = tuple(_read(part, dependents) for part in msgspec.msgpack.decode(rest, type=list[_Part]))
        except (OSError, msgspec.MsgspecError, ValueError, KeyError):
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return parts

    def put(self, content: tuple, dependents: Mapping[str, bytes], parts: tuple[Submesh, ...]) -> None:
        """Keep what came of a mesh; where that fails, do without."""
        rest = msgspec.msgpack.encode([_written(part, dependents) for part in parts])
        if len(rest) > self._limit // 4:
            return
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            write_whole(self._path(content), zlib.crc32(rest).to_bytes(_CHECKSUM_BYTES, "little") + rest)
            with self._lock:
                self._unseen += len(rest)
                if self._unseen > self._limit // 16:
                    self._unseen = 0
                    self._make_room()
        except OSError as error:
            log.info("a parsed mesh is not kept: %s", error)

    def _make_room(self) -> None:
        """Delete what was not asked for longest, where all is over the limit."""
        found = []
        for entry in os.scandir(self._folder):
            with contextlib.suppress(OSError):  # another kernel has deleted it
                about = entry.stat()
                found.append((about.st_mtime_ns, about.st_size, entry.path))
        size = sum(one for _, one, _ in found)
        for _, one, path in sorted(found):
            if size <= self._limit:
                break
            with contextlib.suppress(OSError):
                os.unlink(path)
            size -= one

    def _path(self, content: tuple) -> Path:
        return self._folder / (hashlib.sha256(repr((_parser(), content)).encode()).hexdigest() + _ENDING)


@functools.cache
def _parser() -> str:
    """Return a digest of what makes submeshes of bytes: this room's sources and what they use, and their packages."""
    here = Path(__file__).parent
    sources = (*sorted(here.glob("*.py")), here.parent / "shapes/submesh.py", here.parent / "numeric/wavefront.py")
    digest = hashlib.sha256(repr([(name, version(name)) for name in _PACKAGES]).encode())
    for source in sources:
        digest.update(source.read_bytes())
    return digest.hexdigest()


def _written(part: Submesh, dependents: Mapping[str, bytes]) -> _Part:
    def raw(array: NDArray | None) -> bytes | None:
        return None if array is None else array.tobytes()

    textured_by = next((name for name, data in dependents.items() if data == part.texture), None)
    return _Part(
        part.vertices.tobytes(),
        part.faces.tobytes(),
        raw(part.normals),
        part.color,
        raw(part.vertex_colors),
        raw(part.uv),
        part.texture if textured_by is None else None,
        textured_by,
    )


def _read(part: _Part, dependents: Mapping[str, bytes]) -> Submesh:
    def rows(data: bytes | None, width: int, dtype: type) -> NDArray | None:
        return None if data is None else np.frombuffer(data, dtype).reshape(-1, width)

    return Submesh(
        np.frombuffer(part.vertices, np.float32).reshape(-1, 3),
        np.frombuffer(part.faces, np.int32).reshape(-1, 3),
        rows(part.normals, 3, np.float32),
        part.color,
        rows(part.vertex_colors, 4, np.uint8),
        rows(part.uv, 2, np.float32),
        part.texture if part.textured_by is None else dependents[part.textured_by],
    )
