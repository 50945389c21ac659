"""Binary glTF 2.0, as kernel and plugins write it: the binary chunk with what describes it, materials, the file.

Source of the layout: Khronos Group, glTF 2.0 Specification, sections 3 (properties) and 4 (GLB file format).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_sdk.srgb import to_linear

ARRAY_BUFFER, ELEMENT_BUFFER = 34962, 34963
COMPONENTS: dict[np.dtype[Any], int] = {
    np.dtype(np.int8): 5120,
    np.dtype(np.uint16): 5123,
    np.dtype(np.uint32): 5125,
    np.dtype(np.float32): 5126,
}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
"""Numbers of an element."""
ROUGHNESS = 0.62
"""Between plaster (1) and a mirror (0): painted metal under a lamp."""


class Buffers:
    """Collects the binary chunk and what describes it."""

    def __init__(self) -> None:
        """Begin empty."""
        self.data = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def append(self, chunk: bytes, target: int = 0, stride: int = 0) -> int:
        """Add bytes, aligned to 4; return the index of their view.

        Elements are `stride` bytes apart; 0: side by side.
        """
        self.data.extend(b"\0" * (-len(self.data) % 4))
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(chunk)}
        self.views.append(view | ({"target": target} if target else {}) | ({"byteStride": stride} if stride else {}))
        self.data.extend(chunk)
        return len(self.views) - 1

    def add(self, array: NDArray, kind: str, target: int, bounds: bool = False, normalized: bool = False) -> int:
        """Add an array of a type of COMPONENTS; return the index of its accessor.

        `normalized` integers stand for 0 to 1, those with a sign for -1 to 1. Elements of corners begin at a multiple
        of 4 bytes, as glTF wants.
        """
        columns = WIDTHS[kind]
        padding = -columns * array.itemsize % 4 // array.itemsize if target == ARRAY_BUFFER else 0
        rows = np.hstack([array, np.zeros((len(array), padding), array.dtype)]) if padding else array
        stride = (columns + padding) * array.itemsize if padding else 0
        accessor: dict[str, Any] = {
            "bufferView": self.append(np.ascontiguousarray(rows).tobytes(), target, stride),
            "componentType": COMPONENTS[array.dtype],
            "count": len(array),
            "type": kind,
        }
        if normalized:
            accessor["normalized"] = True
        if bounds:
            accessor["min"], accessor["max"] = array.min(axis=0).tolist(), array.max(axis=0).tolist()
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def add_colors(self, colors: NDArray[np.uint8]) -> int:
        """Add sRGB and opacity (n, 4) of 8 bits; linear light needs 16 to keep the dark ones apart."""
        light = colors / 255.0
        light[:, :3] = to_linear(light[:, :3])
        return self.add(np.round(65535.0 * light).astype(np.uint16), "VEC4", ARRAY_BUFFER, normalized=True)


def material(
    color: Sequence[float], roughness: float, texture: int | None = None, metalness: float = 0.0
) -> dict[str, Any]:
    """Return a material, seen from both sides: sRGB and opacity (4,) from 0 to 1, a factor on a texture (its index)."""
    surface: dict[str, Any] = {
        "baseColorFactor": [*np.round(to_linear(color[:3]), 7).tolist(), float(color[3])],
        "metallicFactor": metalness,
        "roughnessFactor": roughness,
    }
    if texture is not None:
        surface["baseColorTexture"] = {"index": texture}
    look: dict[str, Any] = {"pbrMetallicRoughness": surface, "doubleSided": True}
    return {**look, "alphaMode": "BLEND"} if color[3] < 1.0 else look


def upright(uv: NDArray) -> NDArray[np.float32]:
    """Return texture coordinates (n, 2), counted from the image's lower left corner, as glTF counts: from the upper."""
    return uv.astype(np.float32) * np.array([1, -1], np.float32) + np.array([0, 1], np.float32)


def pack_glb(document: dict[str, Any], binary: bytes | bytearray) -> bytes:
    """Return a GLB file: header, JSON chunk and binary chunk, each padded to 4 bytes."""
    text = ",".join(f"{_json(name)}:{_items(value)}" for name, value in document.items()).join("{}").encode()
    text += b" " * (-len(text) % 4)
    padding = b"\0" * (-len(binary) % 4)
    length = 12 + 8 + len(text) + 8 + len(binary) + len(padding)
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, length),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(binary) + len(padding), b"BIN\0"),
            binary,
            padding,
        ]
    )


def unpack_glb(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the glTF tree and the buffer of a GLB file that a library has just written."""
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def _items(value: Any) -> str:  # noqa: ANN401  whatever JSON holds
    """Return JSON, long lists item by item: a call of the encoder holds up all other threads while it runs."""
    return ",".join(map(_json, value)).join("[]") if isinstance(value, list) else _json(value)


def _json(value: Any) -> str:  # noqa: ANN401  whatever JSON holds
    return json.dumps(value, separators=(",", ":"))
