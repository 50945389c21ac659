"""Mesh files through trimesh: the one module that imports it, which takes half a second."""

from __future__ import annotations

import functools
import io
from collections.abc import Mapping
from typing import Any, TypeAlias
from urllib.parse import unquote

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from trimesh.resolvers import Resolver as TrimeshResolver
from virtualrobot.files.resolver import join_uri

from virtualrobot_kernel.formats import gltf_looks, obj
from virtualrobot_kernel.formats.xml import malformed
from virtualrobot_kernel.shapes.submesh import Submesh, frozen, transformed

Color = tuple[float, float, float, float]

MOST_TRIANGLES = 20_000_000
"""Greatest number of triangles of a file, those of a shape counted each time that a node shows it."""

MOST_PIECES = 10_000
"""Greatest number of objects, and of uses of materials, of an OBJ file: trimesh takes 10 s for so many."""

MOST_PIXELS = 64 * 1024 * 1024
"""Greatest number of pixels of a texture, 8192 x 8192; a larger one is left out, as one that is broken."""

_Material: TypeAlias = Any
"""Material of one of trimesh's kinds, which have no base with the fields that are read here."""

_Factors: TypeAlias = list[NDArray[np.float64] | None] | None
"""Colour factors of a glTF file's materials by number (see `gltf_looks.prepared`); None for other formats."""


class _Dependents(TrimeshResolver):
    """Resolver of the files that a mesh file names, for trimesh, from memory only."""

    def __init__(self, uri: str, files: Mapping[str, bytes]) -> None:
        self._uri = uri
        self._files = files

    def get(self, key: str) -> bytes:
        plain = key.strip().replace("\\", "/")
        name = plain.removeprefix("./")
        for spelling in (plain, name, unquote(name), join_uri(self._uri, name), join_uri(self._uri, unquote(name))):
            if spelling in self._files:
                return self._files[spelling]
        # What an MTL file names counts from its own folder, but trimesh asks as if it counted from the OBJ's.
        for known, data in self._files.items():
            if known.endswith("/" + name):
                return data
        raise FileNotFoundError(key)

    def keys(self) -> list[str]:
        return list(self._files)

    def write(self, name: str, data: bytes) -> None:
        raise NotImplementedError("meshes are only read")

    def namespaced(self, namespace: str) -> _Dependents:
        raise NotImplementedError("meshes are read from single files")


def read(data: bytes, kind: str, uri: str, dependents: Mapping[str, bytes], unit: float) -> list[Submesh]:
    """Return what a mesh file of the format `kind` (`.obj`) shows, its numbers times `unit` meters.

    Raises whatever a broken file makes the readers below trimesh run into.
    """
    files = _Dependents(uri, dependents)
    factors: _Factors = None
    if kind in (".gltf", ".glb"):
        data, factors = gltf_looks.prepared(data, uri)
    if kind == ".obj" and (pieces := _pieces(data)) > MOST_PIECES:
        raise malformed(uri, None, f"the file has {pieces:,} objects or uses of materials; {MOST_PIECES:,} are read")
    if kind == ".obj" and (meshes := obj.read(data, files)) is not None:
        return [_submesh(mesh, files, factors) for mesh in meshes]
    with np.errstate(all="ignore"):  # a broken file is told by what it yields
        scene = trimesh.load_scene(io.BytesIO(data), file_type=kind[1:], resolver=files, process=False)
        placed = scene.graph.geometry_nodes.items()
        triangles = sum(len(nodes) * len(getattr(scene.geometry[name], "faces", ())) for name, nodes in placed)
        if triangles > MOST_TRIANGLES:
            raise malformed(uri, None, f"the file shows {triangles:,} triangles; at most {MOST_TRIANGLES:,} are read")
        return [part for node in scene.graph.nodes_geometry for part in _placed(scene, node, unit, files, factors)]


def _pieces(data: bytes) -> int:
    """Return the number of objects, or of uses of materials, of an OBJ file; 0 where it is not over MOST_PIECES."""
    # Letters are counted ten times as fast as words, and mostly there are too few.
    words = [word for letter, word in ((b"u", b"\nusemtl "), (b"o", b"\no ")) if data.count(letter) > MOST_PIECES]
    return max(map(data.count, words), default=0)


def _placed(scene: trimesh.Scene, node: str, unit: float, files: _Dependents, factors: _Factors) -> list[Submesh]:
    """Return what one node of a file's own scene shows, in the file's frame and meters."""
    matrix, name = scene.graph[node]
    geometry = scene.geometry[name]
    if not isinstance(geometry, trimesh.Trimesh) or len(geometry.faces) == 0:
        return []
    submesh = _submesh(geometry, files, factors)
    matrix = np.asarray(matrix, dtype=np.float64)
    if unit == 1.0 and np.array_equal(matrix, np.eye(4)):
        return [submesh]
    if abs(np.linalg.det(matrix[:3, :3])) < 1e-30:
        return []  # a node flattened to nothing, which exporters use to hide things
    return [transformed(submesh, unit * matrix[:3, :3], unit * matrix[:3, 3])]


