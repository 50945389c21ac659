"""Meshes of the world: found with all that they name, parsed once, kept for every thread that asks."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterable, Mapping
from pathlib import Path

from virtualrobot_kernel.errors import KernelError, MalformedFileError
from virtualrobot_kernel.formats.assets import MEBIBYTE, AssetStore
from virtualrobot_kernel.formats.dependents import find_dependents
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_cache import LEAST_BYTES, MeshCache
from virtualrobot_kernel.formats.meshes import MESH_FORMATS, parse_mesh, scaled
from virtualrobot_kernel.formats.references import ending
from virtualrobot_kernel.formats.translate import Importers, NoImporters, Translated, run, translate
from virtualrobot_kernel.formats.xml import FileWarning, malformed, place_in
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Mesh

Scale = tuple[float, float, float]

UNSCALED: Scale = (1.0, 1.0, 1.0)


class MeshLibrary:
    """Submeshes by content, parsed once and kept while they fit; any thread may ask.

    Two threads that ask for the same new mesh at the same time both parse it: nothing is locked meanwhile.

    Attributes:
        store: holds the files.
        importers: translate what the kernel does not read itself.
        folders: where on the disk files may lie that a request names; None: anywhere.
        cache: keeps what was parsed from kernel to kernel; None: nothing is kept.
    """

    def __init__(
        self,
        store: AssetStore,
        importers: Importers | None = None,
        limit_bytes: int = 256 * MEBIBYTE,
        folders: Iterable[Path] | None = None,
        cache: MeshCache | None = None,
    ) -> None:
        """Take the files from `store`; forget what was not asked for longest when over `limit_bytes`.

        `folders` of the disk are where files may lie that a request names; None: anywhere.
        """
        self.store = store
        self.folders = None if folders is None else tuple(folders)
        self.importers: Importers = importers or NoImporters()
        self.cache = cache
        self._limit = limit_bytes
        self._kept: OrderedDict[tuple, tuple[Submesh, ...]] = OrderedDict()
        self._size = 0
        self._triangles: dict[tuple, int] = {}
        self._lock = threading.Lock()

    @property
    def formats(self) -> tuple[str, ...]:
        """Return the endings of mesh files that are read, those of importers last."""
        return tuple(dict.fromkeys((*MESH_FORMATS, *self.importers.endings)))

    def find(
        self, files: Files, uri: str, referrer: str = "", scale: Scale = UNSCALED, sha256: str = ""
    ) -> tuple[Mesh, tuple[FileWarning, ...]]:
        """Return the mesh that `referrer` names as `uri`, with all files that it names in turn, and warnings.

        Everything is in the asset store then. A buffer of a glTF file must be there; a material or texture that is
        missing costs the look only and is a warning.

        Raises:
            MissingFileError: when the file or a buffer is nowhere.
            MalformedFileError: when the file cannot be searched for names, or is not the one with `sha256` (where
                given), or no mesh comes of its translation.
        """
        main = files.read(uri, referrer, sha256)
        if sha256 and sha256.lower() != main.sha256:
            raise MalformedFileError(
                f"{main.key} has changed: its SHA-256 is {main.sha256}, not {sha256} as stated; leave `sha256` out to "
                "take the file as it is now",
                file=main.key,
                sha256=main.sha256,
                stated_sha256=sha256,
            )
        kind = ending(main.key)
        if kind not in MESH_FORMATS and kind in self.importers.endings:
            translated = translate(self.importers, main, files)
            return self.adopt(translated, scale), translated.warnings
        found, warnings = find_dependents(files, main)
        return Mesh(main.key, main.sha256, scale, tuple(found.items())), tuple(warnings)

    def adopt(self, translated: Translated, scale: Scale = UNSCALED) -> Mesh:
        """Return the mesh that a file was translated to, and keep its triangles.

        The mesh is the original file, translated anew wherever it is loaded. Only when the importer had settings, which
        a mesh does not have, it is the translation itself, under the original's name with `.glb` behind it.

        Raises MalformedFileError when the file was translated to something else than a mesh.
        """
        file = translated.file
        if translated.settings:
            return Mesh(f"{file.key}.glb", self.store.put(translated.data), scale)
        mesh = Mesh(file.key, file.sha256, scale, translated.files)
        content = (ending(mesh.uri), mesh.sha256, mesh.files)
        self._keep((content, UNSCALED), _triangles(translated.format, translated.data, file.key))
        return mesh

    def load(self, mesh: Mesh) -> tuple[Submesh, ...]:
        """Return the submeshes of a mesh, scaled, in the frame of its figure.

        Raises:
            MalformedFileError: when the file is broken or of a format that nothing reads.
            KernelError: UNKNOWN_ASSET when the store does not hold one of its files.
        """
        content = self.content(mesh)
        parts = self._recall((content, mesh.scale))
        if parts is not None:
            return parts
        parts = self._recall((content, UNSCALED))
        if parts is None:
            parts = self._read(mesh)
            self._keep((content, UNSCALED), parts)
        if mesh.scale != UNSCALED:
            parts = scaled(parts, mesh.scale)
            self._keep((content, mesh.scale), parts)
        return parts

    @staticmethod
    def content(mesh: Mesh) -> tuple:
        """Return what is alike for meshes with the same triangles but for their scale."""
        # Equal bytes under another name of a dependent would look for another file, so the names count.
        return ending(mesh.uri), mesh.sha256, mesh.files

    def triangles(self, mesh: Mesh) -> int:
        """Return the number of triangles of a mesh; errors as of `load`."""
        content = self.content(mesh)
        if content not in self._triangles:
            self._triangles[content] = sum(len(part.faces) for part in self.load(mesh))
        return self._triangles[content]

    def _read(self, mesh: Mesh) -> tuple[Submesh, ...]:
        data = self.store.get(mesh.sha256)
        dependents = {name: self.store.get(sha256) for name, sha256 in mesh.files}
        kind = ending(mesh.uri)
        if kind not in self.formats:
            known = ", ".join(self.formats)
            raise malformed(mesh.uri, None, f"no mesh format has the ending {kind!r}; known: {known}")
        if kind in MESH_FORMATS:
            return self._parsed(data, mesh, dependents)
        translation = run(self.importers, data, mesh.uri, dependents.get, {})
        return _triangles(translation.format, translation.data, mesh.uri)

    def _parsed(self, data: bytes, mesh: Mesh, dependents: Mapping[str, bytes]) -> tuple[Submesh, ...]:
        if self.cache is None or len(data) < LEAST_BYTES:
            return parse_mesh(data, mesh.uri, dependents)
        content = self.content(mesh)
        parts = self.cache.get(content, dependents)
        if parts is None:
            parts = parse_mesh(data, mesh.uri, dependents)
            self.cache.put(content, dependents, parts)
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


def _triangles(kind: str, data: bytes, uri: str) -> tuple[Submesh, ...]:
    """Return the triangles of a translation of the file `uri`."""
    if kind != ".glb":
        what = "a robot" if kind == ".urdf" else "a scene"
        raise malformed(uri, None, f"the file holds {what}, which is no mesh: import it as a model")
    try:
        return parse_mesh(data, "translation.glb")
    except KernelError as error:
        raise error.at(f"{place_in(uri, None)}: its translation") from error
