"""GLB files, read back by trimesh."""

from __future__ import annotations

import io
import json
import struct
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image
from virtualrobot_kernel.drawing.figure_glb import encode
from virtualrobot_kernel.shapes import primitives
from virtualrobot_kernel.shapes.creases import shaded
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_sdk.srgb import to_linear


def document(data: bytes) -> dict:
    """Return the JSON chunk of a GLB file."""
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length])


def attribute(data: bytes, name: str) -> np.ndarray:
    """Return an attribute of three floats a vertex of a GLB file."""
    read = document(data)
    accessor = read["accessors"][read["meshes"][0]["primitives"][0]["attributes"][name]]
    start = 20 + struct.unpack_from("<I", data, 12)[0] + 8 + read["bufferViews"][accessor["bufferView"]]["byteOffset"]
    return np.frombuffer(data, np.float32, 3 * accessor["count"], start).reshape(-1, 3)


def part(**look: object) -> Submesh:
    box = primitives.box()
    return Submesh(box.vertices, box.faces, box.normals, **look)  # pyright: ignore[reportArgumentType]  the test's own


def test_triangles_and_normals_survive() -> None:
    sphere = primitives.sphere()
    (data,) = encode((sphere,), (1.0, 0.0, 0.0, 1.0))
    read = trimesh.load_mesh(io.BytesIO(data), file_type="glb", process=False)
    assert np.array_equal(read.vertices, sphere.vertices)
    assert np.array_equal(read.faces, sphere.faces)
    assert sphere.normals is not None
    assert np.array_equal(attribute(data, "NORMAL"), sphere.normals)
    assert struct.unpack_from("<4sII", data) == (b"glTF", 2, len(data))


def test_srgb_becomes_linear_light() -> None:
    """IEC 61966-2-1: 8-bit 188 is half of the light, 10 lies on the straight part."""
    assert to_linear((188 / 255, 10 / 255, 1.0)) == pytest.approx([0.5029, 10 / 255 / 12.92, 1.0], abs=1e-4)


def test_opaque_parts_of_several_colours_are_one_file() -> None:
    colored = np.tile(np.array([0, 0, 255, 255], np.uint8), (24, 1))
    files = encode(
        (part(color=(1.0, 0.0, 0.0, 1.0)), part(color=(0.0, 1.0, 0.0, 1.0)), part(vertex_colors=colored)), None
    )
    assert len(files) == 1
    assert len(attribute(files[0], "POSITION")) == 72
    colors = attribute(files[0], "COLOR_0").reshape(3, 24, 3)
    assert np.array_equal(colors, np.repeat(np.eye(3)[:, None], 24, axis=1))


def test_a_colour_replaces_the_parts_own() -> None:
    files = encode((part(color=(1.0, 0.0, 0.0, 1.0)), part(color=(0.0, 1.0, 0.0, 1.0))), (0.0, 0.0, 1.0, 1.0))
    assert len(files) == 1
    material = document(files[0])["materials"][0]
    assert material["pbrMetallicRoughness"]["baseColorFactor"] == [0.0, 0.0, 1.0, 1.0]
    assert "alphaMode" not in material


def test_translucent_parts_are_blended_in_files_of_their_own() -> None:
    files = encode((part(color=(1.0, 0.0, 0.0, 0.5)), part(color=(0.0, 1.0, 0.0, 1.0))), None)
    materials = [document(data)["materials"][0] for data in files]
    assert [material.get("alphaMode") for material in materials] == [None, "BLEND"]
    assert materials[1]["pbrMetallicRoughness"]["baseColorFactor"][3] == 0.5


def test_a_texture_comes_along_upright() -> None:
    image = io.BytesIO()
    Image.new("RGB", (2, 2), (10, 200, 30)).save(image, "PNG")
    uv = np.tile(np.array([[0.25, 1.0]], np.float32), (24, 1))
    (data,) = encode((part(uv=uv, texture=image.getvalue()),), None)
    visual: Any = trimesh.load_mesh(io.BytesIO(data), file_type="glb", process=False).visual
    assert np.array_equal(visual.uv, uv)  # trimesh counts v from below, as we do
    assert visual.material.baseColorTexture.getpixel((0, 0))[:3] == (10, 200, 30)


def test_parts_without_normals_get_some_and_keep_their_colours() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
    faces = np.array([[0, 2, 1], [0, 1, 3]], np.int32)
    colors = np.arange(16, dtype=np.uint8).reshape(4, 4)
    made = shaded(Submesh(vertices, faces, vertex_colors=colors))
    assert made.normals is not None and made.vertex_colors is not None
    assert np.array_equal(made.vertices[made.faces], vertices[faces])
    assert np.array_equal(made.vertex_colors[made.faces], colors[faces])
