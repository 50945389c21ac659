"""Triangles written as a GLB file, which is what importers of meshes translate to.

Positions are meters in the axes of the original file. Colours of pieces are sRGB, as screens show them; the file holds
them in linear light, as glTF wants (Khronos, glTF 2.0 specification, 3.7.2.1 and 3.9.2).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.glb import ARRAY_BUFFER, ELEMENT_BUFFER, Buffers, material, pack_glb, upright

from virtualrobot_plugins.importers.refusal import refusal

Color = tuple[float, float, float, float]

MAX_TRIANGLES = 20_000_000
"""More are refused: they would take gigabytes in the kernel."""

ROUGHNESS = 0.8
"""Roughness of surfaces whose file tells none: rather dull."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Triangles with one look.

    Attributes:
        vertices: (n, 3) meters.
        faces: (m, 3) rows of `vertices`, counter-clockwise seen from outside.
        color: red, green, blue (sRGB), opacity, 0 to 1, a factor on the texture; None means that the file tells none.
        normals: (n, 3) unit vectors, or None.
        vertex_colors: (n, 4) red, green, blue (sRGB), opacity, 0 to 255, or None.
        uv: (n, 2) with the origin at the image's lower left corner, or None.
        texture: a PNG or JPEG file, or None.
    """

    vertices: NDArray
    faces: NDArray
    color: Color | None = None
    normals: NDArray | None = None
    vertex_colors: NDArray | None = None
    uv: NDArray | None = None
    texture: bytes | None = None


def placed(piece: Piece, matrix: NDArray[np.float64]) -> Piece:
    """Return the piece under a 4x4 matrix, which may scale, shear and mirror; outside stays outside."""
    linear = matrix[:3, :3]
    vertices = piece.vertices @ linear.T + matrix[:3, 3]
    determinant = float(np.linalg.det(linear))
    normals = piece.normals
    if normals is not None:
        # A matrix that flattens has no inverse; what is left has no thickness, and any normal is as good.
        normals = None if abs(determinant) < 1e-300 else unit(normals @ np.linalg.inv(linear))
    faces = piece.faces[:, ::-1] if determinant < 0.0 else piece.faces
    return Piece(vertices, faces, piece.color, normals, piece.vertex_colors, piece.uv, piece.texture)


def unit(vectors: NDArray) -> NDArray:
    """Return rows of length 1; a row of zeros stays."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


def write_glb(pieces: Iterable[Piece], uri: str) -> bytes:
    """Return the pieces as a GLB file; those of one look become one mesh.

    Raises:
        ArgumentError: when there is no triangle, or too many, or a coordinate is not finite.
    """
    groups: dict[tuple, list[Piece]] = {}
    for piece in pieces:
        if len(piece.faces):
            groups.setdefault(_look(piece), []).append(piece)
    count = sum(len(piece.faces) for group in groups.values() for piece in group)
    if count == 0:
        raise refusal(uri, "the file holds no triangle")
    if count > MAX_TRIANGLES:
        raise refusal(uri, f"the file makes {count} triangles; at most {MAX_TRIANGLES} are read")
    writer = _Writer()
    for group in groups.values():
        writer.add(_joined(group), uri)
    return writer.finish()


def _look(piece: Piece) -> tuple:
    has = tuple(array is not None for array in (piece.normals, piece.vertex_colors, piece.uv))
    return piece.color, piece.texture, has


def _joined(group: Sequence[Piece]) -> Piece:
    first = group[0]
    if len(group) == 1:
        return first
    starts = np.cumsum([0, *(len(piece.vertices) for piece in group)])
    faces = np.concatenate([piece.faces + start for piece, start in zip(group, starts[:-1], strict=True)])
    vertices = np.concatenate([piece.vertices for piece in group])

    def all_of(arrays: list[NDArray | None]) -> NDArray | None:
        return None if arrays[0] is None else np.concatenate([array for array in arrays if array is not None])

    return Piece(
        vertices,
        faces,
        first.color,
        all_of([piece.normals for piece in group]),
        all_of([piece.vertex_colors for piece in group]),
        all_of([piece.uv for piece in group]),
        first.texture,
    )


class _Writer:
    """Collects buffers and the JSON that describes them."""

    def __init__(self) -> None:
        self._buffers = Buffers()
        self._tree: dict[str, list[dict[str, Any]]] = {"nodes": [], "meshes": []}

    def add(self, piece: Piece, uri: str) -> None:
        buffers = self._buffers
        with np.errstate(over="ignore"):  # what is too large for float32 is told below
            vertices = np.ascontiguousarray(piece.vertices, np.float32)
        if not np.isfinite(vertices).all():
            raise refusal(uri, "the file holds coordinates that are not finite or too large (above 3e38)")
        attributes = {"POSITION": buffers.add(vertices, "VEC3", ARRAY_BUFFER, bounds=True)}
        if piece.normals is not None:
            attributes["NORMAL"] = buffers.add(piece.normals.astype(np.float32), "VEC3", ARRAY_BUFFER)
        if piece.vertex_colors is not None:
            attributes["COLOR_0"] = buffers.add_colors(piece.vertex_colors)
        if piece.uv is not None:
            attributes["TEXCOORD_0"] = buffers.add(upright(piece.uv), "VEC2", ARRAY_BUFFER)
        indices = buffers.add(np.ascontiguousarray(piece.faces, np.uint32).reshape(-1), "SCALAR", ELEMENT_BUFFER)
        primitive: dict[str, Any] = {"attributes": attributes, "indices": indices}
        if piece.color is not None or piece.texture is not None:
            materials = self._tree.setdefault("materials", [])
            primitive["material"] = len(materials)
            texture = None if piece.texture is None else self._texture(piece.texture)
            materials.append(material(piece.color or (1.0, 1.0, 1.0, 1.0), ROUGHNESS, texture))
        self._tree["nodes"].append({"mesh": len(self._tree["meshes"])})
        self._tree["meshes"].append({"primitives": [primitive]})

    def _texture(self, data: bytes) -> int:
        kind = "image/png" if data.startswith(b"\x89PNG") else "image/jpeg"
        images, textures = self._tree.setdefault("images", []), self._tree.setdefault("textures", [])
        textures.append({"source": len(images)})
        images.append({"bufferView": self._buffers.append(data), "mimeType": kind})
        return len(textures) - 1

    def finish(self) -> bytes:
        tree = {
            "asset": {"version": "2.0", "generator": "VirtualRobot"},
            "scene": 0,
            "scenes": [{"nodes": list(range(len(self._tree["nodes"])))}],
            **self._tree,
            "accessors": self._buffers.accessors,
            "bufferViews": self._buffers.views,
            "buffers": [{"byteLength": len(self._buffers.data)}],
        }
        return pack_glb(tree, self._buffers.data)
