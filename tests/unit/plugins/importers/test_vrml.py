"""VRML97 worlds: what MeshLab wrote, a hand-made one measured by three.js, and shapes with known volumes."""

import gzip
import io
import math

import numpy as np
import pytest
from PIL import Image
from virtualrobot_plugins.importers.vrml.importer import VrmlImporter
from virtualrobot_sdk.errors import FilesNeeded

from tests.unit.plugins.importers.reading import FILES, area, bounds, meshes, parts, refusal, volume

HEAD = "#VRML V2.0 utf8\n"


def read(text: str, files: dict[str, bytes] | None = None) -> list:
    return meshes(VrmlImporter(), HEAD + text, "x.wrl", files)


def shape(geometry: str, material: str = "") -> str:
    look = f"appearance Appearance {{ material Material {{ {material} }} }}" if material else ""
    return f"Shape {{ {look} geometry {geometry} }}"


def test_the_torus_of_meshlab() -> None:
    pieces = meshes(VrmlImporter(), (FILES / "torus.wrl").read_bytes(), "torus.wrl")
    assert sum(len(piece.faces) for piece in pieces) == 192
    assert volume(pieces) == pytest.approx(0.05091169, rel=1e-5)  # MeshLab's geometric measures
    assert area(pieces) == pytest.approx(1.121652, rel=1e-5)
    (piece,) = pieces
    assert piece.vertex_colors is not None
    # MeshLab was told: red where z > 0, green half, blue where x > 0.
    assert np.array_equal(piece.vertex_colors[:, 0], 255 * (piece.vertices[:, 2] > 0.0))
    assert np.abs(piece.vertex_colors[:, 1].astype(int) - 128).max() <= 1


def test_a_cell_as_three_js_reads_it() -> None:
    data = (FILES / "cell.wrl").read_bytes()
    translation = VrmlImporter().translate(data, "cell.wrl", {})
    assert translation.warnings == ("cell.wrl: left out: IndexedLineSet",)
    by_color = {piece.color: [piece] for piece in parts(translation)}
    # three.js r187 (npm), VRMLLoader: bounding boxes and volumes of its meshes. It knows neither `center` nor
    # `scaleOrientation`, so it was given nested transforms that are the same by ISO/IEC 14772-1, 6.52.
    table = by_color[(0.6, 0.4, 0.2, 1.0)]
    assert bounds(table) == pytest.approx(np.array([[0.4, -0.725, -0.9], [1.6, 0.025, -0.1]]), abs=1e-6)
    assert volume(table) == pytest.approx(0.048 + 4 * math.pi * 0.03**2 * 0.7, rel=1e-3)
    red = by_color[(1.0, 0.0, 0.0, 1.0)]
    assert bounds(red) == pytest.approx(
        np.array([[0.07404616, 0.58151716, 0.42339641], [0.70326591, 1.19365096, 0.88131833]]), abs=1e-6
    )
    assert volume(red) == pytest.approx(0.024, rel=1e-5)  # a concave prism, mirrored, whose outside stays outside
    # Its cone has 32 sides and ours 48, so that they differ by the sagitta.
    assert bounds(by_color[(0.0, 0.0, 1.0, 0.75)]) == pytest.approx(
        np.array([[-0.26511645, 0.1020338, 0.16799195], [0.29026595, 0.68430626, 0.86716]]), abs=4e-3
    )
    grid = next(piece for piece in parts(translation) if piece.vertex_colors is not None)
    assert volume([grid]) == pytest.approx(0.05833333, rel=1e-5) and area([grid]) == pytest.approx(0.6970562, rel=1e-6)
    assert grid.vertex_colors is not None
    corners = grid.vertex_colors[grid.faces]
    assert [corners[number, 0, :3].tolist() for number in (0, 2, 4, 6)] == [
        [255, 0, 0],
        [0, 255, 0],
        [0, 0, 255],
        [255, 255, 0],
    ]


