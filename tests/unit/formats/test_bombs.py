"""Small files that would become large: refused in words before they do, or read without what makes them large."""

from __future__ import annotations

import contextlib
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import pytest
from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats import trimesh_reader
from virtualrobot_kernel.formats.meshes import parse_mesh
from virtualrobot_kernel.formats.xml import parse_xml
from virtualrobot_plugins.importers.ply import OffImporter, PlyImporter
from virtualrobot_sdk.errors import ArgumentError

from tests.unit.formats.test_meshes import dae, glb

PLATE = b"mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"


def shown(levels: int, times: int, last: str = '<instance_geometry url="#g"/>') -> bytes:
    """Return a COLLADA file whose nodes each show the next one so many times."""
    nodes = "".join(
        f'<node id="n{level}">' + f'<instance_node url="#n{level + 1}"/>' * times + "</node>" for level in range(levels)
    )
    library = f'<library_nodes>{nodes}<node id="n{levels}">{last}</node></library_nodes><library_visual_scenes>'
    text = dae().decode().replace("<library_visual_scenes>", library)
    return text.replace(
        '<node><instance_geometry url="#g"/></node>', '<node><instance_node url="#n0"/></node>'
    ).encode()


def png(width: int, height: int) -> bytes:
    """Return a black picture: a bit for each pixel, and compressed a thousand times."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    packer = zlib.compressobj(1)
    rows = b"".join([packer.compress(bytes(1 + (width + 7) // 8)) for _ in range(height)]) + packer.flush()
    head = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def repeated(count: int) -> bytes:
    """Return an OBJ file with a triangle in each of so many objects."""
    return b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"".join(b"o n%d\nf 1 2 3\n" % number for number in range(count))


BOMBS = {
    "laughs.dae": (shown(60, 10), "comes to more than 100,000 shapes"),
    "itself.dae": (shown(3, 1, '<instance_node url="#n1"/>'), "the node shows itself"),
    "itself-at-once.dae": (shown(0, 1, '<instance_node url="#n0"/>'), "the node shows itself"),
    "deep.dae": (b"<COLLADA>" + b"<a>" * 50_000 + b"</a>" * 50_000 + b"</COLLADA>", "Excessive depth"),
    "many.obj": (repeated(10_001), "has 10,001 objects"),
    "header.stl": (bytes(80) + b"\xff\xff\xff\xff" + bytes(50), "holds no triangle|broken"),
    "header.glb": (b"glTF" + struct.pack("<IIII", 2, 2**32 - 1, 2**32 - 16, 0x4E4F534A) + b"{}", "cut off"),
    "count.glb": (glb().replace(b'"count": 4, ', b'"count":9e9,'), "broken"),
    "deep.gltf": (b'{"extras":' + b"[" * 50_000 + b"]" * 50_000 + b"}", "not glTF"),
}


@pytest.mark.parametrize("name", BOMBS)
def test_a_bomb_is_refused(name: str) -> None:
    data, said = BOMBS[name]
    with pytest.raises(MalformedFileError, match=said):
        parse_mesh(data, name)


def test_nodes_that_show_nodes_are_read_while_they_are_few() -> None:
    (part, *others) = parse_mesh(shown(3, 2), "eight.dae")
    assert len([part, *others]) == 8


def test_a_shape_counts_each_time_that_it_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trimesh_reader, "MOST_TRIANGLES", 31)
    with pytest.raises(MalformedFileError, match="the file shows 32 triangles; at most 31 are read"):
        parse_mesh(shown(3, 2), "eight.dae")
    monkeypatch.setattr(trimesh_reader, "MOST_TRIANGLES", 32)
    assert len(parse_mesh(shown(3, 2), "eight.dae")) == 8


@pytest.mark.parametrize("edge", [10_000, 40_000])
def test_a_picture_with_too_many_pixels_is_left_out(edge: int) -> None:
    """Above 8192 x 8192 pixels by our limit, and far above it by Pillow's, which raises as it is opened."""
    bomb = png(edge, edge)
    assert len(bomb) < 1_500_000
    (part,) = parse_mesh(PLATE, "o.obj", {"m.mtl": b"newmtl a\nKd 1 0 0\nmap_Kd t.png\n", "t.png": bomb})
    assert part.texture is None
    small = png(16, 16)
    (part,) = parse_mesh(PLATE, "o.obj", {"m.mtl": b"newmtl a\nKd 1 0 0\nmap_Kd t.png\n", "t.png": small})
    assert part.texture == small


