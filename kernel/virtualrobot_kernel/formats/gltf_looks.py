"""Colours of glTF files, which are linear light there, as screens show them (sRGB).

Trimesh rounds materials to 8 bits, by which up to 11 of sRGB's dark levels become one, and keeps the low byte only of
vertices' colours of 16 bits. So it is given the file with its materials numbered, and with the vertices' colours under
a name that it hands on as they are. What is left is the rounding of vertices' colours to 8 bits of sRGB.

Source: Khronos Group, glTF 2.0 Specification, 3.7.2.1 (COLOR_0), 3.9.2 (baseColorFactor) and 4.4 (GLB).
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.srgb import from_linear

from virtualrobot_kernel.formats.references import ending, gltf_json
from virtualrobot_kernel.formats.xml import malformed

COLORS = "_VIRTUALROBOT_COLOR_0"
"""Attribute under which trimesh hands on the colours of vertices; other names with `_` are the file's own."""

_TRIANGLE_MODES = (4, 5)  # 3.7.2.1; without a mode it is 4. Trimesh hands attributes of no others on.
_OTHER_WORKFLOW = "KHR_materials_pbrSpecularGlossiness"


def prepared(data: bytes, uri: str) -> tuple[bytes, list[NDArray[np.float64] | None]]:
    """Return the file as trimesh is to read it, and each material's factor: (4,) linear light and opacity.

    The materials are named by their numbers. A factor is None where an extension tells the colour instead.
    Raises MalformedFileError when there is no JSON in it, and whatever one of odd types makes Python raise.
    """
    tree = gltf_json(data, uri)
    for number, accessor in enumerate(tree.get("accessors", [])):
        if "bufferView" not in accessor:  # 3.6.2.3: all its numbers are 0, but for those that it tells apart
            raise malformed(uri, None, f"accessors[{number}] has no bufferView; sparse ones are not read")
    factors: list[NDArray[np.float64] | None] = []
    for number, material in enumerate(tree.get("materials", [])):
        material["name"] = str(number)
        factor = material.get("pbrMetallicRoughness", {}).get("baseColorFactor", [1.0, 1.0, 1.0, 1.0])
        factors.append(None if _OTHER_WORKFLOW in material.get("extensions", {}) else _finite(factor))
    for mesh in tree.get("meshes", []):
        for primitive in mesh["primitives"]:
            attributes = primitive["attributes"]
            if "COLOR_0" in attributes and primitive.get("mode", 4) in _TRIANGLE_MODES:
                attributes[COLORS] = attributes.pop("COLOR_0")
    text = json.dumps(tree, separators=(",", ":")).encode()
    return (_with_json(data, text) if ending(uri) == ".glb" else text), factors


def color(factor: NDArray) -> tuple[float, float, float, float]:
    """Return a factor (4,) as sRGB and opacity, free of the noise of single precision: multiples of 1/255 stay such."""
    red, green, blue, opacity = (np.round(255.0 * _shown(factor), 3) / 255.0).tolist()
    return red, green, blue, opacity


def of_vertices(stored: NDArray, factor: NDArray[np.float64] | None) -> NDArray[np.uint8]:
    """Return colours (n, 3 or 4) of COLOR_0 times the material's factor as sRGB and opacity (n, 4) of 8 bits.

    Integers are normalised, as 3.7.2.1 demands.
    """
    scale = np.iinfo(stored.dtype).max if np.issubdtype(stored.dtype, np.integer) else 1.0
    light = np.ones((len(stored), 4))
    light[:, : stored.shape[1]] = np.nan_to_num(stored.astype(np.float64)) / scale
    if factor is not None:
        light *= factor
    return np.round(255.0 * _shown(light)).astype(np.uint8)


def _shown(light: NDArray) -> NDArray[np.float64]:
    """Return colours (..., 4) of linear light and opacity as sRGB and opacity."""
    return np.concatenate([from_linear(light[..., :3]), np.clip(light[..., 3:], 0.0, 1.0)], axis=-1)


def _finite(factor: Any) -> NDArray[np.float64]:  # noqa: ANN401  whatever JSON holds
    values = np.asarray(factor, np.float64)
    if values.shape != (4,) or not np.isfinite(values).all():
        raise ValueError(f"a baseColorFactor is {factor!r}; it must be four numbers")
    return values


def _with_json(data: bytes, text: bytes) -> bytes:
    """Return a GLB file with another JSON chunk."""
    text += b" " * (-len(text) % 4)
    rest = data[20 + struct.unpack_from("<I", data, 12)[0] :]
    total = 20 + len(text) + len(rest)
    return b"".join([data[:8], struct.pack("<II4s", total, len(text), b"JSON"), text, rest])
