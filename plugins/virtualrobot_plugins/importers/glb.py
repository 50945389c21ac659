"""Triangles written as a GLB file, which is what importers of meshes translate to.

Positions are meters in the axes of the original file. Colours of pieces are sRGB, as screens show them; the file holds
them in linear light, as glTF wants (Khronos, glTF 2.0 specification, 3.7.2.1 and 3.9.2).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.srgb import to_linear

from virtualrobot_plugins.importers.refusal import refusal

Color = tuple[float, float, float, float]

MAX_TRIANGLES = 20_000_000
"""More are refused: they would take gigabytes in the kernel."""

# Khronos, glTF 2.0 specification: 4.4 (GLB), 3.6.2.2 (component types), bufferView targets.
_MAGIC, _JSON_CHUNK, _BINARY_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
_FLOAT, _UNSIGNED_INT, _UNSIGNED_SHORT = 5126, 5125, 5123
_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963


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
        self._chunks: list[bytes] = []
        self._size = 0
        self._tree: dict[str, Any] = {name: [] for name in ("nodes", "meshes", "accessors", "bufferViews")}

    def add(self, piece: Piece, uri: str) -> None:
        with np.errstate(over="ignore"):  # what is too large for float32 is told below
            vertices = np.ascontiguousarray(piece.vertices, np.float32)
        if not np.isfinite(vertices).all():
            raise refusal(uri, "the file holds coordinates that are not finite or too large (above 3e38)")
        attributes = {"POSITION": self._array(vertices, _FLOAT, "VEC3", bounds=True)}
        if piece.normals is not None:
            attributes["NORMAL"] = self._array(piece.normals.astype(np.float32), _FLOAT, "VEC3")
        if piece.vertex_colors is not None:
            # In linear light 8 bits could not tell the dark colours apart.
            light = piece.vertex_colors / 255.0
            light[:, :3] = to_linear(light[:, :3])
            colors = np.round(65535.0 * light).astype(np.uint16)
            attributes["COLOR_0"] = self._array(colors, _UNSIGNED_SHORT, "VEC4", normalized=True)
        if piece.uv is not None:
            # glTF counts from the image's upper left corner.
            uv = np.column_stack([piece.uv[:, 0], 1.0 - piece.uv[:, 1]]).astype(np.float32)
            attributes["TEXCOORD_0"] = self._array(uv, _FLOAT, "VEC2")
        faces = np.ascontiguousarray(piece.faces, np.uint32).reshape(-1)
        primitive: dict[str, Any] = {
            "attributes": attributes,
            "indices": self._array(faces, _UNSIGNED_INT, "SCALAR", target=_ELEMENT_ARRAY_BUFFER),
        }
        if piece.color is not None or piece.texture is not None:
            primitive["material"] = self._material(piece)
        self._tree["nodes"].append({"mesh": len(self._tree["meshes"])})
        self._tree["meshes"].append({"primitives": [primitive]})

    def _material(self, piece: Piece) -> int:
        color = piece.color or (1.0, 1.0, 1.0, 1.0)
        factor = [*to_linear(color[:3]).tolist(), float(color[3])]
        look: dict[str, Any] = {"baseColorFactor": factor, "metallicFactor": 0.0, "roughnessFactor": 0.8}
        if piece.texture is not None:
            kind = "image/png" if piece.texture.startswith(b"\x89PNG") else "image/jpeg"
            images, textures = self._tree.setdefault("images", []), self._tree.setdefault("textures", [])
            look["baseColorTexture"] = {"index": len(textures)}
            textures.append({"source": len(images)})
            images.append({"bufferView": self._view(piece.texture), "mimeType": kind})
        materials = self._tree.setdefault("materials", [])
        material: dict[str, Any] = {"pbrMetallicRoughness": look, "doubleSided": True}
        if color[3] < 1.0:
            material["alphaMode"] = "BLEND"
        materials.append(material)
        return len(materials) - 1

    def _array(
        self,
        array: NDArray,
        component: int,
        kind: str,
        *,
        target: int = _ARRAY_BUFFER,
        bounds: bool = False,
        normalized: bool = False,
    ) -> int:
        accessor: dict[str, Any] = {
            "bufferView": self._view(np.ascontiguousarray(array).tobytes(), target),
            "componentType": component,
            "count": len(array),
            "type": kind,
        }
        if bounds:
            accessor["min"], accessor["max"] = array.min(axis=0).tolist(), array.max(axis=0).tolist()
        if normalized:
            accessor["normalized"] = True
        self._tree["accessors"].append(accessor)
        return len(self._tree["accessors"]) - 1

    def _view(self, data: bytes, target: int | None = None) -> int:
        view: dict[str, Any] = {"buffer": 0, "byteOffset": self._size, "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        padded = data + b"\0" * (-len(data) % 4)
        self._chunks.append(padded)
        self._size += len(padded)
        self._tree["bufferViews"].append(view)
        return len(self._tree["bufferViews"]) - 1

    def finish(self) -> bytes:
        tree = {
            "asset": {"version": "2.0", "generator": "VirtualRobot"},
            "scene": 0,
            "scenes": [{"nodes": list(range(len(self._tree["nodes"])))}],
            **self._tree,
            "buffers": [{"byteLength": self._size}],
        }
        return pack_glb(tree, b"".join(self._chunks))


def pack_glb(tree: dict[str, Any], binary: bytes) -> bytes:
    """Return the GLB file of a glTF tree and its one buffer."""
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    length = 12 + 8 + len(text) + 8 + len(binary)
    head = struct.pack("<III", _MAGIC, 2, length)
    return b"".join(
        [head, struct.pack("<II", len(text), _JSON_CHUNK), text, struct.pack("<II", len(binary), _BINARY_CHUNK), binary]
    )


def unpack_glb(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the glTF tree and the buffer of a GLB file that was just written here or by a library."""
    length = struct.unpack_from("<I", data, 12)[0]
    rest = data[20 + length :]
    return json.loads(data[20 : 20 + length]), rest[8:]