DECLARED = '<!DOCTYPE r [<!ENTITY a "x">]><robot name="&a;"/>'
ENTITIES = {
    "long and often": f'<!DOCTYPE r [<!ENTITY a "{"x" * 50_000}">]><robot name="{"&a;" * 50_000}"/>'.encode(),
    "of a parameter": b'<!DOCTYPE r [<!ENTITY % a "<!ENTITY b \'x\'>">%a;]><robot name="&b;"/>',
    "in UTF-16": f'<?xml version="1.0" encoding="utf-16"?>{DECLARED}'.encode("utf-16"),
    "in UTF-7": b'<?xml version="1.0" encoding="utf-7"?>' + DECLARED.encode("utf-7"),
}


@pytest.mark.parametrize("name", ENTITIES)
def test_entities_of_each_kind_are_refused(name: str) -> None:
    with pytest.raises(MalformedFileError, match="entities"):
        parse_xml(ENTITIES[name], "r.urdf")


def test_a_document_type_elsewhere_is_not_fetched(tmp_path: Path) -> None:
    (tmp_path / "r.dtd").write_text('<!ENTITY a "told">')
    text = f'<!DOCTYPE robot SYSTEM "{(tmp_path / "r.dtd").as_uri()}"><robot name="r">&a;</robot>'
    with contextlib.suppress(MalformedFileError):
        assert "told" not in "".join(parse_xml(text.encode(), "r.urdf").itertext())


FOREIGN = {
    "header.ply": (PlyImporter, b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
                   b"property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                   b"end_header\n" + bytes(64)),
    "header.off": (OffImporter, b"OFF\n4000000000 4000000000 0\n0 0 0\n"),
}  # fmt: skip


@pytest.mark.parametrize("name", FOREIGN)
def test_a_bomb_of_a_format_that_is_translated_is_refused(name: str) -> None:
    importer, data = FOREIGN[name]
    with pytest.raises(ArgumentError):
        importer().translate(data, name, {})


CHILD = """
import resource, sys
from tests.unit.formats.test_bombs import BOMBS, ENTITIES, PLATE, png
from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats.meshes import parse_mesh
from virtualrobot_kernel.formats.xml import parse_xml
parse_mesh(PLATE, "o.obj")
picture = {"m.mtl": b"newmtl a\\nKd 1 0 0\\nmap_Kd t.png\\n", "t.png": png(40_000, 40_000)}
def mebibytes():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
before = mebibytes()
for name, (data, _) in BOMBS.items():
    try:
        parse_mesh(data, name)
    except MalformedFileError:
        print(name, mebibytes() - before)
for name, data in ENTITIES.items():
    try:
        parse_xml(data, "r.urdf")
    except MalformedFileError:
        print(name, mebibytes() - before)
parse_mesh(PLATE, "o.obj", picture)
print("picture", mebibytes() - before)
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="Windows tells no peak of memory this way")
def test_no_bomb_takes_memory() -> None:
    """All of them in one process that has read a small file before: it grows by less than 100 MiB."""
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run([sys.executable, "-c", CHILD], capture_output=True, text=True, timeout=300, cwd=root)
    assert done.returncode == 0, done.stderr
    grown = [line.rpartition(" ") for line in done.stdout.splitlines()]
    assert [name for name, _, _ in grown] == [*BOMBS, *ENTITIES, "picture"]
    assert max(float(amount) for _, _, amount in grown) < 100.0
