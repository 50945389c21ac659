"""Meshes of the world: found with all that they name, parsed once, kept for every thread that asks."""

from __future__ import annotations

import threading
from collections import OrderedDict

from virtualrobot.resolver import join_uri

from virtualrobot_kernel.errors import MalformedFileError, MissingFileError
from virtualrobot_kernel.formats.assets import MEBIBYTE, AssetStore
from virtualrobot_kernel.formats.files import File, Files
from virtualrobot_kernel.formats.meshes import parse_mesh, scaled
from virtualrobot_kernel.formats.references import counted_from, ending, list_references
from virtualrobot_kernel.formats.submesh import Submesh
from virtualrobot_kernel.world.figures import Mesh

Scale = tuple[float, float, float]

_LOOKS = (".mtl", ".png", ".jpg", ".jpeg", ".webp", ".bmp", ".gif", ".tga", ".tif", ".tiff", ".dds", ".ktx2", ".basis")
"""Endings of files without which a mesh has its shape and only looks different."""


def find_mesh(
    files: Files, uri: str, referrer: str = "", scale: Scale = (1.0, 1.0, 1.0), sha256: str = ""
) -> tuple[Mesh, tuple[str, ...]]:
    """Return the mesh that `referrer` names as `uri`, with all files that it names in turn, and warnings.

    Everything is in the asset store then. A buffer of a glTF file must be there; a material or texture that is
    missing costs the look only and is a warning.

    Raises:
        MissingFileError: when the file or a buffer is nowhere.
        MalformedFileError: when the file cannot be searched for names, or is not the one with `sha256` (where given).
    """
    main = files.read(uri, referrer)
    if sha256 and sha256.lower() != main.sha256:
        raise MalformedFileError(
            f"{main.key} has changed: its SHA-256 is {main.sha256}, not {sha256} as stated; leave `sha256` out to take "
            "the file as it is now",
            file=main.key,
            sha256=main.sha256,
            stated_sha256=sha256,
        )
    found: dict[str, str] = {}
    warnings: list[str] = []
    _gather(files, main, main, found, warnings)
    return Mesh(main.key, main.sha256, scale, tuple(found.items())), tuple(warnings)


def _gather(files: Files, main: File, file: File, found: dict[str, str], warnings: list[str]) -> None:
    """Read what `file` names, by name as counted from the main file, and what those files name."""
    for name in list_references(file.data, file.key):
        known_as = name if file is main else counted_from(main.key, join_uri(file.key, name))
        if known_as in found:
            continue
        try:
            dependent = _read_dependent(files, name, file.key)
        except MissingFileError as error:
            if ending(name) not in _LOOKS:
                raise
            warnings.append(f"{error}; drawn without it")
            continue
        found[known_as] = dependent.sha256
        _gather(files, main, dependent, found, warnings)


def _read_dependent(files: Files, name: str, referrer: str) -> File:
    """Return the file by its name, or one of that name beside its referrer: exporters write their own disk's paths."""
    try:
        return files.read(name, referrer)
    except MissingFileError:
        beside = name.rpartition("/")[2]
        if beside == name or not beside:
            raise
        try:
            return files.read(beside, referrer)
        except MissingFileError:
            pass  # the first error says more
        raise


class MeshLibrary:
    """Submeshes by content, parsed once and kept while they fit; any thread may ask.

    Two threads that ask for the same new mesh at the same time both parse it: nothing is locked meanwhile.
    """

    def __init__(self, store: AssetStore, limit_bytes: int = 1024 * MEBIBYTE) -> None:
        """Take the files from `store`; forget what was not asked for longest when over `limit_bytes`."""
        self.store = store
        self._limit = limit_bytes
        self._kept: OrderedDict[tuple, tuple[Submesh, ...]] = OrderedDict()
        self._size = 0
        self._lock = threading.Lock()

    def load(self, mesh: Mesh) -> tuple[Submesh, ...]:
        """Return the submeshes of a mesh, scaled, in the frame of its figure.

        Raises:
            MalformedFileError: when the file is broken.
            KernelError: UNKNOWN_ASSET when the store does not hold one of its files.
        """
        # Equal bytes under another name of a dependent would look for another file, so the names count.
        content = (ending(mesh.uri), mesh.sha256, mesh.files)
        parts = self._recall((content, mesh.scale))
        if parts is not None:
            return parts
        parts = self._recall((content, (1.0, 1.0, 1.0)))
        if parts is None:
            dependents = {name: self.store.get(sha256) for name, sha256 in mesh.files}
            parts = parse_mesh(self.store.get(mesh.sha256), mesh.uri, dependents)
            self._keep((content, (1.0, 1.0, 1.0)), parts)
        if mesh.scale != (1.0, 1.0, 1.0):
            parts = scaled(parts, mesh.scale)
            self._keep((content, mesh.scale), parts)
        return parts

    def _recall(self, key: tuple) -> tuple[Submesh, ...] | None:
        with self._lock:
            parts = self._kept.get(key)
            if parts is not None:
                self._kept.move_to_end(key)
            return parts

    def _keep(self, key: tuple, parts: tuple[Submesh, ...]) -> None:
        with self._lock:
            if key in self._kept:
                return
            self._kept[key] = parts
            self._size += sum(part.size_bytes for part in parts)
            while self._size > self._limit and len(self._kept) > 1:
                _, dropped = self._kept.popitem(last=False)
                self._size -= sum(part.size_bytes for part in dropped)
