"""Curves of VDA-FS by the formulas of their elements, and ways along them within a tolerance."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError, UnknownNameError, WrongStateError
from virtualrobot_apps.curves import reading, vda
from virtualrobot_apps.curves.curve import Curve, directions, points_on, polyline, polynomial
from virtualrobot_apps.curves.fitting import ways
from virtualrobot_apps.curves.frames import frames
from virtualrobot_apps.curves.program import _zones
from virtualrobot_apps.curves.reading import read_curves
from virtualrobot_apps.curves.way import Way
from virtualrobot_apps.languages.writers.command import program as command

from tests.apps.cad_files import curve_element
from tests.apps.cad_files import vda as vda_file
from tests.tiers import Draws

Floats = NDArray[np.float64]
SP1 = """SP1 = CURVE / 4, 0., 1., 2., 2.7, 4.,
5, 0., 63.8891754, -51.4652710, 77.0936432, -48.5175476, 0., 6.4475098, 56.9390259, -23.5717163, 3.1851807,
30., 0., -60., 40., -10.,
3, 41., -0.9153137, 41.9153137, 43., 31.1755676, 1.8244324, 0., -20., 15.,
2, 82., 29., 76., -21., -5., -5.,
4, 111., 26.5623550, -10.8701935, -10.6921616, 55., -19.2350578, -77.3120193, 49.5470734, -10., 30., -30., 10."""
"""The example of a curve in DIN 66301."""


def read(*elements: str) -> list[Curve]:
    """Return the curves of a file with these elements."""
    return vda.read(vda_file(*elements), "part.vda")


def on_arc(begin: Floats, via: Floats, end: Floats, count: int = 33) -> Floats:
    """Return points on the circle through three points, from the first to the last by the second."""
    # The centre is where the planes between the points and the plane of the three meet.
    normal = np.cross(via - begin, end - begin)
    rows = np.stack([via - begin, end - via, normal])
    center = np.linalg.solve(rows, [(via - begin) @ (via + begin) / 2, (end - via) @ (end + via) / 2, normal @ begin])
    x = begin - center
    y = np.cross(normal / np.linalg.norm(normal), x)
    last = np.arctan2((end - center) @ y, (end - center) @ x) % (2 * np.pi)
    angles = np.linspace(0.0, last, count)[:, None]
    return center + np.cos(angles) * x + np.sin(angles) * y


def vias_of(way: Way) -> Floats:
    """Return a point in the middle of each arc; not a number for a line."""
    return np.full((len(way.points) - 1, 3), np.nan) if way.vias is None else way.vias


def along(way: Way) -> Floats:
    """Return points on the lines and arcs of a way."""
    found = []
    for via, (begin, end) in zip(vias_of(way), pairwise(way.points), strict=True):
        line = begin + np.linspace(0.0, 1.0, 33)[:, None] * (end - begin)
        found.append(line if np.isnan(via[0]) else on_arc(begin, via, end))
    return np.vstack(found)


def test_a_curve_is_its_polynomials() -> None:
    """x(t) of each piece is the sum of its coefficients times powers of t, in mm; t goes from 0 to 1 in each."""
    coefficients = [np.array([[1.0, 2.0, 3.0], [4.0, 0.0, -1.0], [0.0, -5.0, 2.0], [7.0, 1.0, 0.5]]), np.ones((1, 3))]
    (found,) = read(curve_element("C1", coefficients))
    t = np.linspace(0.0, 1.0, 7)
    for piece, told in zip(found.pieces, coefficients, strict=True):
        points, slopes = points_on(piece, t)
        powers = np.arange(len(told))
        np.testing.assert_allclose(points, 1e-3 * t[:, None] ** powers @ told, atol=1e-12)
        step = 1e-6
        nearby = [1e-3 * (t + side)[:, None] ** powers @ told for side in (step, -step)]
        np.testing.assert_allclose(slopes, (nearby[0] - nearby[1]) / (2 * step), atol=1e-8)


def test_the_example_of_the_standard_is_one_curve() -> None:
    """Its four pieces meet to the digits that it prints."""
    (found,) = read(*[SP1.replace("\n", " ")])
    assert len(found.pieces) == 4
    for one, following in pairwise(found.pieces):
        np.testing.assert_allclose(one[-1], following[0], atol=2e-9)
    np.testing.assert_allclose(found.ends, [[0.0, 0.0, 0.03], [0.116, 0.008, 0.0]], atol=1e-6)


def test_a_circle_goes_from_degree_to_degree() -> None:
    """P(a) = M + r (V cos a + W sin a): here a from -90 to 180 degrees."""
    (found,) = read("K = CIRCLE / 10., 20., 30., 5., 0., 1., 0., 0., 0., 1., -90., 180.")
    center, v, w = np.array([0.01, 0.02, 0.03]), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    for number, piece in enumerate(found.pieces):
        points, slopes = points_on(piece, np.linspace(0.0, 1.0, 9))
        np.testing.assert_allclose(np.linalg.norm(points - center, axis=1), 0.005, atol=1e-15)
        begin = np.radians(90.0 * (number - 1))
        np.testing.assert_allclose(points[0], center + 0.005 * (np.cos(begin) * v + np.sin(begin) * w), atol=1e-15)
        np.testing.assert_allclose(np.einsum("ij,ij->i", slopes, points - center), 0.0, atol=1e-15)
    assert len(found.pieces) == 3


def test_points_are_joined_by_lines_and_keep_their_normals() -> None:
    pset, mdi = read(
        "PS = PSET / 3, 0., 0., 0., 10., 0., 0., 10., 20., 0.",
        "PT = POINT / 1., 2., 3.",
        "MD = MDI / 2, 0., 0., 0., 0., 0., 2., 10., 0., 0., 3., 0., 4.",
    )
    (way,) = ways([pset], 1e-4)
    np.testing.assert_allclose(way.points, [[0, 0, 0], [0.01, 0, 0], [0.01, 0.02, 0]], atol=1e-15)
    np.testing.assert_allclose(np.degrees(way.corners()), [0.0, 90.0, 0.0])
    np.testing.assert_allclose(way.tangents, [[1, 0, 0], [np.sqrt(0.5), np.sqrt(0.5), 0], [0, 1, 0]], atol=1e-15)
    (way,) = ways([mdi], 1e-4)
    np.testing.assert_allclose(frames(way, [1.0, 0.0, 0.0])[:, :3, 2], [[0, 0, -1], [-0.6, 0, -0.8]], atol=1e-15)


def test_a_curve_has_a_direction_where_it_stands_still() -> None:
    """(t^3, 0, 0) has no derivative at 0; ((2 t - 1)^2, (2 t - 1)^3, 0) none at 1/2, where it turns back along x."""
    cube = polynomial(np.array([[0.0] * 3, [0.0] * 3, [0.0] * 3, [1.0, 0.0, 0.0]]))
    np.testing.assert_allclose(directions(cube, [0.0, 1.0]), [[1.0, 0.0, 0.0]] * 2, atol=1e-12)
    cusp = np.array([[1.0, -1.0, 0.0], [-4.0, 6.0, 0.0], [4.0, -12.0, 0.0], [0.0, 8.0, 0.0]])
    np.testing.assert_allclose(directions(polynomial(cusp), [0.5]), [[1.0, 0.0, 0.0]], atol=1e-3)
    (way,) = ways([Curve("CUSP", (polynomial(cusp),))], 1e-3)
    assert np.isfinite(way.tangents).all() and np.isfinite(way.corners()).all()
    loop = polynomial(1e-5 * np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [-1.0, -2.0, 0.0], [0.0, 1.0, 0.0]]))
    (way,) = ways([Curve("LOOP", (loop,))], 1e-3)  # from 0 to 0, and all of it within the tolerance
    assert len(way.points) == 3 and np.isfinite(way.corners()).all()


@pytest.mark.parametrize("arcs", [False, True])
def test_a_way_is_nowhere_off_the_curve(rng: np.random.Generator, arcs: bool, draws: Draws) -> None:
    """Each point of its lines and arcs is within the tolerance of a fine polyline of the curve."""
    tolerance = 1e-4
    counts = []
    for _ in range(draws(10)):
        coefficients = 0.2 * rng.normal(size=(4, 3))
        curve = Curve("C", (polynomial(coefficients),))
        (way,) = ways([curve], tolerance, arcs=arcs)
        fine = points_on(curve.pieces[0], np.linspace(0.0, 1.0, 20_001))[0]
        points = along(way)
        nearest = [np.linalg.norm(fine - point, axis=1).min() for point in points[::3]]
        assert max(nearest) <= 1.1 * tolerance + 3e-5  # deviations are seen at 9 points; the polyline has steps
        np.testing.assert_allclose(way.points[[0, -1]], curve.ends, atol=1e-12)
        counts.append(len(way.points))
    assert np.mean(counts) < (30 if arcs else 90)


def test_a_circle_is_arcs_without_corners_and_a_line_is_one_line() -> None:
    circle, line = read(
        "K = CIRCLE / 0., 0., 0., 100., 1., 0., 0., 0., 1., 0., 0., 360.",
        curve_element("L", [[[0.0] * 3, [100, 0, 0]]]),
    )
    (way,) = ways([circle], 1e-6)
    assert len(way.points) == 5 and not np.isnan(vias_of(way)).any()
    np.testing.assert_allclose(np.linalg.norm(along(way), axis=1), 0.1, atol=1e-12)
    np.testing.assert_allclose(way.corners(), 0.0, atol=1e-7)
    (way,) = ways([line], 1e-6)
    assert len(way.points) == 2 and np.isnan(vias_of(way)).all()


def test_curves_that_meet_are_one_way_also_backwards() -> None:
    first, second, apart = read(
        "A = PSET / 2, 0., 0., 0., 10., 0., 0.",
        "B = PSET / 2, 10., 10., 0., 10., 0., 0.",
        "C = PSET / 2, 50., 0., 0., 60., 0., 0.",
    )
    one, other = ways([first, second, apart], 1e-4)
    np.testing.assert_allclose(one.points[:, :2], [[0, 0], [0.01, 0], [0.01, 0.01]])
    assert len(ways([first, Curve("N", second.pieces, np.tile([0.0, 0.0, 1.0], (2, 1)))], 1e-4)) == 2
    assert one.names == ("A, point 1", "A, point 2", "B, point 2") and len(other.points) == 2


def test_frames_have_z_along_the_axis_and_x_along_the_way() -> None:
    (circle,) = read("K = CIRCLE / 0., 0., 0., 100., 1., 0., 0., 0., 1., 0., 0., 90.")
    (way,) = ways([circle], 1e-6)
    turned, kept = frames(way, [0.0, 0.0, -2.0]), frames(way, [0.0, 0.0, -2.0], turn=False)
    np.testing.assert_allclose(turned[:, :3, 2], [[0, 0, -1]] * 2, atol=1e-15)
    np.testing.assert_allclose(turned[:, :3, 0], [[0, 1, 0], [-1, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(kept[:, :3, 0], [[0, 1, 0]] * 2, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(turned[:, :3, :3]), 1.0)
    with pytest.raises(InvalidArgumentError, match="K, point 1: the tool's axis is along the way"):
        frames(way, [0.0, 1.0, 0.0])
    with pytest.raises(InvalidArgumentError, match="three numbers that are not all 0"):
        frames(way, [0.0, 0.0, 0.0])


def test_corners_are_rounded_off_within_the_tolerance() -> None:
    """A parabola from a before to a behind a corner has its middle at (before + 2 corner + behind) / 4."""
    points = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.002, 0.0], [0.2, 0.003, 0.0]])
    (way,) = ways([Curve("C", polyline(points))], 1e-4)
    zones = _zones(way, 1e-3)
    assert zones[0] == zones[3] == 0.0
    for at in (1, 2):
        sides = [points[at + side] - points[at] for side in (-1, 1)]
        before, behind = (points[at] + zones[at] * one / np.linalg.norm(one) for one in sides)
        assert np.linalg.norm(0.25 * (before + 2 * points[at] + behind) - points[at]) <= 1e-3 + 1e-12
    assert zones[1] == zones[2] == pytest.approx(0.001)  # half of the line between
    assert not _zones(way, 1e-6)[1:3].any()  # the tool stops instead
    (circle,) = read("K = CIRCLE / 0., 0., 0., 100., 1., 0., 0., 0., 1., 0., 0., 180.")
    (way,) = ways([circle], 1e-6)
    np.testing.assert_allclose(way.radii(), 0.1)
    zone = _zones(way, 1e-4)[1]
    assert np.hypot(0.1, zone) - 0.1 == pytest.approx(0.5e-4, rel=1e-3)  # off its tangent


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("P = HEADER / 0\nC1 = CURVE / 1, 0., 1., 2, 0., 1O., 0., 0., 0., 0.\n", "part.vda:2: C1 = CURVE has '1O.' as"),
        (
            "P = HEADER / 0\nC1 = CURVE / 1, 0., 1., 4, 0., 1.\n",
            "C1 = CURVE ends in the coefficients of piece 1: it has 6",
        ),
        ("P = HEADER / 0\nC1 = CURVE / 1, 0., 1., 1, 0., 1., 2., 3.\n", "has 8 numbers; it needs 7"),
        ("P = HEADER / 0\nC1 = CURVE / 1, 1., 1., 1, 0., 1., 2.\n", "has parameters that do not grow"),
        ("P = HEADER / 0\nC1 = CURVE / 0.5, 1., 1., 1, 0., 1., 2.\n", "has 0.5 pieces; there are 1 to"),
        ("P = HEADER / 0\nX1 = SPIRAL / 1\n", "part.vda:2: X1 = SPIRAL is no element of VDA-FS, which has BEGINSET"),
        ("P = HEADER / 0\nT1 = TLIST / 1, M1\n", "T1 = TLIST moves elements by matrices"),
        ("P = HEADER / 0\nK = CIRCLE / 0,0,0, -1, 1,0,0, 0,1,0, 0, 90\n", "has a radius of -1 mm"),
        ("P = HEADER / 0\nK = CIRCLE / 0,0,0, 1, 1,0,0, 1,1,0, 0, 90\n", "has axes that are not of length 1"),
        ("P = HEADER / 0\nK = CIRCLE / 0,0,0, 1, 1,0,0, 0,1,0, 90, 90\n", "goes from 90 to 90 degrees"),
        ("P = HEADER / 0\nM = MDI / 2, 0,0,0, 0,0,1, 1,0,0, 0,0,0\n", "has a vector without length at point 2"),
        ("P = HEADER / 0\nK = PSET / 2, 0,0,0, 1E999,0,0\n", "has a number in its points that is too great"),
        ("P = HEADER / two\n", "a header tells how many lines it has, not 'two'"),
        ("C1 = CURVE / 1, 0., 1., 1, 0., 1., 2.\n", "is no VDA-FS: it has no header"),
        ("ISO-10303-21;\n", "part.vda:1: 'ISO-10303-21;' is no element of VDA-FS"),
        ("", "is no VDA-FS"),
        ("P = HEADER / 0\nK = PSET / 2, 0,0,0, 0,0,0\nP = END\n", "the curve 'K' has no length"),
        ("P = HEADER / 0\nP1 = POINT / 0,0,0\nP = END\n", "part.vda has no curves"),
        ("P = HEADER / 0\nK = PSET / 2, 0,0,0, 1,0,0\n", "part.vda is cut off: it does not end with an END"),
    ],
)
def test_what_is_no_curve_is_refused_with_its_line(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "part.vda").write_text(text)
    with pytest.raises(InvalidArgumentError, match=words.replace("(", r"\(")):
        read_curves(tmp_path / "part.vda")


def test_files_are_told_by_their_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InvalidArgumentError, match=r"names end in \.vda, \.vdafs, \.iges, \.igs, \.step, \.stp"):
        read_curves(tmp_path / "part.dwg")
    with pytest.raises(InvalidArgumentError, match=r"part\.vda can't be read: No such file"):
        read_curves(tmp_path / "part.vda")
    monkeypatch.setattr(reading, "find_spec", lambda name: None)
    (tmp_path / "part.stp").write_text("ISO-10303-21;\nEND-ISO-10303-21;\n")
    with pytest.raises(WrongStateError, match=r"\.stp needs the package cadquery-ocp-novtk: pip install"):
        read_curves(tmp_path / "part.stp")


def test_names_are_told_apart_and_chosen(tmp_path: Path) -> None:
    file = tmp_path / "part.vda"
    file.write_text(vda_file("A = PSET / 2, 0,0,0, 1,0,0", "A = PSET / 2, 0,0,0, 0,1,0"))
    assert [one.name for one in read_curves(file)] == ["A", "A_2"]
    (found,) = read_curves(file, ["A_2"])
    np.testing.assert_allclose(found.ends[1], [0.0, 0.001, 0.0])
    with pytest.raises(UnknownNameError, match="has no curve 'B'; it has A, A_2"):
        read_curves(file, ["B"])


def test_the_command_lists_curves_without_a_kernel(tmp_path: Path) -> None:
    (tmp_path / "part.vda").write_text(
        vda_file("LINE = PSET / 2, 0,0,0, 30,0,40", "K = CIRCLE / 0,0,5, 100, 1,0,0, 0,1,0, 0, 180")
    )
    done = CliRunner().invoke(command, ["curves", str(tmp_path / "part.vda")], standalone_mode=False)
    assert done.output.splitlines() == [
        "LINE: 50 mm from (0, 0, 0) to (30, 0, 40)",
        f"K: {100 * np.pi:.6g} mm from (100, 0, 5) to (-100, 0, 5)",
    ]
    done = CliRunner().invoke(command, ["curves", str(tmp_path / "part.vda"), "--tool-axis", "down"])
    assert done.exit_code == 2 and "'down' is not numbers with commas between them" in done.output
