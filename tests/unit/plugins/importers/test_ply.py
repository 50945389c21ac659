"""PLY and OFF: real files, and small ones with the colours of vertices and faces and a texture."""

import io
import re
from pathlib import Path

import numpy as np
import pytest
import rtbdata
from PIL import Image
from virtualrobot_plugins.importers.ply import OffImporter, PlyImporter
from virtualrobot_sdk.errors import FilesNeeded

from tests.unit.plugins.importers.reading import FILES, area, bounds, meshes, parts, refusal, volume

WALLE = Path(rtbdata.__file__).parent / "data" / "test-mesh" / "walle2.ply"

CORNERS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"


def header(faces: int, vertex: tuple[str, ...] = (), face: tuple[str, ...] = (), comment: str = "by hand") -> str:
    """Return the header of a text file with four vertices, their properties besides x, y, z and those of faces."""
    lines = ["ply", "format ascii 1.0", f"comment {comment}", "element vertex 4"]
    lines += [f"property float {axis}" for axis in ("x", "y", "z", *vertex)]
    lines += [f"element face {faces}", "property list uchar int vertex_indices"]
    lines += [f"property uchar {name}" for name in face]
    return "\n".join([*lines, "end_header", ""])


def test_a_real_scan_of_vcglib_s() -> None:
    data = WALLE.read_bytes()
    pieces = meshes(PlyImporter(), data, "walle2.ply")
    head, _, body = data.partition(b"end_header\n")
    counts = {name: int(count) for name, count in re.findall(rb"element (\w+) (\d+)", head)}
    assert sum(len(piece.faces) for piece in pieces) == counts[b"face"] == 86413
    # It says: x, y, z as float, then red, green, blue, alpha as bytes; faces: a byte 3 and three integers.
    vertex = np.dtype([("position", "<f4", 3), ("color", "u1", 4)])
    face = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
    vertices = np.frombuffer(body, vertex, counts[b"vertex"])
    faces = np.frombuffer(body, face, counts[b"face"], vertex.itemsize * counts[b"vertex"])["corners"]
    used = vertices["position"][faces].reshape(-1, 3)
    assert bounds(pieces) == pytest.approx(np.array([used.min(axis=0), used.max(axis=0)]))
    (piece,) = pieces
    assert piece.vertex_colors is not None
    assert np.array_equal(piece.vertex_colors[piece.faces], vertices["color"][faces])


@pytest.mark.parametrize(("importer", "name"), [(PlyImporter(), "torus.ply"), (OffImporter(), "torus.off")])
def test_the_torus_of_meshlab(importer: PlyImporter | OffImporter, name: str) -> None:
    pieces = meshes(importer, (FILES / name).read_bytes(), name)
    assert volume(pieces) == pytest.approx(0.05091169, rel=1e-5)  # MeshLab's geometric measures
    assert area(pieces) == pytest.approx(1.121652, rel=1e-5)
    if name == "torus.ply":  # MeshLab was told: red where z > 0, blue where x > 0
        (piece,) = pieces
        assert piece.vertex_colors is not None
        assert np.array_equal(piece.vertex_colors[:, 0], 255 * (piece.vertices[:, 2] > 0.0))
        assert (piece.vertex_colors[:, 1] == 128).all()


def test_colours_of_faces() -> None:
    data = header(2, face=("red", "green", "blue")) + CORNERS + "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n"
    (piece,) = meshes(PlyImporter(), data, "x.ply")
    assert piece.vertex_colors is not None
    assert piece.vertex_colors[piece.faces][:, 0, :3].tolist() == [[255, 0, 0], [0, 0, 255]]


def textured() -> str:
    corners = "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n"
    return header(1, vertex=("s", "t"), comment="TextureFile wood.png") + corners + "4 0 1 2 3\n"


def test_a_texture() -> None:
    image = io.BytesIO()
    Image.new("RGB", (2, 2), (10, 20, 30)).save(image, "PNG")
    with pytest.raises(FilesNeeded) as needed:
        PlyImporter().translate(textured().encode(), "x.ply", {})
    assert needed.value.names == ("wood.png",)
    (piece,) = meshes(PlyImporter(), textured(), "x.ply", {"wood.png": image.getvalue()})
    assert piece.texture is not None and piece.uv is not None
    assert piece.uv[piece.faces] == pytest.approx(piece.vertices[piece.faces][:, :, :2])
    without = PlyImporter().translate(textured().encode(), "x.ply", {"wood.png": None})
    assert without.warnings == ("x.ply: the texture wood.png is not there; drawn without it",)
    assert parts(without)[0].texture is None
    odd = PlyImporter().translate(textured().encode(), "x.ply", {"wood.png": b"BM"})
    assert odd.warnings == ("x.ply: the texture wood.png is no PNG or JPEG file; drawn without it",)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ("solid x", "has no header"),
        (header(0) + CORNERS, "but no face"),
        (header(99999999999) + CORNERS, "announces 99999999999 of face"),
        (header(1) + CORNERS + "3 0 1 7\n", "x.ply: "),
        (header(1) + CORNERS.replace("0 0 0", "0 0 nan") + "3 0 1 2\n", "finite"),
    ],
)
def test_refusals(data: str, words: str) -> None:
    assert words in refusal(PlyImporter(), data, "x.ply")


def test_what_is_no_off_file() -> None:
    assert "does not begin with OFF" in refusal(OffImporter(), "3 1 0", "x.off")
    assert refusal(OffImporter(), "OFF\n3 1 0\n0 0 0\n1 0 0\n", "x.off").startswith("x.off: ")
