"""Mesh files against formulas and against what the files themselves say."""

import base64
import json
import re
import struct
import subprocess
import sys

import numpy as np
import pytest
from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats.meshes import parse_mesh, scaled
from virtualrobot_kernel.shapes.submesh import Submesh

from tests.unit.formats.models import DATA, TETRAHEDRON, TETRAHEDRON_FACES, binary_stl, volume

VOLUME = 0.001  # m^3, see TETRAHEDRON


def obj_text(vertices: np.ndarray = TETRAHEDRON) -> str:
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    return "\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in TETRAHEDRON_FACES)])


def ascii_stl() -> bytes:
    corners = (TETRAHEDRON[face] for face in TETRAHEDRON_FACES)
    facets = (
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in three)
        + "endloop\nendfacet\n"
        for three in corners
    )
    return f"solid t\n{''.join(facets)}endsolid t\n".encode()


def dae(unit: str = "", matrix: str = "", up: str = "Z_UP", index: str = "") -> bytes:
    """Return the tetrahedron as COLLADA 1.4.1, in a node with a transform."""
    positions = " ".join(map(str, TETRAHEDRON.ravel()))
    faces = index or " ".join(map(str, TETRAHEDRON_FACES.ravel()))
    transform = f"<matrix>{matrix}</matrix>" if matrix else ""
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset>{unit}<up_axis>{up}</up_axis></asset>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="pa" count="12">{positions}</float_array><technique_common>
      <accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
        <param name="Z" type="float"/></accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node>{transform}<instance_geometry url="#g"/></node></visual_scene>
  </library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


def gltf_tree(buffer: dict[str, object], **node: object) -> dict[str, object]:
    faces = TETRAHEDRON_FACES.astype("<u2").tobytes()
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, **node}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1.0, 0.0, 0.2, 1.0]}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": len(faces)},
        ],
        "buffers": [{"byteLength": 48 + len(faces), **buffer}],
    }


BUFFER = TETRAHEDRON.astype("<f4").tobytes() + TETRAHEDRON_FACES.astype("<u2").tobytes()


def gltf(**node: object) -> bytes:
    uri = "data:application/octet-stream;base64," + base64.b64encode(BUFFER).decode()
    return json.dumps(gltf_tree({"uri": uri}, **node)).encode()


def glb() -> bytes:
    text = json.dumps(gltf_tree({})).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(BUFFER), 0x004E4942) + BUFFER
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


FILES = {
    "t.stl": binary_stl(TETRAHEDRON, TETRAHEDRON_FACES),
    "ascii.stl": ascii_stl(),
    "T.OBJ": obj_text().encode(),
    "t.dae": dae(),
    "t.gltf": gltf(),
    "t.glb": glb(),
}


def in_order(vertices: np.ndarray) -> list[list[float]]:
    """Return positions sorted, rounded to what float32 holds of them."""
    return sorted((vertices.astype(np.float64).round(7) + 0.0).tolist())


