"""3MF: a package of lib3mf's, and small ones by hand after the specification."""

import io
import zipfile

import numpy as np
import pytest
from virtualrobot_plugins.importers.threemf import UNITS, ThreeMfImporter

from tests.unit.plugins.importers.reading import FILES, bounds, meshes, refusal, volume

INCH = 0.0254
TETRAHEDRON = (
    '<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="3" y="0" z="0"/><vertex x="0" y="2" z="0"/>'
    '<vertex x="0" y="0" z="1"/></vertices><triangles><triangle v1="0" v2="2" v3="1"{}/>'
    '<triangle v1="0" v2="1" v3="3"{}/><triangle v1="0" v2="3" v3="2"/>'
    '<triangle v1="1" v2="2" v3="3"/></triangles></mesh>'
)
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIALS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"


def package(resources: str, build: str, unit: str = "", **parts: str) -> bytes:
    """Return a package with one model part, and others by their names."""
    archive = io.BytesIO()
    model = (
        f'<?xml version="1.0"?><model xmlns="{CORE}" xmlns:m="{MATERIALS}" {unit}><resources>{resources}</resources>'
        f"<build>{build}</build></model>"
    )
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as written:
        for name, text in {"3D/3dmodel.model": model, **parts}.items():
            written.writestr(name, text)
    return archive.getvalue()


def tetrahedron(first: str = "", second: str = "", **attributes: str) -> str:
    told = " ".join(f'{name}="{value}"' for name, value in attributes.items())
    return f'<object id="1" {told}>{TETRAHEDRON.format(first, second)}</object>'


def test_lib3mf_s_package_of_components_in_inches() -> None:
    pieces = meshes(ThreeMfImporter(), (FILES / "pinned_plate.3mf").read_bytes(), "pinned_plate.3mf")
    # A plate 4 x 2 x 0.5 and two pins 0.5 x 0.5 x 1: one upright from z = 0.5 on, one along x within the plate's.
    assert bounds(pieces) == pytest.approx(np.array([[10.0, 0.0, 0.0], [14.0, 2.0, 1.5]]) * INCH)
    assert volume(pieces) == pytest.approx((4.0 + 2 * 0.25) * INCH**3)
    colors = {tuple(color) for piece in pieces if piece.vertex_colors is not None for color in piece.vertex_colors}
    assert {(0, 128, 0, 255), (0, 0, 255, 64)} == colors
    assert [piece.color for piece in pieces if piece.vertex_colors is None] == [(1.0, 0.0, 0.0, 1.0)]


@pytest.mark.parametrize("unit", ["", *UNITS])
def test_units(unit: str) -> None:
    told = f'unit="{unit}"' if unit else ""
    data = package(tetrahedron(), '<item objectid="1"/>', told)
    meters = UNITS[unit or "millimeter"]
    assert volume(meshes(ThreeMfImporter(), data, "x.3mf")) == pytest.approx(meters**3)


def test_transforms_multiply_rows() -> None:
    build = '<item objectid="1" transform="0 1 0 -1 0 0 0 0 1 10 20 30"/>'  # a quarter turn about z, then a shift
    low, high = bounds(meshes(ThreeMfImporter(), package(tetrahedron(), build, 'unit="meter"'), "x.3mf"))
    assert low == pytest.approx([8.0, 20.0, 30.0]) and high == pytest.approx([10.0, 23.0, 31.0])


def test_colours_of_base_materials_and_corners() -> None:
    entries = '<base name="a" displaycolor="#80FF00"/><base name="b" displaycolor="#0000FF80"/>'
    base = f'<basematerials id="7">{entries}</basematerials>'
    one = meshes(ThreeMfImporter(), package(base + tetrahedron(pid="7", pindex="0"), '<item objectid="1"/>'), "x.3mf")
    assert [piece.color for piece in one] == [pytest.approx((128 / 255, 1.0, 0.0, 1.0), abs=1e-6)]
    mixed = package(base + tetrahedron(' p1="1"', pid="7", pindex="0"), '<item objectid="1"/>')
    (piece,) = meshes(ThreeMfImporter(), mixed, "x.3mf")
    assert piece.vertex_colors is not None
    of_faces = piece.vertex_colors[piece.faces]
    assert of_faces[0].tolist() == [[0, 0, 255, 128]] * 3 and of_faces[1].tolist() == [[128, 255, 0, 255]] * 3
    entries = "".join(f'<m:color color="{color}"/>' for color in ("#FF0000", "#00FF00", "#0000FF"))
    group = f'<m:colorgroup id="8">{entries}</m:colorgroup>'
    corners = package(group + tetrahedron(' pid="8" p1="0" p2="1" p3="2"'), '<item objectid="1"/>')
    (piece,) = meshes(ThreeMfImporter(), corners, "x.3mf")
    assert piece.vertex_colors is not None
    assert piece.vertex_colors[piece.faces[0], :3].tolist() == [[255, 0, 0], [0, 255, 0], [0, 0, 255]]


