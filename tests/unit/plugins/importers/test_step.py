"""STEP through Open CASCADE: extents, volume, units and colours of a block that the same kernel's writer made."""

import math
import re
import tempfile

import pytest
from virtualrobot_plugins.importers.step import StepImporter, StepSettings
from virtualrobot_sdk.errors import ArgumentError

from tests.unit.plugins.importers.reading import FILES, bounds, meshes, parts, refusal, triangles, volume

BLOCK = (FILES / "bored_block.step").read_text()
VOLUME = (60.0 * 40.0 * 20.0 - math.pi * 8.0**2 * 20.0) * 1e-9
"""In cubic meters: the block without the bore."""

MILLIMETER = "#430 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );"
INCH = """#430 = ( CONVERSION_BASED_UNIT('INCH',#9001) LENGTH_UNIT() NAMED_UNIT(#9002) );
#9001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#9003);
#9002 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);
#9003 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );"""
# ISO 10303-46: the solid (#15) is blue-green, and the face #17 of it red.
COLOURS = """#9100 = STYLED_ITEM('',(#9101),#15);
#9101 = PRESENTATION_STYLE_ASSIGNMENT((#9102));
#9102 = SURFACE_STYLE_USAGE(.BOTH.,#9103);
#9103 = SURFACE_SIDE_STYLE('',(#9104));
#9104 = SURFACE_STYLE_FILL_AREA(#9105);
#9105 = FILL_AREA_STYLE('',(#9106));
#9106 = FILL_AREA_STYLE_COLOUR('',#9107);
#9107 = COLOUR_RGB('',0.2,0.6,0.4);
#9108 = OVER_RIDING_STYLED_ITEM('',(#9109),#17,#9100);
#9109 = PRESENTATION_STYLE_ASSIGNMENT((#9110));
#9110 = SURFACE_STYLE_USAGE(.BOTH.,#9111);
#9111 = SURFACE_SIDE_STYLE('',(#9112));
#9112 = SURFACE_STYLE_FILL_AREA(#9113);
#9113 = FILL_AREA_STYLE('',(#9114));
#9114 = FILL_AREA_STYLE_COLOUR('',#9115);
#9115 = COLOUR_RGB('',1.,0.,0.);
#9120 = MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(#9100,#9108),#429);
ENDSEC;
END-ISO-10303-21;"""


def test_extents_and_volume() -> None:
    pieces = meshes(StepImporter(), BLOCK, "block.stp")
    low, high = bounds(pieces)
    assert low == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert high == pytest.approx([0.06, 0.04, 0.02])
    # The bore's chords lie inside the material's edge by 0.2 mm at most, so the hole is at most 5 % too small.
    assert VOLUME < volume(pieces) < VOLUME + 0.05 * math.pi * 0.008**2 * 0.02


def test_inches() -> None:
    assert MILLIMETER in BLOCK
    assert bounds(meshes(StepImporter(), BLOCK.replace(MILLIMETER, INCH), "block.step"))[1] == pytest.approx(
        [60 * 0.0254, 40 * 0.0254, 20 * 0.0254], rel=1e-6
    )


@pytest.mark.long
def test_tolerances_refine() -> None:
    fine = StepSettings(linear_tolerance_meters=1e-5, angular_tolerance_radians=0.05)
    coarse, exact = meshes(StepImporter(), BLOCK, "b.step"), meshes(StepImporter(fine), BLOCK, "b.step")
    assert len(triangles(exact)) > 2 * len(triangles(coarse))
    assert volume(exact) == pytest.approx(VOLUME, rel=1e-4) and volume(exact) < volume(coarse)
    for settings in (StepSettings(linear_tolerance_meters=0.0), StepSettings(angular_tolerance_radians=math.nan)):
        with pytest.raises(ArgumentError, match="must be above 0"):
            StepImporter(settings)


def test_colours_of_solids_and_faces() -> None:
    end = BLOCK.rindex("ENDSEC;")
    translation = StepImporter().translate((BLOCK[:end] + COLOURS).encode(), "b.step", {})
    pieces = {
        tuple(round(value, 2) for value in piece.color): piece
        for piece in parts(translation)
        if piece.color is not None
    }
    assert sorted(pieces) == [(0.2, 0.6, 0.4, 1.0), (1.0, 0.0, 0.0, 1.0)]
    # Face #17 is the one in the plane x = 0.
    assert bounds([pieces[1.0, 0.0, 0.0, 1.0]])[:, 0] == pytest.approx([0.0, 0.0], abs=1e-9)


@pytest.mark.long
def test_parts_in_other_files_are_named() -> None:
    other = "#9200 = DOCUMENT_FILE('wheel.stp','','',#9201,'',$);\n#9201 = DOCUMENT_TYPE('geometry');\nENDSEC;\nEND-ISO"
    data = other.join(BLOCK.rsplit("ENDSEC;\nEND-ISO", 1))
    assert StepImporter().translate(data.encode(), "b.step", {}).warnings == (
        "b.step: left out, since they are in other files: wheel.stp",
    )
    without = re.sub(
        r"#10 = ADVANCED_BREP_SHAPE_REPRESENTATION\('',\(#11,#15\)", "#10 = SHAPE_REPRESENTATION('',(#11)", data
    )
    assert refusal(StepImporter(), without, "b.step") == (
        "b.step: the file holds no solid and no surface; its parts are in other files, load those: wheel.stp"
    )


def test_what_is_no_step_file() -> None:
    assert "does not begin with ISO-10303-21" in refusal(StepImporter(), "solid x", "b.step")
    assert "cut off" in refusal(StepImporter(), BLOCK[: len(BLOCK) // 2], "b.step")
    hollow = "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"
    assert re.match(r"b\.step: (broken STEP file|the file holds no solid)", refusal(StepImporter(), hollow, "b.step"))


@pytest.mark.long
def test_nothing_is_written_to_the_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that an import that is killed leaves nothing there."""

    def refused(*words: object, **options: object) -> str:
        raise AssertionError("a temporary folder was asked for")

    monkeypatch.setattr(tempfile, "mkdtemp", refused)
    assert StepImporter().translate(BLOCK.encode(), "b.step", {}).data
