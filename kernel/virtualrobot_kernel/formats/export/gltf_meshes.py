"""Figures as glTF meshes: each geometry's buffers once, each look once, each pair of them once."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.glb import ARRAY_BUFFER, ELEMENT_BUFFER, ROUGHNESS, Buffers, material, upright

from virtualrobot_kernel.formats.export.coarse import Tone, coarser
from virtualrobot_kernel.formats.export.triangles import same_content, triangles
from virtualrobot_kernel.shapes.creases import shaded
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Figure, Frame, Geometry, Label, Lines, Mesh, Points

Rgba = tuple[float, float, float, float]
Finish = tuple[float, float]
"""Roughness and metalness of a surface."""

PLAIN: Finish = (ROUGHNESS, 0.0)

QUANTIZED = "KHR_mesh_quantization"
"""The extension of glTF that lets places and normals be integers."""

POINTS, LINES = 0, 1
"""Modes of a glTF primitive; without one it is triangles."""

GREY: Rgba = (0.72, 0.74, 0.77, 1.0)
"""Colour of surfaces that have none of their own."""

INK: Rgba = (0.125, 0.29, 0.588, 1.0)
"""Colour of points and lines that have none of their own."""

WHITE: Rgba = (1.0, 1.0, 1.0, 1.0)

AXES = ((219, 46, 46), (46, 168, 61), (41, 97, 230))
"""Colours of a frame's x, y and z."""

STEPS = 65535
"""Places are told by 16 bits along each axis of a mesh's bounding cube where it may be a little off."""

INDEX_LIMIT = 65535
"""Greatest number of vertices with 16-bit indices; the last one is not allowed (glTF 2.0, 3.7.2.1)."""


@dataclass(frozen=True, slots=True)
class Cube:
    """The cube whose corners the integers of a mesh count from and to: what they stand for is low + size * [0, 1]."""

    low: NDArray[np.float64]
    size: float

    @classmethod
    def around(cls, parts: Sequence[Submesh]) -> Cube:
        """Return the least cube with its lowest corner at that of the bounding box."""
        low = np.min([part.vertices.min(axis=0) for part in parts], axis=0).astype(np.float64)
        high = np.max([part.vertices.max(axis=0) for part in parts], axis=0).astype(np.float64)
        return cls(low, max(float((high - low).max()), 1e-9))

    @property
    def step(self) -> float:
        """Return the distance of two places along an axis."""
        return self.size / STEPS

    def placed(self) -> dict[str, list[float]]:
        """Return what takes the integers of a mesh to meters, as a glTF node has it."""
        return {"translation": self.low.tolist(), "scale": 3 * [self.size]}

    def integers(self, points: NDArray[np.float32]) -> NDArray[np.uint16]:
        """Return points (n, 3) of the mesh as integers."""
        return np.clip(np.round((points - self.low) / self.step), 0, STEPS).astype(np.uint16)


class MeshTable:
    """Table of meshes, materials, textures and the buffers that they share.

    Attributes:
        cubes: by the index of a mesh, the cube in which its integers count; meshes that are not here have meters.
    """

    def __init__(self, load: Callable[[Mesh], tuple[Submesh, ...]], tolerance: float = 0.0) -> None:
        """Take the triangles of mesh files from `load`; surfaces may be off by `tolerance`, m."""
        self.buffers = Buffers()
        self.meshes: list[dict[str, Any]] = []
        self.cubes: dict[int, Cube] = {}
        self._load = load
        self._tolerance = tolerance
        self._geometry_cubes: dict[Geometry, Cube | None] = {}
        self._places: dict[tuple[Geometry, Rgba | None, Finish], int] = {}
        self._stored: dict[Geometry, list[tuple[Submesh, Tone | None, dict[str, Any]]]] = {}
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
            cube = self._geometry_cubes.get(shape)
            if cube is not None:
                self.cubes[len(self.meshes)] = cube
            self.meshes.append({"name": _name(figure.geometry), "primitives": primitives})
        return self._places[key]

    def document(self) -> dict[str, Any]:
        """Return the properties of the glTF file that are not its nodes; empty lists are not allowed."""
        found = {
            "extensionsUsed": [QUANTIZED] if self.cubes else [],
            "extensionsRequired": [QUANTIZED] if self.cubes else [],
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
            cube = self._geometry_cubes[geometry] = self._cube(parts)
            self._stored[geometry] = [self._store(part, cube) for part in parts]
        return [self._dressed(*stored, color, finish) for stored in self._stored[geometry]]

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

    def _cube(self, parts: Sequence[Submesh]) -> Cube | None:
        """Return the cube in which a mesh is told by integers; None where these would be too far off."""
        if self._tolerance <= 0.0 or not all(np.isfinite(part.vertices).all() for part in parts):
            return None
        cube = Cube.around(parts)
        return cube if cube.step <= 0.5 * self._tolerance else None

    def _store(self, part: Submesh, cube: Cube | None) -> tuple[Submesh, Tone | None, dict[str, Any]]:
        """Return a part with normals, its tone in place of a texture, and where its numbers are in the buffers."""
        # Rounding takes a place half a step away along each axis.
        part, tone = (part, None) if cube is None else coarser(part, self._tolerance - cube.step)
        part = shaded(part)
        assert part.normals is not None  # `shaded` has made them
        normals = _unit(part.normals)
        if cube is None:
            attributes = {
                "POSITION": self.buffers.add(_single(part.vertices), "VEC3", ARRAY_BUFFER, bounds=True),
                "NORMAL": self.buffers.add(normals, "VEC3", ARRAY_BUFFER),
            }
        else:
            places, turns = cube.integers(part.vertices), np.round(127.0 * normals).astype(np.int8)
            attributes = {
                "POSITION": self.buffers.add(places, "VEC3", ARRAY_BUFFER, bounds=True, normalized=True),
                "NORMAL": self.buffers.add(turns, "VEC3", ARRAY_BUFFER, normalized=True),
            }
        if part.texture is not None and part.uv is not None:
            attributes["TEXCOORD_0"] = self.buffers.add(upright(np.nan_to_num(part.uv)), "VEC2", ARRAY_BUFFER)
        kind = np.uint16 if len(part.vertices) <= INDEX_LIMIT else np.uint32
        indices = self.buffers.add(part.faces.astype(kind).reshape(-1), "SCALAR", ELEMENT_BUFFER)
        return part, tone, {"attributes": attributes, "indices": indices}

    def _dressed(
        self, part: Submesh, tone: Tone | None, shape: dict[str, Any], color: Rgba | None, finish: Finish
    ) -> dict[str, Any]:
        """Return a part in its look: `color` replaces the part's own colours, and is a factor on its texture."""
        if part.texture is not None and part.uv is not None:
            texture = self._texture(part.texture)
            return {**shape, "material": self._material(color or part.color or WHITE, finish, texture)}
        if tone is not None:
            red, green, blue, alpha = color or part.color or WHITE
            toned = (red * tone[0], green * tone[1], blue * tone[2], alpha)
            return {**shape, "material": self._material(toned, finish)}
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
