"""Curves of IGES and STEP, read by Open CASCADE: arcs, lines and B-splines by their formulas, in mm and inches."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError, UnknownNameError
from virtualrobot_apps.curves.curve import Curve, points_on
from virtualrobot_apps.curves.reading import read_curves

from tests.apps.cad_files import iges, numbers, step

pytestmark = pytest.mark.long

CUBIC = np.array([[0.0, 0.0, 0.0], [30.0, 60.0, 10.0], [70.0, -40.0, 20.0], [100.0, 20.0, 5.0]])
"""Control points (mm) of a B-spline with one piece, which is a Bézier curve."""


def spline(points: np.ndarray) -> str:
    """Return the parameters of entity 126: a cubic with knots 0, 0, 0, 0, 1, 1, 1, 1 and weights 1."""
    knots, weights = numbers([0.0] * 4 + [1.0] * 4), numbers([1.0] * 4)
    return f"3,3,0,0,1,0,{knots},{weights},{numbers(points)},0.,1.,0.,0.,0."


def bernstein(points: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return the points (n, 3) of a cubic Bézier curve, by its formula."""
    t = t[:, None]
    weights = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    return weights @ points


def on(curve: Curve, t: np.ndarray) -> np.ndarray:
    """Return points (n, 3) of a curve with one piece."""
    (piece,) = curve.pieces
    return points_on(piece, t)[0]


def saved(folder: Path, name: str, text: str) -> Path:
    """Return a file with a text."""
    (folder / name).write_text(text, encoding="ascii")
    return folder / name


def test_arcs_lines_and_splines_of_iges_are_where_their_formulas_say(tmp_path: Path) -> None:
    """Entity 100: centre, begin, end in a plane at z; 110: two points; 126: a rational B-spline. IGES 5.3, 4.3 on."""
    arc = "5.,10.,20.,40.,20.,10.,50."  # z; centre (10, 20); from (40, 20) a quarter turn to (10, 50)
    line = "1.,2.,3.,-7.,5.,9."
    file = saved(tmp_path, "part.igs", iges((100, arc, "ROUND"), (110, line), (126, spline(CUBIC), "SEAM")))
    found = read_curves(file)
    assert [one.name for one in found] == ["ROUND", "curve_2", "SEAM"]
    t = np.linspace(0.0, 1.0, 11)
    radii = np.linalg.norm(on(found[0], t) - [0.01, 0.02, 0.005], axis=1)
    np.testing.assert_allclose(radii, 0.03, atol=1e-12)
    np.testing.assert_allclose(found[0].ends, [[0.04, 0.02, 0.005], [0.01, 0.05, 0.005]], atol=1e-9)
    np.testing.assert_allclose(found[1].ends, [[0.001, 0.002, 0.003], [-0.007, 0.005, 0.009]], atol=1e-12)
    np.testing.assert_allclose(on(found[2], t), 1e-3 * bernstein(CUBIC, t), atol=1e-12)
    assert [one.name for one in read_curves(file, ["SEAM", "ROUND"])] == ["SEAM", "ROUND"]
    with pytest.raises(UnknownNameError, match="has no curve 'SEEM'; it has ROUND, curve_2, SEAM"):
        read_curves(file, ["SEEM"])


def test_inches_and_transformations_of_iges_are_kept(tmp_path: Path) -> None:
    """Entity 124 turns by 90 degrees about z and shifts by (1, 2, 3): x' = 1 - y, y' = 2 + x, z' = 3 + z, in inches."""
    turn = "0.,-1.,0.,1.,1.,0.,0.,2.,0.,0.,1.,3."
    file = saved(tmp_path, "part.iges", iges((110, "1.,0.,0.,5.,4.,2.", "L"), unit=1, turn=turn))
    (line,) = read_curves(file)
    np.testing.assert_allclose(line.ends, 0.0254 * np.array([[1.0, 3.0, 3.0], [-3.0, 7.0, 5.0]]), atol=1e-12)


@pytest.mark.parametrize("millimeters", [1.0, 25.4])
def test_a_spline_of_step_is_the_formulas(tmp_path: Path, millimeters: float) -> None:
    (found,) = read_curves(saved(tmp_path, "part.stp", step("SEAM", CUBIC, millimeters)))
    t = np.linspace(0.0, 1.0, 11)
    assert found.name == "SEAM"
    np.testing.assert_allclose(on(found, t), 1e-3 * millimeters * bernstein(CUBIC, t), atol=1e-12)


def test_broken_files_are_refused_in_words(tmp_path: Path) -> None:
    whole = iges((110, "1.,2.,3.,-7.,5.,9."))
    with pytest.raises(InvalidArgumentError, match=r"part.igs:7: '-7x' in an entity of type 110 is no number"):
        read_curves(saved(tmp_path, "part.igs", whole.replace("-7.", "-7x")))
    with pytest.raises(InvalidArgumentError, match=r"part.igs is cut off, or no IGES"):
        read_curves(saved(tmp_path, "part.igs", whole[:-90]))
    with pytest.raises(InvalidArgumentError, match=r"can't read it: the curve FLAT, of type 110, has no length"):
        read_curves(saved(tmp_path, "part.igs", iges((110, "1.,2.,3.,1.,2.,3.", "FLAT"))))
    broken = step("SEAM", CUBIC).replace("B_SPLINE_CURVE_WITH_KNOTS('SEAM', 3", "B_SPLINE_CURVE_WITH_KNOTS('SEAM', x")
    with pytest.raises(InvalidArgumentError, match=r"part.stp: Open CASCADE can't read it: "):
        read_curves(saved(tmp_path, "part.stp", broken))
    with pytest.raises(InvalidArgumentError, match=r"part.stp is cut off, or no STEP"):
        read_curves(saved(tmp_path, "part.stp", "ISO-10303-21;\nDATA;\n"))
    with pytest.raises(InvalidArgumentError, match=r"part.igs has no curves"):
        read_curves(saved(tmp_path, "part.igs", iges((116, "1.,2.,3.,0"))))
