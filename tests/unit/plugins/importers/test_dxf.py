"""DXF drawings: a real one, one of MeshLab's, and drawings made by ezdxf whose volumes are known by formula."""

import io
import math
import re

import numpy as np
import pytest
from ezdxf.document import Drawing
from ezdxf.entities.dxfgfx import DXFGraphic
from ezdxf.filemanagement import new
from ezdxf.math import Vec3
from virtualrobot_plugins.importers.dxf.importer import UNITS, DxfImporter, DxfSettings

from tests.unit.plugins.importers.reading import FILES, area, bounds, meshes, parts, refusal, triangles, volume

METERS = 6
ACIS = ["700 0 1 0", "@9 something @8 ACIS 7.0 @24 Mon Jan 01 00:00:00 2001", "1 9.9e-07 1e-10"]


def drawing(units: int = METERS) -> Drawing:
    document = new("R2010")
    document.units = units
    return document


def saved(document: Drawing) -> bytes:
    text = io.StringIO()
    document.write(text)
    return text.getvalue().encode()


def box(layout: object, size: tuple[float, float, float] = (1.0, 1.0, 1.0), **attributes: object) -> DXFGraphic:
    """Draw a box at the origin as a MESH."""
    corners = [Vec3(x, y, z) for x in (0, size[0]) for y in (0, size[1]) for z in (0, size[2])]
    mesh = layout.add_mesh(dxfattribs=attributes)  # pyright: ignore[reportAttributeAccessIssue]  a layout of any kind
    with mesh.edit_data() as data:
        data.vertices = corners
        data.faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return mesh


def tags(text: str) -> list[tuple[int, str]]:
    """Return the pairs of group code and value of a DXF text."""
    lines = text.splitlines()
    return [(int(code), value.strip()) for code, value in zip(lines[::2], lines[1::2], strict=True)]


def prism_area(text: str) -> float:
    """Return the surface of all polylines: walls of thickness by length, and twice the area of those that are closed.

    A bulge b is an arc of 4 atan(b) (Autodesk, DXF reference), so a segment of r^2 (angle - sin angle) / 2 more.
    """
    total, thickness, closed = 0.0, 0.0, False
    vertices: list[list[float]] = []
    kind = ""
    for code, value in [*tags(text), (0, "EOF")]:
        if code == 0:
            if value == "SEQEND":
                ends = vertices[1:] + (vertices[:1] if closed else [])
                inside = 0.0
                for (x, y, bulge), (to_x, to_y, _) in zip(vertices, ends, strict=False):
                    length, angle = math.hypot(to_x - x, to_y - y), 4.0 * math.atan(bulge)
                    inside += (x * to_y - to_x * y) / 2.0
                    if bulge:
                        radius = length / (2.0 * math.sin(abs(angle) / 2.0))
                        length = radius * abs(angle)
                        inside += radius**2 * (angle - math.sin(angle)) / 2.0
                    total += thickness * length
                total += 2.0 * abs(inside) if closed else 0.0
            elif value == "POLYLINE":
                thickness, closed, vertices = 0.0, False, []
            elif value == "VERTEX":
                vertices.append([0.0, 0.0, 0.0])
            kind = value
        elif kind == "POLYLINE" and code in (39, 70):
            thickness, closed = (float(value), closed) if code == 39 else (thickness, bool(int(value) & 1))
        elif kind == "VERTEX" and code in (10, 20, 42):
            vertices[-1][{10: 0, 20: 1, 42: 2}[code]] = float(value)
    return total


