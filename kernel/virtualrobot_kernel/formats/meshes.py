"""STL, OBJ, COLLADA and glTF files read into submeshes, as RViz and MoveIt read them.

Numbers are meters; COLLADA's `<unit>` is applied. Transforms of nodes inside a file are applied. The up axis that a
file declares (COLLADA `<up_axis>`, glTF's y) is NOT applied: the file's axes are the figure's axes. That is the ROS
convention, by which URDF files are written (rviz `mesh_loader.cpp` leaves out Assimp's root node, geometric_shapes
`mesh_operations.cpp` resets it). PyBullet does turn COLLADA files by their up axis.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any, TypeAlias
from urllib.parse import unquote

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from trimesh.resolvers import Resolver as TrimeshResolver
from virtualrobot.resolver import join_uri

from virtualrobot_kernel.errors import KernelError, MalformedFileError
from virtualrobot_kernel.formats.references import ending
from virtualrobot_kernel.formats.submesh import Submesh, frozen, merged, transformed
from virtualrobot_kernel.formats.xml import local_name, malformed, parse_xml

MESH_FORMATS = (".stl", ".obj", ".dae", ".gltf", ".glb")
"""Endings of the mesh files that are read."""


Color = tuple[float, float, float, float]

_Material: TypeAlias = Any
"""One of trimesh's kinds of material, which have no base with the fields that are read here."""


class _Dependents(TrimeshResolver):
    """Gives trimesh the files that a mesh file names, from memory only."""

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


def parse_mesh(data: bytes, uri: str, dependents: Mapping[str, bytes] | None = None) -> tuple[Submesh, ...]:
    """Return the triangles of a mesh file.

    `dependents` holds the files that it names: by the name in the file, by that name joined to `uri`, or as counted
    from the folder of the mesh.

    A texture or material file that is not among the dependents costs the look only. Lines and points are left out.

    Raises:
        MalformedFileError: when the format is unknown, the file is broken, or it holds no triangle.
    """
    kind = ending(uri)
    if kind not in MESH_FORMATS:
        raise malformed(uri, None, f"no mesh format has the ending {kind!r}; known: {', '.join(MESH_FORMATS)}")
    unit = _collada_unit(data, uri) if kind == ".dae" else 1.0
    resolver = _Dependents(uri, dependents or {})
    try:
        with np.errstate(all="ignore"):  # a broken file is told by what it yields
            scene = trimesh.load_scene(io.BytesIO(data), file_type=kind[1:], resolver=resolver, process=False)
            parts = [part for name in scene.graph.nodes_geometry for part in _placed(scene, name, unit, resolver)]
    except KernelError:
        raise
    except Exception as error:  # the readers below trimesh raise whatever a broken file makes them run into
        text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        raise malformed(uri, None, f"broken or not a {kind[1:].upper()} file ({text})") from error
    if not parts:
        raise malformed(uri, None, "the file holds no triangle")
    for part in parts:
        _check(part, uri)
    return tuple(merged(part) for part in parts)


def _placed(scene: trimesh.Scene, node: str, unit: float, files: _Dependents) -> list[Submesh]:
    """Return what one node of a file's own scene shows, in the file's frame and meters."""
    matrix, name = scene.graph[node]
    geometry = scene.geometry[name]
    if not isinstance(geometry, trimesh.Trimesh) or len(geometry.faces) == 0:
        return []
    submesh = _submesh(geometry, files)
    matrix = np.asarray(matrix, dtype=np.float64)
    if unit == 1.0 and np.array_equal(matrix, np.eye(4)):
        return [submesh]
    if abs(np.linalg.det(matrix[:3, :3])) < 1e-30:
        return []  # a node flattened to nothing, which exporters use to hide things
    return [transformed(submesh, unit * matrix[:3, :3], unit * matrix[:3, 3])]


