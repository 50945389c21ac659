"""What is written as GLB is what the kernel reads."""

import io

import numpy as np
import pytest
from PIL import Image
from virtualrobot_kernel.formats.meshes import parse_mesh
from virtualrobot_plugins.importers.glb import Piece, placed, unit, write_glb
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.glb import unpack_glb

from tests.unit.formats.models import TETRAHEDRON, TETRAHEDRON_FACES

RED = (1.0, 0.0, 0.0, 1.0)


def test_positions_faces_and_colour(rng: np.random.Generator) -> None:
    points = rng.uniform(-5.0, 5.0, (20, 3))
    faces = np.array([rng.permutation(20)[:3] for _ in range(30)])
    color = (*rng.uniform(0.0, 1.0, 3).tolist(), 0.2)
    (part,) = parse_mesh(write_glb([Piece(points, faces, color)], "x"), "x.glb")
    assert np.array_equal(part.vertices[part.faces], points.astype(np.float32)[faces])
    assert part.color == pytest.approx(color, abs=3e-6)
    assert part.normals is None and part.vertex_colors is None and part.texture is None


def test_the_file_holds_linear_light() -> None:
    """Khronos, glTF 2.0 specification, 3.7.2.1 and 3.9.2; by IEC 61966-2-1 half of the light is 8-bit 188, 0.735."""
    colors = np.array([[188, 10, 255, 128]] * 3 + [[0, 188, 1, 255]], np.uint8)
    pieces = [
        Piece(TETRAHEDRON, TETRAHEDRON_FACES, (188 / 255, 10 / 255, 0.0, 0.3)),
        Piece(TETRAHEDRON, TETRAHEDRON_FACES, vertex_colors=colors),
    ]
    tree, binary = unpack_glb(write_glb(pieces, "x"))
    factor = tree["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"]
    assert factor == pytest.approx([0.5029, 10 / 255 / 12.92, 0.0, 0.3], abs=1e-4)
    accessor = tree["accessors"][tree["meshes"][1]["primitives"][0]["attributes"]["COLOR_0"]]
    start = tree["bufferViews"][accessor["bufferView"]]["byteOffset"]
    stored = np.frombuffer(binary, np.uint16, 16, start).reshape(4, 4) / 65535.0
    assert accessor["normalized"] is True and accessor["componentType"] == 5123
    assert stored[0] == pytest.approx([0.5029, 10 / 255 / 12.92, 1.0, 128 / 255], abs=1e-4)
    assert stored[3] == pytest.approx([0.0, 0.5029, 1 / 255 / 12.92, 1.0], abs=1e-4)


def test_pieces_of_one_look_are_one_mesh() -> None:
    one, other = Piece(TETRAHEDRON, TETRAHEDRON_FACES, RED), Piece(TETRAHEDRON + 1.0, TETRAHEDRON_FACES, RED)
    blue = Piece(TETRAHEDRON + 2.0, TETRAHEDRON_FACES, (0.0, 0.0, 1.0, 1.0))
    parts = parse_mesh(write_glb([one, blue, other], "x"), "x.glb")
    assert sorted(len(part.faces) for part in parts) == [4, 8]


def test_colours_of_vertices_normals_and_texture(rng: np.random.Generator) -> None:
    count = 12
    points, faces = rng.uniform(-1.0, 1.0, (count, 3)), np.arange(count).reshape(-1, 3)
    colors = rng.integers(0, 256, (count, 4), dtype=np.uint8)
    normals = unit(rng.normal(size=(count, 3)))
    (part,) = parse_mesh(write_glb([Piece(points, faces, None, normals, colors)], "x"), "x.glb")
    assert part.vertex_colors is not None and part.normals is not None
    assert np.array_equal(part.vertex_colors[part.faces].reshape(-1, 4), colors)
    assert part.normals[part.faces].reshape(-1, 3) == pytest.approx(normals, abs=1e-6)

    image = io.BytesIO()
    Image.fromarray(rng.integers(0, 256, (4, 4, 3), dtype=np.uint8)).save(image, "PNG")
    uv = rng.uniform(0.0, 1.0, (count, 2))
    piece = Piece(points, faces, (1.0, 1.0, 1.0, 1.0), uv=uv, texture=image.getvalue())
    (part,) = parse_mesh(write_glb([piece], "x"), "x.glb")
    assert part.uv is not None and part.texture is not None
    assert part.uv[part.faces].reshape(-1, 2) == pytest.approx(uv, abs=1e-6)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(part.texture))), np.asarray(Image.open(image)))


def test_a_mirror_keeps_outside_out() -> None:
    mirrored = placed(Piece(TETRAHEDRON, TETRAHEDRON_FACES), np.diag([-2.0, 1.0, 1.0, 1.0]))
    a, b, c = np.moveaxis(mirrored.vertices[mirrored.faces], 1, 0)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0 == pytest.approx(2 * 0.001)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e39])
def test_what_no_position_is_is_refused(value: float) -> None:
    points = TETRAHEDRON.copy()
    points[2, 1] = value
    with pytest.raises(ArgumentError, match=r"^x\.wrl: the file holds coordinates that are not finite"):
        write_glb([Piece(points, TETRAHEDRON_FACES)], "folder/x.wrl")


def test_no_triangle_and_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ArgumentError, match="holds no triangle"):
        write_glb([Piece(TETRAHEDRON, np.zeros((0, 3), int))], "x")
    monkeypatch.setattr("virtualrobot_plugins.importers.glb.MAX_TRIANGLES", 3)
    with pytest.raises(ArgumentError, match="makes 4 triangles; at most 3 are read"):
        write_glb([Piece(TETRAHEDRON, TETRAHEDRON_FACES)], "x")
