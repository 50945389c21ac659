"""One mesh as binary glTF: the form in which a browser gets triangles with their normals and their look."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.glb import ARRAY_BUFFER, ELEMENT_BUFFER, ROUGHNESS, Buffers, material, pack_glb, upright
from virtualrobot_sdk.srgb import to_linear


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
    binary = Buffers()
    attributes = {
        "POSITION": binary.add(np.asarray(vertices, np.float32), "VEC3", ARRAY_BUFFER, bounds=True),
        "NORMAL": binary.add(np.asarray(normals, np.float32), "VEC3", ARRAY_BUFFER),
    }
    if vertex_colors is not None:
        attributes["COLOR_0"] = binary.add(to_linear(vertex_colors).astype(np.float32), "VEC3", ARRAY_BUFFER)
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
    }
    if uv is not None and texture is not None:
        attributes["TEXCOORD_0"] = binary.add(upright(np.asarray(uv)), "VEC2", ARRAY_BUFFER)
        document["images"] = [{"bufferView": binary.append(texture), "mimeType": "image/png"}]
        document["textures"] = [{"source": 0}]
    indices = binary.add(np.asarray(faces, np.uint32).reshape(-1), "SCALAR", ELEMENT_BUFFER)
    document["materials"] = [material(color, roughness, 0 if "textures" in document else None)]
    document["meshes"] = [{"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}]
    document["accessors"] = binary.accessors
    document["bufferViews"] = binary.views
    document["buffers"] = [{"byteLength": len(binary.data)}]
    return pack_glb(document, binary.data)
