"""Figures as glTF meshes: each geometry's buffers once, each look once, each pair of them once."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.glb import ARRAY_BUFFER, ELEMENT_BUFFER, ROUGHNESS, Buffers, material, upright

from virtualrobot_kernel.formats.export.triangles import same_content, triangles
from virtualrobot_kernel.shapes.creases import shaded
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Figure, Frame, Geometry, Label, Lines, Mesh, Points

Rgba = tuple[float, float, float, float]
Finish = tuple[float, float]
"""Roughness and metalness of a surface."""

PLAIN: Finish = (ROUGHNESS, 0.0)

POINTS, LINES = 0, 1
"""Modes of a glTF primitive; without one it is triangles."""

GREY: Rgba = (0.72, 0.74, 0.77, 1.0)
"""Colour of surfaces that have none of their own."""

INK: Rgba = (0.125, 0.29, 0.588, 1.0)
"""Colour of points and lines that have none of their own."""

WHITE: Rgba = (1.0, 1.0, 1.0, 1.0)

AXES = ((219, 46, 46), (46, 168, 61), (41, 97, 230))
"""Colours of a frame's x, y and z."""

INDEX_LIMIT = 65535
"""Greatest number of vertices with 16-bit indices; the last one is not allowed (glTF 2.0, 3.7.2.1)."""


