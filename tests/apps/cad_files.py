"""Files of CAD systems, written by the rules of their formats: VDA-FS (DIN 66301), IGES 5.3, STEP (ISO 10303-21)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike


def numbers(values: ArrayLike) -> str:
    """Return numbers with all their digits, a point in each, and commas between, as all three formats have them."""
    return ",".join(f"{float(one):.16E}" if "e" in repr(float(one)) else repr(float(one)) for one in np.ravel(values))


def vda(*elements: str) -> str:
    """Return a file of VDA-FS: a header, elements, an end, in lines of 72 columns and a number each."""
    lines = ["PART = HEADER / 2", "*" * 71, "VDAFS VERSION : 2.0"]
    for element in elements:
        rest = element
        while len(rest) > 72:
            at = rest.rindex(",", 0, 72) + 1
            lines.append(rest[:at])
            rest = rest[at:]
        lines.append(rest)
    lines.append("PART = END")
    return "".join(f"{line:<72}{number:08d}\n" for number, line in enumerate(lines, 1))


def curve_element(name: str, pieces: Sequence[ArrayLike]) -> str:
    """Return a CURVE of polynomial pieces, each of coefficients (k, 3) in mm."""
    coefficients = [np.asarray(one, dtype=float) for one in pieces]
    told = [f"{len(one)}, {numbers(one.T)}" for one in coefficients]
    return f"{name} = CURVE / {len(told)}, {numbers(range(len(told) + 1))}, {', '.join(told)}"


def iges(*entities: tuple[int, str] | tuple[int, str, str], unit: int = 2, turn: str = "") -> str:
    """Return a file of IGES: entities by type, parameters and name, in a unit (2: mm, 1: inches).

    `turn` are the twelve numbers of a transformation (entity 124) that all others have.
    """
    told = [(124, turn, ""), *entities] if turn else list(entities)
    parameters, directory = list[str](), list[str]()
    for number, (kind, text, *names) in enumerate(told):
        whole, first = f"{kind},{text};", len(parameters) + 1
        rows = list[str]()
        while whole:
            cut = len(whole) if len(whole) <= 64 else whole.rindex(",", 0, 64) + 1
            rows.append(whole[:cut])
            whole = whole[cut:]
        parameters += [f"{row:<64} {2 * number + 1:7d}" for row in rows]
        matrix = 1 if turn and number else 0
        directory.append("".join(f"{one:8d}" for one in (kind, first, 0, 0, 0, 0, matrix, 0, 0)))
        fields = "".join(f"{one:8d}" for one in (kind, 0, 0, len(rows), 0)) + " " * 16
        directory.append(f"{fields}{names[0] if names else '':>8}{0:8d}")
    units = {1: "1,4HINCH", 2: "2,2HMM"}[unit]
    world = "1H,,1H;,4HPART,8Hpart.igs,4HTest,4HTest,32,38,6,308,15,4HPART,1.,"
    world += f"{units},1,0.01,15H20261129.120000,1E-7,1000.,4HTest,4HTest,11,0,15H20261129.120000;"
    start = ["written by a test"]
    general = [world[at : at + 72] for at in range(0, len(world), 72)]
    found = []
    for letter, rows in (("S", start), ("G", general), ("D", directory), ("P", parameters)):
        found += [f"{row:<72}{letter}{number:7d}" for number, row in enumerate(rows, 1)]
    counts = f"S{len(start):7d}G{len(general):7d}D{len(directory):7d}P{len(parameters):7d}"
    return "\n".join([*found, f"{counts:<72}T{1:7d}", ""])


def step(name: str, control_points: ArrayLike, millimeters: float = 1.0) -> str:
    """Return a file of STEP with one B-spline of one piece, in a unit of so many mm."""
    points = np.asarray(control_points, dtype=float)
    degree = len(points) - 1
    places = [f"#{100 + at} = CARTESIAN_POINT('', ({numbers(one)}));" for at, one in enumerate(points)]
    listed = ",".join(f"#{100 + at}" for at in range(len(points)))
    unit = "#11 = (LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.));"
    if millimeters != 1.0:
        unit = (
            "#20 = (LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.));\n"
            f"#21 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({millimeters}), #20);\n"
            "#22 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
            "#11 = (CONVERSION_BASED_UNIT('INCH', #21) LENGTH_UNIT() NAMED_UNIT(#22));"
        )
    lines = [
        "ISO-10303-21;",
        "HEADER;",
        "FILE_DESCRIPTION(('curve'), '2;1');",
        "FILE_NAME('part', '2026-11-29T12:00:00', (''), (''), '', '', '');",
        "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));",
        "ENDSEC;",
        "DATA;",
        "#1 = APPLICATION_CONTEXT('core data for automotive mechanical design processes');",
        "#2 = APPLICATION_PROTOCOL_DEFINITION('international standard', 'automotive_design', 2000, #1);",
        "#3 = PRODUCT_CONTEXT('', #1, 'mechanical');",
        "#4 = PRODUCT('part', 'part', '', (#3));",
        "#5 = PRODUCT_DEFINITION_FORMATION('', '', #4);",
        "#6 = PRODUCT_DEFINITION_CONTEXT('part definition', #1, 'design');",
        "#7 = PRODUCT_DEFINITION('design', '', #5, #6);",
        "#8 = PRODUCT_DEFINITION_SHAPE('', '', #7);",
        "#9 = SHAPE_DEFINITION_REPRESENTATION(#8, #10);",
        "#10 = GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION('', (#30, #34), #14);",
        unit,
        "#12 = (NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.));",
        "#13 = (NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT());",
        "#14 = (GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#11,#12,#13))"
        " REPRESENTATION_CONTEXT('', '3D'));",
        "#30 = AXIS2_PLACEMENT_3D('', #31, #32, #33);",
        "#31 = CARTESIAN_POINT('', (0.,0.,0.));",
        "#32 = DIRECTION('', (0.,0.,1.));",
        "#33 = DIRECTION('', (1.,0.,0.));",
        "#34 = GEOMETRIC_CURVE_SET('', (#35));",
        f"#35 = B_SPLINE_CURVE_WITH_KNOTS('{name}', {degree}, ({listed}), .UNSPECIFIED., .F., .F.,"
        f" ({degree + 1},{degree + 1}), (0.,1.), .UNSPECIFIED.);",
        *places,
        "ENDSEC;",
        "END-ISO-10303-21;",
        "",
    ]
    return "\n".join(lines)