def whole(parts: tuple[Submesh, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and faces of all parts together."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts, strict=False)]
    return np.concatenate([part.vertices for part in parts]), np.concatenate(faces)


@pytest.mark.parametrize("name", FILES)
def test_every_format_gives_the_same_tetrahedron(name: str) -> None:
    (part,) = parse_mesh(FILES[name], name)
    assert in_order(part.vertices) == in_order(TETRAHEDRON)
    assert len(part.faces) == 4
    assert volume(part.vertices, part.faces) == pytest.approx(VOLUME, rel=1e-6)
    assert part.vertices.dtype == np.float32 and part.faces.dtype == np.int32


@pytest.mark.parametrize("name", FILES)
def test_arrays_are_read_only(name: str) -> None:
    (part,) = scaled(parse_mesh(FILES[name], name), (1.0, -1.0, 2.0))
    for array in (part.vertices, part.faces, part.normals):
        assert array is None or not array.flags.writeable


@pytest.mark.parametrize("name", FILES)
def test_scaled_and_mirrored_meshes_keep_their_outside(name: str, rng: np.random.Generator) -> None:
    parts = parse_mesh(FILES[name], name)
    for signs in ((1, 1, 1), (-1, 1, 1), (1, -1, -1), (-1, -1, -1)):
        factors = rng.uniform(0.1, 3.0, 3) * signs
        vertices, faces = whole(scaled(parts, tuple(factors.tolist())))
        # The volume of a linear image is |det| times the volume; a positive one says that faces look outward.
        assert volume(vertices, faces) == pytest.approx(VOLUME * abs(np.prod(factors)), rel=1e-5)
        expected = TETRAHEDRON * factors
        assert vertices.min(axis=0) == pytest.approx(expected.min(axis=0), abs=1e-6)
        assert vertices.max(axis=0) == pytest.approx(expected.max(axis=0), abs=1e-6)


def test_normals_stay_normal_to_the_faces_of_a_scaled_mirror() -> None:
    normals = "vn 0 0 -1\nvn 0 -1 0\nvn -1 0 0\nvn 2 3 6\n"  # of the planes z=0, y=0, x=0 and 2x+3y+6z=0.6
    faces = "".join(
        "f " + " ".join(f"{corner + 1}//{i + 1}" for corner in face) + "\n" for i, face in enumerate(TETRAHEDRON_FACES)
    )
    vertices = obj_text().partition("f ")[0]
    (part,) = scaled(parse_mesh((vertices + normals + faces).encode(), "t.obj"), (2.0, -0.5, 3.0))
    assert part.normals is not None and len(part.vertices) == 12
    a, b, c = np.moveaxis(part.vertices[part.faces], 1, 0)
    of_faces = np.cross(b - a, c - a)
    of_faces /= np.linalg.norm(of_faces, axis=1, keepdims=True)
    for i in range(3):
        assert np.abs(part.normals[part.faces[:, i]] - of_faces).max() < 1e-5


def test_stl_and_collada_corners_at_one_place_become_one_vertex() -> None:
    for name in ("t.stl", "ascii.stl", "t.dae"):
        assert len(parse_mesh(FILES[name], name)[0].vertices) == 4


def test_collada_units_and_transforms_are_applied_and_the_up_axis_is_not() -> None:
    # Node: z' = x + 1, and so on: turned, shifted, in a file of millimeters that says Y_UP.
    matrix = "0 1 0 5  0 0 1 0  1 0 0 1  0 0 0 1"
    (part,) = parse_mesh(dae('<unit meter="0.001" name="mm"/>', matrix, "Y_UP"), "t.dae")
    expected = 0.001 * (TETRAHEDRON[:, [1, 2, 0]] + [5.0, 0.0, 1.0])
    assert in_order(part.vertices) == in_order(expected)
    assert volume(part.vertices - part.vertices[0], part.faces) == pytest.approx(VOLUME * 1e-9, rel=1e-3)


def test_a_mirroring_node_keeps_the_outside() -> None:
    (part,) = parse_mesh(dae(matrix="-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), "t.dae")
    assert part.vertices[:, 0].min() == pytest.approx(-0.3)
    assert volume(part.vertices, part.faces) == pytest.approx(VOLUME, rel=1e-6)


@pytest.mark.parametrize(("path", "unit"), [("duck.dae", 0.01), ("racecar/meshes/cone.dae", 0.0254)])
def test_real_collada_files_by_their_own_numbers(path: str, unit: float) -> None:
    # The duck says Y_UP and centimeters, the cone Z_UP and inches; their nodes have no transform.
    text = (DATA / path).read_text()
    arrays = dict(re.findall(r'<source id="([^"]*)"[^>]*>\s*<float_array[^>]*>([^<]*)<', text))
    sources = re.findall(r'<input semantic="POSITION" source="#([^"]*)"', text)
    positions = [np.array(arrays[source].split(), float).reshape(-1, 3) for source in sources]
    expected = unit * np.concatenate(positions)
    vertices, _ = whole(parse_mesh(text.encode(), path))
    assert vertices.min(axis=0) == pytest.approx(expected.min(axis=0), rel=1e-5)
    assert vertices.max(axis=0) == pytest.approx(expected.max(axis=0), rel=1e-5)


def test_gltf_transforms_are_applied_and_its_y_is_not_turned_up() -> None:
    (part,) = parse_mesh(gltf(translation=[1.0, 2.0, 3.0], scale=[2.0, 2.0, 2.0]), "t.gltf")
    assert np.array(in_order(part.vertices)) == pytest.approx(
        np.array(in_order(2.0 * TETRAHEDRON + [1.0, 2.0, 3.0])), abs=1e-6
    )
    # Linear light of 0.2 is 1.055 * 0.2^(1/2.4) - 0.055 in sRGB (IEC 61966-2-1).
    assert part.color == pytest.approx((1.0, 0.0, 0.48453, 1.0), abs=1e-5)


def test_gltf_buffers_in_files_of_their_own() -> None:
    data = json.dumps(gltf_tree({"uri": "a%20b.bin"})).encode()
    (part,) = parse_mesh(data, "t.gltf", {"a b.bin": BUFFER})
    assert volume(part.vertices, part.faces) == pytest.approx(VOLUME, rel=1e-6)


def test_colours_and_opacity_of_several_materials() -> None:
    text = "mtllib a.mtl\n" + obj_text().replace("f ", "usemtl glass\nf ", 1) + "\nusemtl red\nf 1 2 3\n"
    materials = b"newmtl red\nKd 1 0 0\nnewmtl glass\nKd 0 0.5 1\nd 0.25\n"
    parts = parse_mesh(text.encode(), "t.obj", {"a.mtl": materials})
    assert sorted((len(part.faces), part.color) for part in parts) == [
        (1, pytest.approx((1.0, 0.0, 0.0, 1.0), abs=0.003)),
        (4, pytest.approx((0.0, 0.5, 1.0, 0.25), abs=0.003)),
    ]
    assert [part.color for part in parse_mesh(text.encode(), "t.obj")] == [None] * len(parts)  # without its materials


def test_vertex_colours() -> None:
    lines = obj_text().splitlines()
    colored = [f"{line} {i / 4} 0 1" if line.startswith("v ") else line for i, line in enumerate(lines)]
    (part,) = parse_mesh("\n".join(colored).encode(), "t.obj")
    assert part.vertex_colors is not None and part.vertex_colors.shape == (4, 4)
    assert set(part.vertex_colors[:, 2].tolist()) == {255}


BAD = {
    "empty.stl": (b"", "holds no triangle|broken"),
    "cut.stl": (FILES["t.stl"][:150], "holds no triangle|broken"),
    "text.stl": (b"hello", "holds no triangle|broken"),
    "nan.stl": (binary_stl(np.where(TETRAHEDRON == 0.3, np.nan, TETRAHEDRON), TETRAHEDRON_FACES), "is not finite"),
    "empty.obj": (b"", "holds no triangle|broken"),
    "points.obj": (b"v 0 0 0\nv 1 0 0\n", "holds no triangle|broken"),
    "index.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "broken|names vertex"),
    "inf.obj": (b"v 0 0 0\nv 1 0 0\nv 0 inf 0\nf 1 2 3\n", "is not finite|broken"),
    "empty.dae": (b"", "not XML"),
    "other.dae": (b"<robot/>", "not COLLADA: the root element is <robot>"),
    "index.dae": (dae(index="0 1 2 0 1 3 0 2 3 1 2 77"), "broken|names vertex|no triangle"),
    "unit.dae": (dae('<unit meter="0"/>'), "unit meter='0' must be above 0"),
    "bomb.dae": (b'<!DOCTYPE x [<!ENTITY a "b">]><COLLADA>&a;</COLLADA>', "declares entities"),
    "empty.glb": (b"", "broken|not a GLB"),
    "cut.glb": (FILES["t.glb"][:200], "broken"),
    "text.gltf": (b"hello", "broken|not glTF"),
    "list.gltf": (b"[]", "broken|not glTF"),
    "sparse.gltf": (b'{"accessors": [{"count": 3}]}', r"accessors\[0\] has no bufferView"),
    "buffer.gltf": (json.dumps(gltf_tree({"uri": "gone.bin"})).encode(), "broken"),
    "model.step": (b"ISO-10303-21;", "no mesh format has the ending '.step'; known: .stl, .obj, .dae, .gltf, .glb"),
}


@pytest.mark.parametrize("name", BAD)
def test_broken_files_are_refused_by_name(name: str) -> None:
    data, message = BAD[name]
    with pytest.raises(MalformedFileError, match=f"^{re.escape(name)}(:\\d+)?: .*({message})"):
        parse_mesh(data, name)


@pytest.mark.parametrize("name", FILES)
def test_random_damage_is_refused_or_read_but_never_crashes(name: str, rng: np.random.Generator) -> None:
    data = FILES[name]
    for _ in range(30):
        damaged = bytearray(data[: rng.integers(len(data))] if rng.random() < 0.3 else data)
        for place in rng.integers(max(len(damaged), 1), size=rng.integers(1, 8)):
            if damaged:
                damaged[place] = rng.integers(256)
        try:
            parts = parse_mesh(bytes(damaged), name)
        except MalformedFileError:
            continue
        vertices, faces = whole(parts)
        assert np.isfinite(vertices).all() and 0 <= faces.min() <= faces.max() < len(vertices)


GREY = """<library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert><diffuse><color>1 0 0 1</color>
</diffuse></lambert></technique></profile_COMMON></effect><effect id="broken"><profile_COMMON><newparam sid="sampler">
<sampler2D><source>nowhere</source></sampler2D></newparam><technique sid="c"><lambert><diffuse><texture
texture="sampler" texcoord="u"/></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material><material id="torn"><instance_effect
url="#broken"/></material></library_materials><library_geometries>"""
BIND = """<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="s" target="#{}"/><instance_material symbol="t" target="#{}"/>
</technique_common></bind_material></instance_geometry>"""


@pytest.mark.parametrize("second", ["torn", "nowhere"])
def test_a_broken_material_of_a_collada_file_costs_the_look_only(second: str) -> None:
    """Faces are split between a good material and a broken one, as in files that lost a texture; all are there."""
    index = " ".join(map(str, TETRAHEDRON_FACES.ravel()))
    halves = [TETRAHEDRON_FACES[:2], TETRAHEDRON_FACES[2:]]
    text = dae().decode().replace("<library_geometries>", GREY)
    text = text.replace('<instance_geometry url="#g"/>', BIND.format("m", second))
    start, end = text.index('<triangles count="4">'), text.index("</triangles>") + len("</triangles>")
    triangles = text[start:end]
    split = (
        triangles.replace('count="4"', f'count="2" material="{name}"').replace(index, " ".join(map(str, half.ravel())))
        for name, half in zip("st", halves, strict=True)
    )
    data = (text[:start] + "".join(split) + text[end:]).encode()
    red, grey = parse_mesh(data, "t.dae")
    assert (red.color, grey.color) == ((1.0, 0.0, 0.0, 1.0), None)
    assert volume(*whole((red, grey))) == pytest.approx(VOLUME, rel=1e-6)


def test_a_text_of_a_collada_file_may_have_any_length() -> None:
    """Libxml2 refuses texts over 10 MB where nobody says otherwise."""
    assert len(parse_mesh(dae().replace(b"<p>", b"<p>" + b" " * 10_000_001), "t.dae")[0].faces) == 4


@pytest.mark.parametrize("scale", [(0.0, 1.0, 1.0), (1.0, np.nan, 1.0), (1.0, 1.0, np.inf)])
def test_an_impossible_scale_is_refused(scale: tuple[float, float, float]) -> None:
    with pytest.raises(MalformedFileError, match="factors are finite and not 0"):
        scaled(parse_mesh(FILES["t.stl"], "t.stl"), scale)


def test_a_kernel_that_reads_no_mesh_starts_without_trimesh() -> None:
    program = "import sys, virtualrobot_kernel.formats.models; print('trimesh' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