def test_a_real_drawing_of_polylines() -> None:
    data = (FILES / "POLI-ALL210_12.DXF").read_bytes()
    translation = DxfImporter().translate(data, "POLI-ALL210_12.DXF", {})
    pieces = parts(translation)
    assert len(translation.warnings) == 1 and "taken as millimeters" in translation.warnings[0]
    corners = triangles(pieces) * 1000.0
    text = data.decode("cp437")
    flat = (18.0 + 6.0) * (13.0 + 11.0)  # the corners of its one 3DFACE
    assert area(pieces) * 1e6 - flat == pytest.approx(prism_area(text), rel=0.01)  # chords instead of arcs
    # Lines have a width there, which is not drawn, and by which $EXTMIN and $EXTMAX of the header are wider.
    low, high = (np.array(found, float) for found in re.findall(EXTENTS, text))
    assert (low <= corners.min(axis=(0, 1)) + 1e-6).all() and (corners.max(axis=(0, 1)) <= high + 1e-6).all()
    assert {piece.color for piece in pieces} == {(1.0, 1.0, 1.0, 1.0), (1.0, 63 / 255, 0.0, 1.0)}  # ACI 7 and 20


EXTENTS = r"\$EXTM(?:IN|AX)\s+10\s+(\S+)\s+20\s+(\S+)\s+30\s+(\S+)"


def test_the_faces_of_meshlab() -> None:
    pieces = meshes(DxfImporter(DxfSettings(unit_meters=1.0)), (FILES / "torus.dxf").read_bytes(), "torus.dxf")
    assert sum(len(piece.faces) for piece in pieces) == 192
    assert volume(pieces) == pytest.approx(0.05091169, rel=1e-5)  # MeshLab's geometric measures
    assert area(pieces) == pytest.approx(1.121652, rel=1e-5)
    assert bounds(pieces) == pytest.approx(np.array([[-0.4, -0.4, -0.1], [0.4, 0.4, 0.1]]), abs=1e-6)


@pytest.mark.parametrize("units", [number for number in UNITS if 1e-4 < UNITS[number][1] < 1e3])
def test_units(units: int) -> None:
    document = drawing(units)
    box(document.modelspace(), (2.0, 3.0, 4.0))
    name, meters = UNITS[units]
    low, high = bounds(meshes(DxfImporter(), saved(document), "x.dxf"))
    assert high - low == pytest.approx(np.array([2.0, 3.0, 4.0]) * meters, rel=1e-6), name


def test_a_drawing_without_unit_is_in_millimeters_unless_told() -> None:
    document = drawing(0)
    box(document.modelspace())
    translation = DxfImporter().translate(saved(document), "x.dxf", {})
    assert bounds(parts(translation))[1] == pytest.approx([1e-3] * 3)
    assert translation.warnings == (
        "x.dxf: the drawing tells no unit ($INSUNITS); its numbers are taken as millimeters",
    )
    told = DxfImporter(DxfSettings(unit_meters=0.0254)).translate(saved(document), "x.dxf", {})
    assert bounds(parts(told))[1] == pytest.approx([0.0254] * 3) and told.warnings == ()
    assert "unit_meters is -1" in refusal(DxfImporter(DxfSettings(unit_meters=-1.0)), saved(document), "x.dxf")


def test_outlines_with_a_thickness_are_prisms() -> None:
    layout = drawing().modelspace()
    layout.add_circle((5, 0), 1.0, dxfattribs={"thickness": 2.0})
    document = layout.doc
    assert document is not None
    # A circle becomes a polygon whose chords are off by 5e-4 of its extent at most: its area lacks less than 0.3 %.
    assert 2.0 * math.pi * 0.997 < volume(meshes(DxfImporter(), saved(document), "x.dxf")) < 2.0 * math.pi

    document = drawing()
    document.modelspace().add_lwpolyline(
        [(0, 0), (4, 0), (4, 3), (2, 1), (0, 3)], close=True, dxfattribs={"thickness": -0.5, "elevation": 2.0}
    )
    pieces = meshes(DxfImporter(), saved(document), "x.dxf")
    assert volume(pieces) == pytest.approx(0.5 * (12.0 - 4.0))
    assert bounds(pieces)[:, 2] == pytest.approx([1.5, 2.0])

    document = drawing()  # two half circles, and an axis of extrusion of its own: x along world y, y along world z
    document.modelspace().add_lwpolyline(
        [(0, 0, 1.0), (2, 0, 1.0)], format="xyb", close=True, dxfattribs={"thickness": 3.0, "extrusion": (1, 0, 0)}
    )
    pieces = meshes(DxfImporter(), saved(document), "x.dxf")
    assert 0.995 * 3.0 * math.pi < volume(pieces) < 3.0 * math.pi
    assert bounds(pieces) == pytest.approx(np.array([[0.0, 0.0, -1.0], [3.0, 2.0, 1.0]]), abs=2e-3)