def _submesh(geometry: trimesh.Trimesh, files: _Dependents) -> Submesh:
    vertices = np.asarray(geometry.vertices)
    faces = np.asarray(geometry.faces)
    # trimesh keeps the file's normals in its cache; asking for the property would make some up.
    normals = geometry._cache.cache.get("vertex_normals")
    if normals is not None and (np.shape(normals) != vertices.shape or not np.isfinite(normals).all()):
        normals = None
    visual: Any = geometry.visual
    color, vertex_colors, uv, texture = None, None, None, None
    if visual.kind == "texture":
        color, texture = _material_look(visual.material, files)
        uv = visual.uv if texture is not None and np.shape(visual.uv) == (len(vertices), 2) else None
        texture = texture if uv is not None else None
    elif visual.kind == "vertex":
        vertex_colors = np.asarray(visual.vertex_colors, dtype=np.uint8)
    elif visual.kind == "face":
        vertex_colors = np.repeat(np.asarray(visual.face_colors, dtype=np.uint8), 3, axis=0)
        vertices, normals = vertices[faces].reshape(-1, 3), None
        faces = np.arange(len(vertices)).reshape(-1, 3)
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


def _material_look(material: _Material, files: _Dependents) -> tuple[Color | None, bytes | None]:
    """Return colour and texture of one of trimesh's materials."""
    image = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
    main = material.baseColorFactor if hasattr(material, "baseColorFactor") else material.diffuse
    color = None if main is None else _parts_of_one(main)
    # An OBJ material says its opacity as `d`; 0 is an exporter's mistake, since nothing would be seen.
    opacity = getattr(material, "kwargs", {}).get("d")
    if color is not None and opacity:
        alpha = float(opacity[-1])
        color = (*color[:3], alpha) if 0.0 < alpha <= 1.0 else color
    return color, None if image is None else _png(image, files)


def _png(image: Image.Image, files: _Dependents) -> bytes:
    """Return an image as PNG: the file's own bytes where trimesh tells its name, as it does for MTL files."""
    image.load()  # a broken one is refused here
    name = image.info.get("file_path")
    if image.format == "PNG" and name:
        return files.get(name)
    png = io.BytesIO()
    image.save(png, "PNG", compress_level=1)
    return png.getvalue()


def _parts_of_one(color: NDArray) -> Color:
    values = np.asarray(color)
    values = values / 255.0 if np.issubdtype(values.dtype, np.integer) else values.astype(np.float64)
    red, green, blue, *rest = (float(value) for value in values)
    return red, green, blue, rest[0] if rest else 1.0


def _check(part: Submesh, uri: str) -> None:
    """Raise MalformedFileError for numbers that no shape can have."""
    if len(part.vertices) == 0 or not np.isfinite(part.vertices).all():
        bad = np.flatnonzero(~np.isfinite(part.vertices).all(axis=1))
        raise malformed(uri, None, f"vertex {bad[0] if len(bad) else 0} is not finite")
    if part.faces.min() < 0 or part.faces.max() >= len(part.vertices):
        raise malformed(
            uri, None, f"a face names vertex {int(part.faces.max())}, but there are {len(part.vertices)} vertices"
        )


def _collada_unit(data: bytes, uri: str) -> float:
    """Return the length of the file's unit in meters; 1 when it tells none (COLLADA 1.4.1, `<unit>`)."""
    root = parse_xml(data, uri)
    if local_name(root) != "COLLADA":
        raise malformed(uri, root.sourceline, f"not COLLADA: the root element is <{local_name(root)}>")
    unit = root.find("{*}asset/{*}unit")
    if unit is None or not unit.get("meter"):
        return 1.0
    try:
        meters = float(unit.get("meter", "1"))
    except ValueError as error:
        raise malformed(uri, unit.sourceline, f"unit meter={unit.get('meter')!r} is no number") from error
    if not np.isfinite(meters) or meters <= 0.0:
        raise malformed(uri, unit.sourceline, f"unit meter={unit.get('meter')!r} must be above 0")
    return meters


def scaled(parts: tuple[Submesh, ...], scale: tuple[float, float, float]) -> tuple[Submesh, ...]:
    """Return the parts scaled along x, y, z; factors may be negative (mirrored) but not 0.

    Raises:
        MalformedFileError: for a factor of 0 or one that is not finite.
    """
    if scale == (1.0, 1.0, 1.0):
        return parts
    if not all(np.isfinite(factor) and factor != 0.0 for factor in scale):
        raise MalformedFileError(f"the scale {scale} is impossible: factors are finite and not 0", scale=scale)
    linear = np.diag(np.asarray(scale, dtype=np.float64))
    return tuple(transformed(part, linear) for part in parts)
