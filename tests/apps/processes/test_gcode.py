"""G-code as ways: lines, arcs and helices by formulas, units and modes, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError, MalformedFileError
from virtualrobot_apps.processes.sources.frames import heading_frames, tool_frames
from virtualrobot_apps.processes.sources.gcode import read_gcode
from virtualrobot_apps.processes.sources.sampling import sampled

SQUARE = """\
%
O1000 (a square of 40 mm, 2 mm deep)
N10 G21 G17 G90 G94 T1 M6
N20 S8000 M3
G0 X0 Y0 Z5
G1 Z-2 F120
X40 F600 ; to the right
Y40
X0
Y0
G0 Z5
M30
what comes after it is not read
"""


def test_lines_between_rapid_moves_are_a_cut() -> None:
    (cut,) = read_gcode(SQUARE)
    corners = [[0, 0, 5], [0, 0, -2], [40, 0, -2], [40, 40, -2], [0, 40, -2], [0, 0, -2]]
    np.testing.assert_allclose(cut.way.points, np.array(corners) / 1e3, atol=1e-12)
    np.testing.assert_allclose(cut.feeds, [0.002, 0.01, 0.01, 0.01, 0.01])
    assert cut.line == 6 and cut.way.normals.tolist() == [[[0.0, 0.0, 1.0]]] * 6
    dense = sampled(cut.way, step=2e-3)
    assert dense.length == pytest.approx(0.167)
    assert all(np.linalg.norm(dense.points - corner, axis=1).min() < 1e-12 for corner in np.array(corners) / 1e3)


def test_a_tool_that_plunges_keeps_its_heading() -> None:
    """Z down and x where it was said, also where the tool goes along its own axis, which has no x along the way."""
    dense = sampled(read_gcode(SQUARE)[0].way)
    frames = heading_frames(dense, (1.0, 1.0, 1.0), standoff=0.01)
    turn = np.array([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, -np.sqrt(2.0)]]) / np.sqrt(2.0)
    np.testing.assert_allclose(frames[:, :3, :3], np.tile(turn.T, (len(frames), 1, 1)), atol=1e-12)
    np.testing.assert_allclose(frames[:, :3, 3], dense.points + np.array([0.0, 0.0, 0.01]))
    with pytest.raises(InvalidArgumentError, match=r"at points\[0\] of the way, .* the heading is along the normal"):
        heading_frames(dense, (0.0, 0.0, 1.0))
    with pytest.raises(InvalidArgumentError, match="the tool would be along the way"):
        tool_frames(dense)
    (pecked,) = read_gcode("G1 Z-2\nZ2\nZ-4")
    assert heading_frames(sampled(pecked.way))[:, 2, 3].min() == -0.004
    with pytest.raises(InvalidArgumentError, match="it turns back on itself, which leaves its direction open"):
        tool_frames(read_gcode("G1 X2\nX0\nX2")[0].way)


@pytest.mark.parametrize(
    ("text", "centre", "radius", "degrees"),
    [
        ("G0 X10 Y0\nG3 X0 Y10 I-10 J0", (0, 0), 10, 90),
        ("G0 X10 Y0\nG2 X0 Y10 I-10 J0", (0, 0), 10, -270),
        ("G0 X10 Y0\nG3 X0 Y10 R10", (0, 0), 10, 90),
        ("G0 X10 Y0\nG3 X0 Y10 R-10", (10, 10), 10, 270),
        ("G0 X10 Y0\nG2 X0 Y10 R10", (10, 10), 10, -90),
        ("G0 X10 Y0\nG2 X0 Y10 R-10", (0, 0), 10, -270),
        ("G0 X10 Y0\nG3 I-10", (0, 0), 10, 360),
        ("G0 X10 Y0\nG2 X10 Y0 I-10", (0, 0), 10, -360),
        ("G90.1 G0 X10 Y0\nG3 X-10 Y0 I0 J0", (0, 0), 10, 180),
        ("G91 G0 X10\nG3 X-20 I-10 J0", (0, 0), 10, 180),
        ("G20 G0 X1 Y0\nG3 X0 Y1 I-1 J0", (0, 0), 25.4, 90),
    ],
)
def test_arcs_are_on_their_circles(text: str, centre: tuple[float, float], radius: float, degrees: float) -> None:
    """Points on the circle, chords within the tolerance, as far round and in the sense that the text says."""
    (cut,) = read_gcode(text, chord=1e-5)
    aside = 1e3 * cut.way.points[:, :2] - centre
    np.testing.assert_allclose(np.linalg.norm(aside, axis=1), radius, atol=1e-9)
    turn = np.unwrap(np.arctan2(aside[:, 1], aside[:, 0]))
    assert np.degrees(turn[-1] - turn[0]) == pytest.approx(degrees)
    middles = 0.5 * (aside[1:] + aside[:-1])
    assert radius - np.linalg.norm(middles, axis=1).min() <= 0.01 + 1e-9
    assert np.isnan(cut.feeds).all()


def test_helices_and_other_planes() -> None:
    """A helix climbs evenly. In G18 (zx) and G19 (yz) arcs turn about y and x."""
    (helix,) = read_gcode("G0 X10\nG3 X10 Y0 Z4 I-10 J0")
    x, y, z = 1e3 * helix.way.points.T
    np.testing.assert_allclose(z, np.unwrap(np.arctan2(y, x)) / (2.0 * np.pi) * 4.0, atol=1e-9)
    (quarter,) = read_gcode("G18 G0 Z10\nG3 X10 Z0 K-10")
    np.testing.assert_allclose(np.hypot(*1e3 * quarter.way.points[:, [0, 2]].T), 10.0)
    assert 1e3 * quarter.way.length == pytest.approx(5.0 * np.pi, rel=1e-2)
    (quarter,) = read_gcode("G19 G0 Y10\nG3 Y0 Z10 J-10")
    np.testing.assert_allclose(np.hypot(*1e3 * quarter.way.points[:, [1, 2]].T), 10.0)
    assert 1e3 * quarter.way.length == pytest.approx(5.0 * np.pi, rel=1e-2)


def test_units_and_modes_count_for_the_whole_line() -> None:
    cuts = read_gcode("g1x1f60g20\n(inch)G21 G1 X0\nG91 X1 Y-.5\nG0 Z1\nG1 Z-1 M5\n/ G1 X1\n")
    np.testing.assert_allclose(cuts[0].way.points[:, :2], [[0, 0], [0.0254, 0], [0, 0], [0.001, -0.0005]], atol=1e-12)
    assert cuts[0].feeds.tolist() == pytest.approx([0.0254] * 3)
    np.testing.assert_allclose(cuts[1].way.points[-1], [0.002, -0.0005, 0.0], atol=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "code.nc:1: there is no cut: no G1, G2 or G3 goes anywhere"),
        ("G0 X1\nG1 X1", "code.nc:2: there is no cut"),
        ("G1 X1\nG5 X2", "code.nc:2: G5 is not read; moves are G0, G1, G2, G3"),
        ("G28 X0", "code.nc:1: G28 is not read"),
        ("X1", "code.nc:1: no move is set: G0, G1, G2 or G3 goes before the first place"),
        ("G1 A90", "code.nc:1: the axis or word A is not read; known are X Y Z I J K R F"),
        ("G1 X1 X2", "code.nc:1: X stands twice in the line"),
        ("G1 X#1", r"code.nc:1: 'X#' is not read; words are a letter and a number|code.nc:1: .*is not read"),
        ("G1 X1 F0", "code.nc:1: the feed is 0; it must be above 0"),
        ("G1 X1 I2", "code.nc:1: I, J, K and R are of arcs, and G1 is set"),
        ("G2 X1 Y1", r"code.nc:1: an arc in this plane has a centre \(I, J\) or a radius \(R\)"),
        ("G2 X10 I4", "code.nc:1: the ends of the arc are 4 and 6 mm from its centre; they must be the same"),
        ("G2 X30 R10", "code.nc:1: the ends of the arc are 30 mm apart, more than twice its radius, 10 mm"),
        ("G2 R10", "code.nc:1: an arc by its radius needs another end than its beginning"),
        ("G2 X2 I1 P3", "code.nc:1: P, the number of turns of an arc, is not read"),
    ],
)
def test_what_is_not_read_is_told_with_its_line(text: str, words: str) -> None:
    with pytest.raises(MalformedFileError, match=words) as refused:
        read_gcode(text, file="code.nc")
    assert refused.value.metadata["file"] == "code.nc"


def test_a_chord_is_above_zero() -> None:
    with pytest.raises(InvalidArgumentError, match="the chord is 0 m; it must be above 0"):
        read_gcode(SQUARE, chord=0.0)