@pytest.mark.parametrize(
    ("geometry", "expected"),
    [
        ("Box { size 1 2 3 }", 6.0),
        ("Box { }", 8.0),
        ("Sphere { radius 2 }", 32.0 * math.pi / 3.0),
        ("Cylinder { radius 2 height 3 }", 12.0 * math.pi),
        ("Cone { bottomRadius 2 height 3 }", 4.0 * math.pi),
        ("Extrusion { }", 4.0),
        ("Extrusion { ccw FALSE }", -4.0),
        # A frustum: h/3 (A + B + sqrt(A B))
        ("Extrusion { scale [ 1 1, 0.5 0.5 ] spine [ 0 0 0, 0 3 0 ] }", 4.0 + 1.0 + 2.0),
        ("Extrusion { spine [ 0 0 0, 1 1 1, 3 3 3 ] }", 4.0 * 3.0 * math.sqrt(3.0)),
        ("Extrusion { spine [ 0 0 0, 0 -2 0 ] }", 8.0),
    ],
)
def test_volumes_by_formula(geometry: str, expected: float) -> None:
    assert volume(read(shape(geometry))) == pytest.approx(expected, rel=0.01)


def test_parts_of_cylinders_and_cones() -> None:
    side = 2.0 * math.pi * 1.0 * 2.0
    assert area(read(shape("Cylinder { bottom FALSE top FALSE }"))) == pytest.approx(side, rel=2e-3)
    assert area(read(shape("Cylinder { side FALSE }"))) == pytest.approx(2.0 * math.pi, rel=5e-3)
    assert area(read(shape("Cone { side FALSE }"))) == pytest.approx(math.pi, rel=5e-3)


def test_a_bent_extrusion_stands_across_its_spine() -> None:
    square = "crossSection [ 0.1 0.1, 0.1 -0.1, -0.1 -0.1, -0.1 0.1, 0.1 0.1 ]"
    pieces = read(shape(f"Extrusion {{ {square} spine [ 0 0 0, 0 1 0, 1 1 0 ] endCap FALSE beginCap FALSE }}"))
    assert bounds(pieces)[1] == pytest.approx([1.0, 1.1, 0.1])
    # Sections at the ends are 0.2 wide and the one in the corner, at 45 degrees, 0.2 too: 0.2 cos 45 across.
    assert bounds(pieces)[0] == pytest.approx([-0.1, 0.0, -0.1])


def test_transforms_are_as_the_standard_composes_them(rng: np.random.Generator) -> None:
    """ISO/IEC 14772-1, 6.52: a Transform is the nesting of translation, center, rotation, scaleOrientation, scale."""
    t, c = rng.uniform(-2.0, 2.0, (2, 3))
    s, r, o = rng.uniform(0.2, 2.0, 3), rng.normal(size=4), rng.normal(size=4)
    word = {name: " ".join(map(str, values)) for name, values in {"t": t, "c": c, "s": s, "r": r, "o": o}.items()}
    back = {"c": " ".join(map(str, -c)), "o": " ".join(map(str, [*o[:3], -o[3]]))}
    once = (
        f"Transform {{ translation {word['t']} center {word['c']} rotation {word['r']} scale {word['s']} "
        f"scaleOrientation {word['o']} children {shape('Box { size 1 2 3 }')} }}"
    )
    nested = shape("Box { size 1 2 3 }")
    steps = [f"translation {back['c']}", f"rotation {back['o']}", f"scale {word['s']}", f"rotation {word['o']}"]
    for step in [*steps, f"rotation {word['r']}", f"translation {word['c']}", f"translation {word['t']}"]:
        nested = f"Transform {{ {step} children [ {nested} ] }}"
    assert bounds(read(once)) == pytest.approx(bounds(read(nested)), abs=1e-5)
    assert volume(read(once)) == pytest.approx(6.0 * np.prod(s), rel=1e-4)