def _submesh(geometry: trimesh.Trimesh, files: _Dependents, factors: _Factors) -> Submesh:
    vertices = np.asarray(geometry.vertices)
    faces = np.asarray(geometry.faces)
    # trimesh keeps the file's normals in its cache; asking for the property would make some up.
    normals = geometry._cache.cache.get("vertex_normals")
    if normals is not None and (np.shape(normals) != vertices.shape or not np.isfinite(normals).all()):
        normals = None
    visual: Any = geometry.visual
    color, vertex_colors, uv, texture = None, None, None, None
    if visual.kind == "texture":
        color, texture = _material_look(visual.material, files, factors)
        uv = visual.uv if texture is not None and np.shape(visual.uv) == (len(vertices), 2) else None
        texture = texture if uv is not None else None
    elif visual.kind == "vertex":
        vertex_colors = np.asarray(visual.vertex_colors, dtype=np.uint8)
    elif visual.kind == "face":
        vertex_colors = np.repeat(np.asarray(visual.face_colors, dtype=np.uint8), 3, axis=0)
        vertices, normals = vertices[faces].reshape(-1, 3), None
        faces = np.arange(len(vertices)).reshape(-1, 3)
    if factors is not None and texture is None:
        vertex_colors = _gltf_vertex_colors(geometry, factors)
        color = color if vertex_colors is None else None
    if vertex_colors is not None and len(np.unique(vertex_colors, axis=0)) == 1:
        color, vertex_colors = _parts_of_one(vertex_colors[0]), None
    return Submesh(
        frozen(vertices, np.float32),
        frozen(faces, np.int32),
        None if normals is None else frozen(normals, np.float32),
        color,
        None if vertex_colors is None else frozen(vertex_colors, np.uint8),
        None if uv is None else frozen(uv, np.float32),
        texture,
    )


def _gltf_vertex_colors(
    geometry: trimesh.Trimesh, factors: list[NDArray[np.float64] | None]
) -> NDArray[np.uint8] | None:
    """Return the colours of a glTF mesh's vertices times that of its material, or None when it has no such colours."""
    stored = geometry.vertex_attributes.get(gltf_looks.COLORS)
    if stored is None or len(stored) != len(geometry.vertices):
        return None
    material = getattr(geometry.visual, "material", None)
    return gltf_looks.of_vertices(stored, None if material is None else factors[int(material.name)])


def _material_look(material: _Material, files: _Dependents, factors: _Factors) -> tuple[Color | None, bytes | None]:
    """Return colour and texture of one of trimesh's materials."""
    image = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
    if image is not None and image.width * image.height > MOST_PIXELS:
        image = None
    main = material.baseColorFactor if hasattr(material, "baseColorFactor") else material.diffuse
    color = None if main is None else _parts_of_one(main)
    if factors is not None:
        factor = factors[int(material.name)]
        if factor is None:  # an extension tells it, of which trimesh makes 8 bits of linear light
            factor = np.array(color or (1.0, 1.0, 1.0, 1.0))
        color = gltf_looks.color(factor)
    # An OBJ material says its opacity as `d`; 0 is an exporter's mistake, since nothing would be seen.
    opacity = getattr(material, "kwargs", {}).get("d")
    if color is not None and opacity:
        alpha = float(opacity[-1])
        color = (*color[:3], alpha) if 0.0 < alpha <= 1.0 else color
    return color, None if image is None else _png(image, files)


def _png(image: Image.Image, files: _Dependents) -> bytes:
    """Return an image as PNG: the file's own bytes where trimesh tells its name, as it does for MTL files."""
    name = image.info.get("file_path")
    if image.format == "PNG" and name:
        data = files.get(name)
        _check_image(data)
        return data
    image.load()  # a broken one is refused here
    png = io.BytesIO()
    image.save(png, "PNG", compress_level=1)
    return png.getvalue()


@functools.lru_cache(maxsize=8)
def _check_image(data: bytes) -> None:
    """Decode an image, once for the meshes of a robot that share it; raise what Pillow raises for a broken one."""
    Image.open(io.BytesIO(data)).load()


def _parts_of_one(color: NDArray) -> Color:
    values = np.asarray(color)
    values = values / 255.0 if np.issubdtype(values.dtype, np.integer) else values.astype(np.float64)
    red, green, blue, *rest = (float(value) for value in values)
    return red, green, blue, rest[0] if rest else 1.0