class MeshTable:
    """Table of meshes, materials, textures and the buffers that they share."""

    def __init__(self, load: Callable[[Mesh], tuple[Submesh, ...]]) -> None:
        """Take the triangles of mesh files from `load`."""
        self.buffers = Buffers()
        self.meshes: list[dict[str, Any]] = []
        self._load = load
        self._places: dict[tuple[Geometry, Rgba | None, Finish], int] = {}
        self._stored: dict[Geometry, list[tuple[Submesh, dict[str, Any]]]] = {}
        self._materials: dict[tuple[Rgba, Finish, int | None, bool], int] = {}
        self._images: dict[str, int] = {}
        self._material_list: list[dict[str, Any]] = []
        self._image_list: list[dict[str, Any]] = []

    def index(self, figure: Figure) -> int | None:
        """Return the index of a figure's mesh; None where it holds nothing (points and lines may be empty)."""
        color = figure.material.color if figure.material else None
        finish = (figure.material.roughness, figure.material.metalness) if figure.material else PLAIN
        shape = same_content(figure.geometry) if isinstance(figure.geometry, Mesh) else figure.geometry
        key = (shape, color, finish)
        if key not in self._places:
            primitives = self._primitives(shape, color, finish)
            if not primitives:
                return None
            self._places[key] = len(self.meshes)
            self.meshes.append({"name": _name(figure.geometry), "primitives": primitives})
        return self._places[key]

    def document(self) -> dict[str, Any]:
        """Return the properties of the glTF file that are not its nodes; empty lists are not allowed."""
        found = {
            "meshes": self.meshes,
            "materials": self._material_list,
            "textures": [{"source": place} for place in range(len(self._image_list))],
            "images": self._image_list,
            "accessors": self.buffers.accessors,
            "bufferViews": self.buffers.views,
            "buffers": [{"byteLength": len(self.buffers.data)}],
        }
        return {name: items for name, items in found.items() if items}

    def _primitives(self, geometry: Geometry, color: Rgba | None, finish: Finish) -> list[dict[str, Any]]:
        match geometry:
            case Label():
                return []
            case Points(positions, colors):
                return self._marks(POINTS, np.frombuffer(positions), np.frombuffer(colors, np.uint8), color)
            case Lines(segments):
                return self._marks(LINES, np.frombuffer(segments), np.zeros(0, np.uint8), color)
            case Frame(length):
                ends = np.stack([np.zeros((3, 3)), length * np.eye(3)], axis=1)
                own = np.repeat(np.array(AXES, np.uint8), 0 if color else 2, axis=0)
                return self._marks(LINES, ends.ravel(), own.ravel(), color)
        if geometry not in self._stored:
            parts = self._load(geometry) if isinstance(geometry, Mesh) else (triangles(geometry),)
            self._stored[geometry] = [self._store(part) for part in parts]
        return [self._dressed(part, shape, color, finish) for part, shape in self._stored[geometry]]

    def _marks(self, mode: int, positions: NDArray, colors: NDArray, color: Rgba | None) -> list[dict[str, Any]]:
        """Return points or lines; numbers (3 n,), colours of their own (3 n,) of 8 bits or none, or else `color`."""
        if len(positions) == 0:
            return []
        places = _single(positions.reshape(-1, 3))
        attributes = {"POSITION": self.buffers.add(places, "VEC3", ARRAY_BUFFER, bounds=True)}
        if len(colors):
            opaque = np.hstack([colors.reshape(-1, 3), np.full((len(places), 1), 255, np.uint8)])
            attributes["COLOR_0"] = self.buffers.add_colors(opaque)
        material = self._material(WHITE if len(colors) else color or INK, PLAIN)
        return [{"attributes": attributes, "mode": mode, "material": material}]

    def _store(self, part: Submesh) -> tuple[Submesh, dict[str, Any]]:
        """Return a part with normals, and where its numbers are in the buffers."""
        part = shaded(part)
        assert part.normals is not None  # `shaded` has made them
        attributes = {
            "POSITION": self.buffers.add(_single(part.vertices), "VEC3", ARRAY_BUFFER, bounds=True),
            "NORMAL": self.buffers.add(_unit(part.normals), "VEC3", ARRAY_BUFFER),
        }
        if part.texture is not None and part.uv is not None:
            attributes["TEXCOORD_0"] = self.buffers.add(upright(np.nan_to_num(part.uv)), "VEC2", ARRAY_BUFFER)
        kind = np.uint16 if len(part.vertices) <= INDEX_LIMIT else np.uint32
        indices = self.buffers.add(part.faces.astype(kind).reshape(-1), "SCALAR", ELEMENT_BUFFER)
        return part, {"attributes": attributes, "indices": indices}

    def _dressed(self, part: Submesh, shape: dict[str, Any], color: Rgba | None, finish: Finish) -> dict[str, Any]:
        """Return a part in its look: `color` replaces the part's own colours, and is a factor on its texture."""
        if part.texture is not None and part.uv is not None:
            texture = self._texture(part.texture)
            return {**shape, "material": self._material(color or part.color or WHITE, finish, texture)}
        if part.vertex_colors is None or color is not None:
            return {**shape, "material": self._material(color or part.color or GREY, finish)}
        attributes = {**shape["attributes"], "COLOR_0": self.buffers.add_colors(part.vertex_colors)}
        see_through = bool((part.vertex_colors[:, 3] < 255).any())
        return {**shape, "attributes": attributes, "material": self._material(WHITE, finish, None, see_through)}

    def _material(self, color: Rgba, finish: Finish, texture: int | None = None, see_through: bool = False) -> int:
        key = (color, finish, texture, see_through)
        if key not in self._materials:
            look = material(color, finish[0], texture, finish[1])
            self._materials[key] = len(self._material_list)
            self._material_list.append({**look, "alphaMode": "BLEND"} if see_through else look)
        return self._materials[key]

    def _texture(self, png: bytes) -> int:
        content = hashlib.sha256(png).hexdigest()
        if content not in self._images:
            self._images[content] = len(self._image_list)
            self._image_list.append({"bufferView": self.buffers.append(png), "mimeType": "image/png"})
        return self._images[content]


def _name(geometry: Geometry) -> str:
    """Return the name of a mesh: its file's name, or the kind of primitive."""
    if isinstance(geometry, Mesh):
        return geometry.uri.replace("\\", "/").rpartition("/")[2] or "mesh"
    return type(geometry).__name__.lower()


def _single(numbers: NDArray) -> NDArray[np.float32]:
    """Return numbers as float32; glTF has no infinity, so what is too large becomes the largest number."""
    with np.errstate(over="ignore"):
        return np.nan_to_num(numbers.astype(np.float32))


def _unit(normals: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return rows of length 1, as glTF demands; files have others, and zeros."""
    length = np.linalg.norm(normals.astype(np.float64), axis=1, keepdims=True)
    return np.where(length > 1e-9, normals / np.maximum(length, 1e-9), [0.0, 0.0, 1.0]).astype(np.float32)