RED, GREEN, BLUE = [255, 0, 0], [0, 255, 0], [0, 0, 255]
FACES = """IndexedFaceSet {{ coord Coordinate {{ point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0, 2 0 0 ] }}
    coordIndex [ 0 1 2 3 -1 1 4 2 -1 ] {} }}"""


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ("colorPerVertex FALSE color Color { color [ 1 0 0, 0 0 1 ] }", [RED] * 6 + [BLUE] * 3),
        ("colorPerVertex FALSE color Color { color [ 1 0 0, 0 0 1 ] } colorIndex [ 1 0 ]", [BLUE] * 6 + [RED] * 3),
        (
            "color Color { color [ 1 0 0, 0 1 0, 0 0 1, 1 1 0, 1 1 1 ] }",
            [RED, GREEN, BLUE, RED, BLUE, [255, 255, 0], GREEN, [255, 255, 255], BLUE],
        ),
        (
            "color Color { color [ 1 0 0, 0 1 0 ] } colorIndex [ 0 0 1 1 -1 1 1 1 -1 ]",
            [RED, RED, GREEN, RED, GREEN, GREEN, GREEN, GREEN, GREEN],
        ),
    ],
)  # fmt: skip
def test_colours_of_faces_and_vertices(fields: str, expected: list[list[int]]) -> None:
    (piece,) = read(shape(FACES.format(fields)))
    assert piece.vertex_colors[piece.faces].reshape(-1, 4)[:, :3].tolist() == expected


def test_normals_and_turning() -> None:
    (piece,) = read(shape(FACES.format("ccw FALSE normalPerVertex FALSE normal Normal { vector [ 0 0 -2, 0 0 -1 ] }")))
    assert piece.normals == pytest.approx(np.tile([0.0, 0.0, -1.0], (len(piece.vertices), 1)))
    corners = piece.vertices[piece.faces]
    assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] < 0.0).all()


def test_texture_coordinates(rng: np.random.Generator) -> None:
    image = io.BytesIO()
    Image.fromarray(rng.integers(0, 256, (2, 2, 3), dtype=np.uint8)).save(image, "PNG")
    look = 'appearance Appearance { texture ImageTexture { url [ "http://x/y.png", "textures\\\\a.png" ] } %s }'
    told = FACES.format(
        "texCoord TextureCoordinate { point [ 0 0, 1 0, 1 1, 0 1 ] } texCoordIndex [ 0 1 2 3 -1 0 1 2 -1 ]"
    )
    files = {"http://x/y.png": None, "textures/a.png": image.getvalue()}
    text = f"Shape {{ {look % ''} geometry {told} }}"
    with pytest.raises(FilesNeeded) as needed:
        VrmlImporter().translate((HEAD + text).encode(), "x.wrl", {})
    assert needed.value.names == ("http://x/y.png",)
    (piece,) = parts(VrmlImporter().translate((HEAD + text).encode(), "x.wrl", files))
    assert piece.texture is not None and piece.uv is not None
    square = piece.uv[piece.faces][:2].reshape(-1, 2)
    assert square == pytest.approx(piece.vertices[piece.faces][:2].reshape(-1, 3)[:, :2])
    # Without coordinates: along the longest side of the bounding box, 2 m here (6.23); and the transform of 6.49.
    transform = "textureTransform TextureTransform { translation 0.5 0 scale 2 1 }"
    (piece,) = parts(
        VrmlImporter().translate(
            (HEAD + f"Shape {{ {look % transform} geometry {FACES.format('')} }}").encode(), "x.wrl", files
        )
    )
    expected = piece.vertices[:, :2] / 2.0 * [2.0, 1.0] + [1.0, 0.0]
    assert piece.uv == pytest.approx(expected, abs=1e-6)


def test_a_texture_that_is_nowhere_costs_the_look_only() -> None:
    text = 'Shape { appearance Appearance { texture ImageTexture { url "a.png" } } geometry %s }'
    translation = VrmlImporter().translate((HEAD + text % FACES.format("")).encode(), "x.wrl", {"a.png": None})
    assert translation.warnings == ("x.wrl: the texture a.png is not there; drawn without it",)
    assert parts(translation)[0].texture is None


