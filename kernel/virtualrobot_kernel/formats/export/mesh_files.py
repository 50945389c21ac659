"""Mesh files beside a URDF file: each shape once, under a name of its own, with what it names beside it.

STL, OBJ and COLLADA files, which readers of URDF know, stay as they are. Everything else that the kernel reads becomes
OBJ with MTL and PNG, which keeps colours and textures; primitives that URDF lacks become binary STL.
"""

from __future__ import annotations

from dataclasses import replace

from virtualrobot_kernel.formats.bundle import laid_out
from virtualrobot_kernel.formats.export.names import legal, unique
from virtualrobot_kernel.formats.export.obj import write_obj
from virtualrobot_kernel.formats.export.stl import write_stl
from virtualrobot_kernel.formats.export.triangles import same_content, triangles
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.references import ending
from virtualrobot_kernel.world.figures import Capsule, Cone, Mesh

COPIED = (".stl", ".obj", ".dae")


class MeshFiles:
    """Collector of the files that go beside one URDF file."""

    def __init__(self, library: MeshLibrary, folder: str) -> None:
        """Take triangles from `library`, put what is written in its store, and name it as in `folder`."""
        self.written: dict[str, str] = {}
        self.warnings: list[str] = []
        self._library = library
        self._folder = folder
        self._paths: dict[Mesh | Cone | Capsule, str] = {}
        self._stems: set[str] = set()

    def path(self, geometry: Mesh | Cone | Capsule) -> str:
        """Return the path of a shape's file, counted from the URDF file; a mesh's scale is not in it."""
        shape = replace(geometry, scale=(1.0, 1.0, 1.0)) if isinstance(geometry, Mesh) else geometry
        key = same_content(shape) if isinstance(shape, Mesh) else shape
        if key not in self._paths:
            self._paths[key] = self._write(shape)
        return self._paths[key]

    def _write(self, geometry: Mesh | Cone | Capsule) -> str:
        if not isinstance(geometry, Mesh):
            stem = self._stem(type(geometry).__name__.lower())
            return self._put(f"{stem}.stl", write_stl(triangles(geometry)))
        name = geometry.uri.replace("\\", "/").rpartition("/")[2]
        stem, kind = self._stem(legal(name.rpartition(".")[0] or name)), ending(geometry.uri)
        if kind not in COPIED:
            self.warnings.append(f"{name} is written as OBJ, which more programs read")
            main, *_ = [self._put(name, data) for name, data in write_obj(self._library.load(geometry), stem).items()]
            return main
        if not geometry.files:
            path = f"{self._folder}/{stem}{kind}"
            self.written[path] = geometry.sha256
            return path
        files = laid_out(geometry, f"{self._folder}/{stem}")
        self.written.update(files)
        return files[0][0]

    def _put(self, name: str, data: bytes) -> str:
        path = f"{self._folder}/{name}"
        self.written[path] = self._library.store.put(data)
        return path

    def _stem(self, name: str) -> str:
        """Return a name that no other file here has, whatever the case of letters."""
        stem = unique(name.lower(), self._stems)
        self._stems.add(stem)
        return name + stem[len(name) :]
