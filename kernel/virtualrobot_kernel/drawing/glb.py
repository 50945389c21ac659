"""Binary glTF 2.0 written by hand: the form in which a browser gets triangles with their normals and their look.

Source of the layout: Khronos Group, glTF 2.0 Specification, sections 3 (properties) and 4 (GLB file format).
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

ARRAY_BUFFER, ELEMENT_BUFFER = 34962, 34963
FLOAT32, UINT32 = 5126, 5125
ROUGHNESS = 0.62
"""Between plaster (1) and a mirror (0): painted metal under a lamp."""


def linear(color: NDArray | tuple[float, ...]) -> NDArray[np.float32]:
    """Return sRGB parts (..., 3) from 0 to 1 as linear light, which glTF wants (IEC 61966-2-1)."""
    parts = np.clip(np.asarray(color, np.float64), 0.0, 1.0)
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4).astype(np.float32)


def encode(
    vertices: NDArray,
    normals: NDArray,
    faces: NDArray,
    *,
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0),
    vertex_colors: NDArray | None = None,
    uv: NDArray | None = None,
    texture: bytes | None = None,
    roughness: float = ROUGHNESS,
) -> bytes:
    """Return a GLB file with one mesh of one material, seen from both sides.

    Args:
        vertices: (n, 3) meters.
        normals: (n, 3) unit vectors.
        faces: (m, 3) rows of `vertices`.
        color: red, green, blue (sRGB) and alpha from 0 to 1, a factor on the other colours.
        vertex_colors: (n, 3) sRGB from 0 to 1.
        uv: (n, 2) texture coordinates, origin at the image's lower left corner.
        texture: PNG.
        roughness: of the surface, 0 to 1.
    """
    binary = _Binary()
    attributes = {
        "POSITION": binary.add(np.asarray(vertices, np.float32), "VEC3", ARRAY_BUFFER, bounds=True),
        "NORMAL": binary.add(np.asarray(normals, np.float32), "VEC3", ARRAY_BUFFER),
    }
    if vertex_colors is not None:
        attributes["COLOR_0"] = binary.add(linear(vertex_colors), "VEC3", ARRAY_BUFFER)
    surface: dict[str, Any] = {
        "baseColorFactor": [*linear(color[:3]).tolist(), float(color[3])],
        "metallicFactor": 0.0,
        "roughnessFactor": roughness,
    }
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
    }
    if uv is not None and texture is not None:
        upright = np.asarray(uv, np.float32) * (1.0, -1.0) + (0.0, 1.0)  # glTF counts v from the upper edge
        attributes["TEXCOORD_0"] = binary.add(upright.astype(np.float32), "VEC2", ARRAY_BUFFER)
        document["images"] = [{"bufferView": binary.append(texture), "mimeType": "image/png"}]
        document["textures"] = [{"source": 0}]
        surface["baseColorTexture"] = {"index": 0}
    indices = binary.add(np.asarray(faces, np.uint32).reshape(-1), "SCALAR", ELEMENT_BUFFER)
    material: dict[str, Any] = {"pbrMetallicRoughness": surface, "doubleSided": True}
    if color[3] < 1.0:
        material["alphaMode"] = "BLEND"
    document["materials"] = [material]
    document["meshes"] = [{"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}]
    document["accessors"] = binary.accessors
    document["bufferViews"] = binary.views
    document["buffers"] = [{"byteLength": len(binary.data)}]
    return _container(document, bytes(binary.data))


class _Binary:
    """Collects the binary chunk and what describes it."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def append(self, chunk: bytes, target: int = 0) -> int:
        """Add bytes, aligned to 4; return the index of their view."""
        self.data.extend(b"\0" * (-len(self.data) % 4))
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(chunk)}
        self.views.append({**view, "target": target} if target else view)
        self.data.extend(chunk)
        return len(self.views) - 1

    def add(self, array: NDArray, kind: str, target: int, bounds: bool = False) -> int:
        """Add an array; return the index of its accessor."""
        accessor: dict[str, Any] = {
            "bufferView": self.append(np.ascontiguousarray(array).tobytes(), target),
            "componentType": UINT32 if array.dtype == np.uint32 else FLOAT32,
            "count": len(array),
            "type": kind,
        }
        if bounds:
            accessor["min"], accessor["max"] = array.min(axis=0).tolist(), array.max(axis=0).tolist()
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def _container(document: dict[str, Any], binary: bytes) -> bytes:
    """Return header, JSON chunk and binary chunk, each padded to 4 bytes."""
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    length = 12 + 8 + len(text) + 8 + len(binary)
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, length),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(binary), b"BIN\0"),
            binary,
        ]
    )
