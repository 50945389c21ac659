"""OBJ files read by compiled code against trimesh's parser: the same triangles, normals, coordinates and looks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pybullet_data
import pytest
from trimesh.resolvers import FilePathResolver
from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats import obj, trimesh_reader
from virtualrobot_kernel.formats.meshes import parse_mesh
from virtualrobot_kernel.numeric.wavefront import read_faces
from virtualrobot_kernel.shapes.submesh import Submesh

from tests.tiers import Draws

BUNDLED = sorted(Path(pybullet_data.getDataPath()).rglob("*.obj"))
LOOKS = (".mtl", ".png", ".jpg")
MATERIALS = "newmtl rød\nKd 0 1 0\n".encode() + b"newmtl red\nKd 1 0 0\nnewmtl half\nKd 0 0 1\nd 0.5\n"

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
UV = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
NORMAL = "vn 0 0 1\nvn 0 0 -1\n"
FAST = {
    "corners": SQUARE + "f 1 2 3\nf 1 3 4\n",
    "polygon": SQUARE + "v 0 0.5 0\nf 1 2 3 4 5\nf 1 2 3\n",
    "quads": SQUARE + "f 1 2 3 4\nf 4 3 2 1\n",
    "uv": SQUARE + UV + "f 1/1 2/2 3/3\n",
    "three coordinates of a texture": SQUARE + UV.replace("\n", " 0\n") + "f 1/1 2/2 3/3\n",
    "normals": SQUARE + NORMAL + "f 1//1 2//1 3//2\n",
    "all": SQUARE + UV + NORMAL + "f 1/4/1 2/3/1 3/2/2\nf 1/4/1 2/3/1 4/1/1\n",
    "corners of several forms": SQUARE + UV + NORMAL + "f 1/1/1 2/2/1 3/3/1\nf 1//1 3//1 4//1\n",
    "materials": "mtllib looks.mtl\n"
    + SQUARE
    + "f 1 2 3\nusemtl half\nf 1 3 4\nusemtl red\nf 2 3 4\nusemtl half\nf 1 2 4\n",
    "forms by material": "mtllib looks.mtl\n" + SQUARE + UV + "usemtl red\nf 1/1 2/2 3/3\nusemtl half\nf 1 3 4\n",
    "unknown material": SQUARE + "usemtl gold\nf 1 2 3\n",
    "other lines": "# said\no box\ng left\ns off\n" + SQUARE + "l 1 2\np 3\n\n   \nf 1 2 3\n# done",
    "lines of Windows": (SQUARE + NORMAL + "f 1//1 2//1 3//1\n").replace("\n", "\r\n"),
    "spaces and tabs": "v  0\t0 0 \nv 1 0 0\t\nv 1 1   0\nf  1 2\t3  \n",
    "not ASCII": "mtllib looks.mtl\no 机身\n" + SQUARE + "usemtl rød\nf 1 2 3\nusemtl red\nf 1 3 4\n",
    "no line end": SQUARE + "f 1 2 3",
    "numbers": "v -0.0 +1. .5\nv 1e-3 -2.5E+2 3.25e1\nv 0.1234567890123 12345678.9 1e-30\nf 1 2 3\n",
}
SLOW = {
    "colours": "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nf 1 2 3\n",
    "continued": SQUARE + "f 1 2 \\\n3\n",
    "from the end": SQUARE + "f -4 -3 -2\n",
    "another encoding": ("# Würfel\n" + SQUARE + "f 1 2 3\n").encode("latin-1"),
    "lines that end otherwise": SQUARE + "# 1\u20282\x853\nf 1 2 3\n",
}
BROKEN = {
    "no such vertex": SQUARE + "f 1 2 9\n",
    "no number": "v 0 0 x\nv 1 0 0\nv 1 1 0\nf 1 2 3\n",
    "two numbers": "v 0 0\nv 1 0\nv 1 1\nf 1 2 3\n",
    "not finite": "v nan 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n",
    "no triangle": SQUARE,
    "nothing": "",
}


def triangles(part: Submesh) -> list[bytes]:
    """Return the corners of each triangle, with all that is theirs; in one order, from one corner on."""
    own = [one for one in (part.vertices, part.normals, part.uv) if one is not None]
    corners = np.concatenate([one[part.faces] for one in own], axis=2) + np.float32(0.0)
    return sorted(min(np.roll(one, turn, axis=0).tobytes() for turn in range(3)) for one in corners)


def assert_same(ours: tuple[Submesh, ...], theirs: tuple[Submesh, ...]) -> None:
    """Assert that two readings show the same, bit for bit."""
    assert [(part.color, part.texture) for part in ours] == [(part.color, part.texture) for part in theirs]
    for one, other in zip(ours, theirs, strict=True):
        assert triangles(one) == triangles(other)


def both(data: bytes, uri: str, files: dict[str, bytes]) -> tuple[tuple[Submesh, ...], tuple[Submesh, ...]]:
    """Return what compiled code and trimesh read."""
    ours = parse_mesh(data, uri, files)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(obj, "read", lambda data, files: None)
        return ours, parse_mesh(data, uri, files)


@pytest.mark.long
def test_bundled_files_are_read_as_trimesh_reads_them(rng: np.random.Generator, draws: Draws) -> None:
    """Nearly all of them without trimesh's parser, those of the Panda and the A1 among them."""
    chosen = rng.choice(len(BUNDLED), draws(200), replace=False)
    files = [path for path in BUNDLED if {"franka_panda", "a1"} & {*path.parts}] + [BUNDLED[i] for i in chosen]
    read = 0
    for path in files:
        data = path.read_bytes()
        looks = {one.name: one.read_bytes() for one in path.parent.iterdir() if one.suffix.lower() in LOOKS}
        assert_same(*both(data, path.name, looks))
        read += read_faces(np.frombuffer(data, np.uint8))[0]
    assert read >= 0.9 * len(files)