def test_a_part_in_another_file_and_a_root_elsewhere() -> None:
    relations = (
        '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship '
        'Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/parts/main.model"/>'
        "</Relationships>"
    )
    production = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
    main = (
        f'<model xmlns="{CORE}" xmlns:p="{production}" unit="meter"><resources><object id="5"><components><component '
        'p:path="/parts/other.model" objectid="1"/></components></object></resources>'
        '<build><item objectid="5"/></build></model>'
    )
    other = f'<model xmlns="{CORE}"><resources>{tetrahedron()}</resources><build/></model>'
    data = package("", "", **{"_rels/.rels": relations, "parts/main.model": main, "parts/other.model": other})
    assert volume(meshes(ThreeMfImporter(), data, "x.3mf")) == pytest.approx(1.0)


def test_what_is_left_out_is_told() -> None:
    texture = '<m:texture2d id="4" path="/a.png" contenttype="image/png"/>'
    translation = ThreeMfImporter().translate(package(texture + tetrahedron(), '<item objectid="1"/>'), "x.3mf", {})
    assert translation.warnings == ("x.3mf: left out: <texture2d>",)


@pytest.mark.parametrize(
    ("resources", "build", "unit", "words"),
    [
        ("", "", "", "3D/3dmodel.model builds nothing"),
        ("", '<item objectid="3"/>', "", "3dmodel.model:1: there is no object with id '3'"),
        (tetrahedron(), '<item objectid="1"/>', 'unit="parsec"', "unit='parsec': expected one of micron, millimeter"),
        (tetrahedron(), '<item objectid="1" transform="1 2 3"/>', "", "expected 12 numbers"),
        (tetrahedron(), '<item objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 x"/>', "", "transform: could not convert"),
        (tetrahedron().replace('v2="2"', 'v2="9"'), '<item objectid="1"/>', "", "names vertex 9, but there are 4"),
        (tetrahedron().replace('x="3"', 'x="nan"'), '<item objectid="1"/>', "", "a number is not finite"),
        (tetrahedron().replace('x="3"', ""), '<item objectid="1"/>', "", "<vertex>: could not convert"),
        (
            '<object id="1"><components><component objectid="1"/></components></object>',
            '<item objectid="1"/>',
            "",
            "deep",
        ),
        (
            '<basematerials id="7"><base displaycolor="red"/></basematerials>' + tetrahedron(),
            '<item objectid="1"/>',
            "",
            "displaycolor='red': expected #RRGGBB",
        ),
        (
            '<basematerials id="7"><base displaycolor="#000000"/></basematerials>' + tetrahedron(pid="7", pindex="4"),
            '<item objectid="1"/>',
            "",
            "properties 4, 4, 4: expected numbers from 0 to 0",
        ),
    ],
)
def test_refusals(resources: str, build: str, unit: str, words: str) -> None:
    assert words in refusal(ThreeMfImporter(), package(resources, build, unit), "x.3mf")


def test_components_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("virtualrobot_plugins.importers.threemf.MAX_INSTANCES", 1000)
    objects = tetrahedron() + "".join(
        f'<object id="{number}"><components>' + f'<component objectid="{number - 1}"/>' * 8 + "</components></object>"
        for number in range(2, 14)
    )
    assert "builds more than" in refusal(ThreeMfImporter(), package(objects, '<item objectid="13"/>'), "x.3mf")


def test_a_bomb_and_no_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("virtualrobot_plugins.importers.threemf.MAX_PART_BYTES", 1000)
    bomb = package(tetrahedron() + " " * 100_000, '<item objectid="1"/>')
    assert "larger than" in refusal(ThreeMfImporter(), bomb, "x.3mf")
    assert "not a 3MF package" in refusal(ThreeMfImporter(), b"PK\x03\x04", "x.3mf")
    empty = io.BytesIO()
    with zipfile.ZipFile(empty, "w") as archive:
        archive.writestr("a.txt", "b")
    assert "holds no 3D model part" in refusal(ThreeMfImporter(), empty.getvalue(), "x.3mf")