def test_lines_with_a_thickness_are_walls() -> None:
    document = drawing()
    document.modelspace().add_line((0, 0), (3, 4), dxfattribs={"thickness": 2.0})
    assert area(meshes(DxfImporter(), saved(document), "x.dxf")) == pytest.approx(10.0)


def test_faces_solids_and_grids() -> None:
    document = drawing()
    layout = document.modelspace()
    layout.add_3dface([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    layout.add_3dface([(0, 0, 1), (1, 0, 1), (0, 1, 1)])
    layout.add_solid([(0, 0, 2), (1, 0, 2), (0, 1, 2), (1, 1, 2)])  # corners of a SOLID go in a zigzag
    grid = layout.add_polymesh((3, 2))
    for row in range(3):
        for column in range(2):
            grid.set_mesh_vertex((row, column), (row, column, 3.0))
    pieces = meshes(DxfImporter(), saved(document), "x.dxf")
    assert area(pieces) == pytest.approx(1.0 + 0.5 + 1.0 + 2.0)


def test_a_closed_grid_is_a_tube() -> None:
    document = drawing()
    grid = document.modelspace().add_polymesh((4, 2))
    for row, (x, y) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)]):
        for column in range(2):
            grid.set_mesh_vertex((row, column), (x, y, column))
    grid.m_close()
    assert area(meshes(DxfImporter(), saved(document), "x.dxf")) == pytest.approx(4.0)


def test_blocks_nested_scaled_turned_and_mirrored() -> None:
    document = drawing()
    inner = document.blocks.new("inner", base_point=(1, 0, 0))
    box(inner, (1.0, 2.0, 3.0))
    outer = document.blocks.new("outer")
    outer.add_blockref("inner", (0, 0, 0), dxfattribs={"xscale": -2.0, "rotation": 90.0})
    document.modelspace().add_blockref("outer", (10, 0, 0), dxfattribs={"zscale": 0.5})
    pieces = meshes(DxfImporter(), saved(document), "x.dxf")
    # By hand: x - 1 from 0..1 to -1..0, times -2 to 0..2; a quarter turn: x from -y: -2..0, y from x: 0..2; z: 0..1.5.
    assert bounds(pieces) == pytest.approx(np.array([[8.0, 0.0, 0.0], [10.0, 2.0, 1.5]]))
    assert volume(pieces) == pytest.approx(6.0)  # a mirrored box has its outside outside


def test_an_array_of_blocks() -> None:
    document = drawing()
    box(document.blocks.new("cube"))
    attributes = {"row_count": 3, "column_count": 2, "row_spacing": 5.0, "column_spacing": 4.0}
    document.modelspace().add_blockref("cube", (0, 0, 0), dxfattribs=attributes)
    pieces = meshes(DxfImporter(), saved(document), "x.dxf")
    assert volume(pieces) == pytest.approx(6.0)
    assert bounds(pieces)[1] == pytest.approx([5.0, 11.0, 1.0])