@pytest.mark.parametrize("name", FAST)
def test_what_the_format_has_is_read(name: str) -> None:
    data = FAST[name].encode()
    assert read_faces(np.frombuffer(data, np.uint8))[0]
    ours, theirs = both(data, "part.obj", {"looks.mtl": MATERIALS})
    assert_same(ours, theirs)
    assert sum(len(part.faces) for part in ours) > 0


@pytest.mark.parametrize("name", SLOW)
def test_what_is_rare_is_left_to_trimesh(name: str) -> None:
    text = SLOW[name]
    data = text if isinstance(text, bytes) else text.encode()
    assert obj.read(data, FilePathResolver("part.obj")) is None
    assert parse_mesh(data, "part.obj", {})


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_wrong_is_told_as_ever(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(MalformedFileError) as ours:
        parse_mesh(BROKEN[name].encode(), "part.obj", {})
    monkeypatch.setattr(obj, "read", lambda data, files: None)
    with pytest.raises(MalformedFileError) as theirs:
        parse_mesh(BROKEN[name].encode(), "part.obj", {})
    assert str(ours.value) == str(theirs.value)


def test_numbers_are_those_of_python(rng: np.random.Generator) -> None:
    """Of up to 15 digits and powers up to 22 to the last bit, whose parts are exact; longer ones to one of it.

    W. D. Clinger, How to read floating point numbers accurately, PLDI 1990.
    """
    short = [f"{rng.uniform(-1, 1) * 10.0**power:.{digits}g}" for power in range(-8, 8) for digits in range(1, 16)]
    read = read_faces(np.frombuffer("".join(f"v {one} 0 0\n" for one in short).encode(), np.uint8))[1]
    assert read[:, 0].tolist() == [float(one) for one in short]
    long = [repr(value * 10.0**power) for power in range(-60, 60) for value in rng.uniform(-1, 1, 5).tolist()]
    read = read_faces(np.frombuffer("".join(f"v {one} 0 0\n" for one in long).encode(), np.uint8))[1]
    np.testing.assert_allclose(read[:, 0], [float(one) for one in long], rtol=4e-16)


def test_bytes_of_all_kinds_end_it(rng: np.random.Generator, draws: Draws) -> None:
    """Files cut anywhere, with bytes put anywhere, are read or not, within their bounds."""
    whole = np.frombuffer((FAST["materials"] + FAST["all"] + FAST["polygon"]).encode(), np.uint8)
    letters = np.frombuffer(b"vfntu slo/0123456789.-+eE\n\r\t\\#\x00\xff", np.uint8)
    for _ in range(draws(5000)):
        text = whole[: rng.integers(len(whole) + 1)].copy()
        places = rng.integers(0, max(len(text), 1), 3) if len(text) else []
        text[places] = rng.choice(letters, len(places))
        is_all, vertices, uvs, normals, corners, uses = read_faces(text)
        if is_all:
            assert len(corners) % 3 == 0 and (corners[:, 0] >= 0).all()
            assert (corners < [len(vertices), max(len(uvs), 1), max(len(normals), 1)]).all()
            assert (uses[:, 0] <= len(corners)).all()


@pytest.mark.parametrize("line", ["usemtl red\n", "o box\n"])
def test_too_many_pieces_are_refused_at_once(line: str) -> None:
    most = trimesh_reader.MOST_PIECES
    assert parse_mesh((SQUARE + "f 1 2 3\n" + line * most + "f 1 3 4\n").encode(), "part.obj", {})
    with pytest.raises(MalformedFileError, match=f"the file has {most + 1:,} objects or uses of materials"):
        parse_mesh((SQUARE + "f 1 2 3\n" + line * (most + 1)).encode(), "part.obj", {})