def test_prototypes() -> None:
    text = """
    PROTO Inner [ field SFVec3f size 1 1 1 field SFColor paint 1 0 0 ] {
      Shape { geometry Box { size IS size } appearance Appearance { material Material { diffuseColor IS paint } } }
    }
    PROTO Outer [ exposedField MFNode children [ ] field SFVec3f where 0 0 0 field SFColor tint 0 0 1 ] {
      Transform { translation IS where children [ Inner { paint IS tint } Group { children IS children } ] }
      Group { }
    }
    Outer { where 5 0 0 children [ Inner { size 2 2 2 } Outer { where 0 10 0 tint 0 1 0 } ] }
    """
    pieces = {piece.color: [piece] for piece in read(text)}
    assert bounds(pieces[(0.0, 0.0, 1.0, 1.0)]) == pytest.approx(np.array([[4.5, -0.5, -0.5], [5.5, 0.5, 0.5]]))
    assert bounds(pieces[(1.0, 0.0, 0.0, 1.0)]) == pytest.approx(np.array([[4.0, -1.0, -1.0], [6.0, 1.0, 1.0]]))
    assert bounds(pieces[(0.0, 1.0, 0.0, 1.0)]) == pytest.approx(np.array([[4.5, 9.5, -0.5], [5.5, 10.5, 0.5]]))


def test_inlined_files_count_from_their_own_folder() -> None:
    inner = HEAD + 'Inline { url "../shapes/box.wrl" }'
    box = HEAD + shape("Box { }")
    text = 'Transform { translation 3 0 0 children Inline { url "parts/inner.wrl" } }'
    files: dict[str, bytes] = {}
    for expected, content in (("parts/inner.wrl", inner), ("shapes/box.wrl", box)):
        with pytest.raises(FilesNeeded) as needed:
            read(text, files)
        assert needed.value.names == (expected,)
        files[expected] = content.encode()
    assert bounds(read(text, files))[0] == pytest.approx([2.0, -1.0, -1.0])
    packed = {**files, "shapes/box.wrl": gzip.compress(box.encode())}
    assert bounds(read(text, packed))[0] == pytest.approx([2.0, -1.0, -1.0])


def test_emissive_colour_stands_in_for_a_black_one() -> None:
    (piece,) = read(shape("Box { }", "diffuseColor 0 0 0 emissiveColor 0 1 0"))
    assert piece.color == (0.0, 1.0, 0.0, 1.0)
    assert read(shape("Box { }"))[0].color is None