def test_colours_of_entities_layers_and_blocks() -> None:
    document = drawing()
    document.layers.add("green", color=3)
    document.layers.add("teal", true_color=0x008080)
    layout = document.modelspace()
    box(layout, color=1)
    box(layout, layer="green")
    box(layout, layer="teal")
    box(layout, layer="green", true_color=0x102030)
    block = document.blocks.new("block")
    box(block, color=0)  # by block
    box(block, layer="0")  # by the layer of the insertion
    layout.add_blockref("block", (0, 0, 0), dxfattribs={"layer": "green", "color": 5})
    glass = box(layout, color=2)
    glass.transparency = 0.6
    found = {piece.color for piece in meshes(DxfImporter(), saved(document), "x.dxf") if piece.color is not None}
    # AutoCAD's colours 1, 2, 3, 5 are red, yellow, green, blue.
    expected = {
        (1.0, 0.0, 0.0, 1.0),
        (0.0, 1.0, 0.0, 1.0),
        (0.0, 128 / 255, 128 / 255, 1.0),
        (16 / 255, 32 / 255, 48 / 255, 1.0),
        (0.0, 0.0, 1.0, 1.0),
        (1.0, 1.0, 0.0, 102 / 255),
    }
    assert {tuple(np.round(color, 4)) for color in found} == {tuple(np.round(color, 4)) for color in expected}


def test_what_is_off_frozen_or_has_no_surface_is_told() -> None:
    document = drawing()
    layout = document.modelspace()
    box(layout)
    box(layout, layer="off")
    document.layers.add("off").off()
    document.layers.add("ice").freeze()
    box(layout, layer="ice")
    box(layout, invisible=1)
    layout.add_text("note")
    layout.add_line((0, 0), (1, 1))
    layout.add_3dsolid().sat = ACIS
    translation = DxfImporter().translate(saved(document), "plan.dxf", {})
    assert volume(parts(translation)) == pytest.approx(1.0)
    assert translation.warnings == (
        "plan.dxf: left out, since ACIS bodies cannot be read: 3DSOLID",
        "plan.dxf: left out, since they have no surface: LINE, TEXT",
        "plan.dxf: left out, since they are invisible or their layer is off or frozen: 3 entities",
    )


def test_nothing_with_a_surface_says_what_is_there() -> None:
    document = drawing()
    document.modelspace().add_line((0, 0), (1, 1))
    document.modelspace().add_3dsolid().sat = ACIS
    assert refusal(DxfImporter(), saved(document), "a/plan.dxf") == (
        "plan.dxf: nothing in the drawing has a surface; it holds 3DSOLID, LINE; ACIS bodies cannot be read: export "
        "them as meshes"
    )
    assert "the drawing is empty" in refusal(DxfImporter(), saved(drawing()), "x.dxf")


def test_blocks_in_blocks_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("virtualrobot_plugins.importers.dxf.drawing.MAX_ENTITIES", 5000)
    document = drawing()
    block = document.blocks.new("b0")
    box(block)
    for number in range(1, 12):  # eight of each in the next: 8^11 boxes
        following = document.blocks.new(f"b{number}")
        for _ in range(8):
            following.add_blockref(f"b{number - 1}", (0, 0, 0))
    document.modelspace().add_blockref("b11", (0, 0, 0))
    assert "shows more than" in refusal(DxfImporter(), saved(document), "x.dxf")


def test_binary_drawings_and_mended_ones() -> None:
    document = drawing()
    box(document.modelspace())
    binary = io.BytesIO()
    document.write(binary, fmt="bin")  # pyright: ignore[reportArgumentType]  a binary stream for the binary format
    assert volume(meshes(DxfImporter(), binary.getvalue(), "x.dxf")) == pytest.approx(1.0)
    text = saved(document).decode()
    start = text.index("ENDSEC", text.index("ENTITIES"))
    mended = text[:start].rstrip()[:-1] + text[start + len("ENDSEC") + 1 :]  # the end of a section is missing
    assert volume(meshes(DxfImporter(), mended, "x.dxf")) == pytest.approx(1.0)
    assert volume(meshes(DxfImporter(), text[: text.rindex("EOF")], "x.dxf")) == pytest.approx(1.0)
    assert "cut off" in refusal(DxfImporter(), text[:start], "x.dxf")
    assert "cut off" in refusal(DxfImporter(), binary.getvalue()[:-20], "x.dxf")