def test_a_packed_world() -> None:
    data = gzip.compress((FILES / "torus.wrl").read_bytes())
    assert volume(meshes(VrmlImporter(), data, "torus.wrz")) == pytest.approx(0.05091169, rel=1e-5)
    assert "cut off" in refusal(VrmlImporter(), data[:-30], "torus.wrz")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "x.wrl:1: not a VRML97 file"),
        ("#VRML V1.0 ascii\nSeparator { }", "this is VRML 1.0"),
        ("#X3D V3.0 utf8\n", "this is X3D"),
        (HEAD, "x.wrl: the world shows no surface"),
        (HEAD + "Shape { geometry Text { string [ \"a\" ] } }", "shows no surface; it holds Text"),
        (HEAD + "\nShape {\n geometry Box {\n", "x.wrl:5: the file ends in the middle of a node; is it cut off?"),
        (HEAD + "\nShape {\n geometry\n Box { size 1 2 } }", "x.wrl:5: Box: size: expected 3 numbers for each entry"),
        (HEAD + shape("Box { size TRUE }"), "Box: size: expected numbers"),
        (HEAD + shape("Sphere { radius -1 }"), "Sphere: radius is -1; it must not be below 0"),
        (HEAD + shape("Box { size 1 2 1e999 }"), "a number is not finite"),
        (HEAD + "Group { children USE Nobody }", "USE Nobody: no node before has this name"),
        (HEAD + "DEF A Group { children USE A }", "USE A: no node before"),
        (HEAD + "Group { children [ [ ] ] }", "a list cannot hold a list"),
        (HEAD + "Group { children [ 1 Group { } ] }", "are mixed in one list"),
        (HEAD + "Group { children Box } ", "'Box' is no node: expected '{' behind it"),
        (HEAD + "Group [ ]", "'Group' is no node"),
        (HEAD + "Shape { geometry Group { } appearance Group { } }", "shows no surface; it holds Group"),
        (HEAD + "Shape { geometry Box { } appearance Group { } }", "Shape.appearance takes Appearance"),
        (HEAD + "ROUTE a.b FROM c.d", "ROUTE: expected TO"),
        (HEAD + "PROTO A [ ] { } A { }", "its prototype has no node"),
        (HEAD + "PROTO A [ feld SFInt32 x 1 ] { }", "'feld': expected one of field, exposedField"),
        (HEAD + "Group { children [ " * 150, "nodes are nested more than 100 deep"),
        (HEAD + "PROTO A [ ] { " * 150, "nodes are nested more than 100 deep"),
        (HEAD + "Group { children " + "[" * 5000, "a list cannot hold a list"),
        (HEAD + shape("IndexedFaceSet { coord Coordinate { point [ 0 0 0 ] } coordIndex [ 0 1 2 ] }"), "names point 2"),
        (HEAD + shape("IndexedFaceSet { coord Coordinate { point [ 0 0 ] } coordIndex [ 0 ] }"), "expected 3 numbers"),
        (HEAD + shape(FACES.format("color Color { color [ 1 0 0 ] }")), "entry 4 is wanted, but Color has 1"),
        (HEAD + shape(FACES.format("color Color { color [ 1 0 0 ] } colorIndex [ 0 ]")), "has 1 entries, but"),
        (HEAD + shape("ElevationGrid { xDimension 3 zDimension 3 height [ 1 2 ] }"), "do not fit the 2 heights"),
        (HEAD + shape("ElevationGrid { xDimension 1e9 zDimension 1e9 height [ 1 2 ] }"), "do not fit"),
        (HEAD + "Group { children } { ", "Group.children has no value: got '}'"),
        (HEAD + "Shape { geometry Box { size 'a' } }", "has no meaning here"),
    ],
)  # fmt: skip
def test_refusals_name_the_line(text: str, words: str) -> None:
    assert words in refusal(VrmlImporter(), text, "folder/x.wrl")


def test_a_file_that_is_needed_and_nowhere() -> None:
    text = HEAD + 'Inline { url [ "a.wrl" "b.wrl" ] }'
    assert "x.wrl:2: Inline: the file 'b.wrl' is nowhere" in refusal(
        VrmlImporter(), text, "x.wrl", {"a.wrl": None, "b.wrl": None}
    )
    again = {"a.wrl": (HEAD + 'Inline { url "a.wrl" }').encode()}
    assert "a.wrl inlines itself" in refusal(VrmlImporter(), text, "x.wrl", again)


def test_a_world_that_grows_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("virtualrobot_plugins.importers.vrml.world.MAX_NODES", 2000)
    groups = "DEF G0 " + shape("Box { }") + "\n"
    groups += "".join(f"DEF G{n} Group {{ children [ USE G{n - 1} USE G{n - 1} ] }}\n" for n in range(1, 40))
    assert "shows more than 2000 nodes" in refusal(VrmlImporter(), HEAD + groups, "x.wrl")
    protos = "PROTO P0 [ ] { " + shape("Box { }") + " }\n"
    protos += "".join(
        f"PROTO P{n} [ ] {{ Group {{ children [ P{n - 1} {{ }} P{n - 1} {{ }} ] }} }}\n" for n in range(1, 40)
    )
    assert "shows more than 2000 nodes" in refusal(VrmlImporter(), HEAD + protos + "P39 { }", "x.wrl")
