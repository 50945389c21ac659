"""Corners of ways: rounded within, gone round by a loop, and where a way is lifted; on two lines, by geometry."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError, MalformedFileError
from virtualrobot_apps.cell_io.yaml_file import parse
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.cut import read_cut
from virtualrobot_apps.processes.mill import read_mill
from virtualrobot_apps.processes.sources.corners import corners, looped, parted, rounded
from virtualrobot_apps.processes.sources.frames import heading_frames
from virtualrobot_apps.processes.sources.sampling import sampled
from virtualrobot_kernel.motion.spline import spline

CORNER = np.array([0.05, 0.0, 0.0])


def bent(degrees: float) -> Way:
    """Return two lines of 50 mm, along x first, that turn to the left at CORNER."""
    turn = np.radians(degrees)
    points = np.array([[0.0, 0.0, 0.0], CORNER, CORNER + 0.05 * np.array([np.cos(turn), np.sin(turn), 0.0])])
    return sampled(Way(points, np.tile([[[0.0, 0.0, 1.0]]], (3, 1, 1))))


def gone(way: Way) -> Floats:
    """Return points (n, 3) that a tool passes on the spline through the frames of a way."""
    frames = heading_frames(way)
    curve = spline(frames[0], list(frames[1:]))
    return np.array([curve.pose(u)[:3, 3] for u in np.linspace(0.0, 1.0, 2001)])


def beyond(points: Floats, degrees: float) -> float:
    """Return how far points are outside of the corner, to the right of either line (m)."""
    turn = np.radians(degrees)
    return float(np.maximum(-points[:, 1], -((points - CORNER) @ [-np.sin(turn), np.cos(turn), 0.0])).max())


@pytest.mark.parametrize("degrees", [40.0, 90.0, 145.0])
def test_a_rounded_corner_is_never_beyond_and_as_near_as_asked(degrees: float) -> None:
    """A sharp one is gone beyond by 0.15 to 0.27 mm; of the spline, whose points are farther apart away from it."""
    way = bent(degrees)
    assert beyond(gone(way), degrees) > 1.4e-4
    points = gone(rounded(way, 1e-4))
    assert beyond(points, degrees) < 5e-7
    assert np.linalg.norm(points - CORNER, axis=1).min() == pytest.approx(1e-4, abs=1e-6)
    np.testing.assert_allclose(points[[0, -1]], way.points[[0, -1]], atol=1e-12)
    tight = rounded(way, 1.0)  # as far as the lines have room
    assert (np.diff(tight.points[:, 0][tight.points[:, 1] < 1e-9]) > 0.0).all()


def test_a_loop_is_gone_outside_and_straight_through_the_corner() -> None:
    """The circle that touches both lines beyond the corner: from (60, 0) round (60, -10) to (50, -10), in mm."""
    way = looped(bent(90.0), 0.01)
    assert len(corners(way)[0]) == 0
    outside = way.points[(way.points[:, 1] < -1e-9) & (way.points[:, 0] > 0.05 + 1e-9)]
    np.testing.assert_allclose(np.linalg.norm(outside - [0.06, -0.01, 0.0], axis=1), 0.01, atol=1e-12)
    assert way.length == pytest.approx(0.1 + 2 * 0.01 + 1.5 * np.pi * 0.01, rel=2e-3)
    assert (np.linalg.norm(way.points - CORNER, axis=1) < 1e-12).sum() == 2


def test_a_way_is_lifted_at_its_corners() -> None:
    one, two = parted(bent(90.0))
    np.testing.assert_allclose([one.points[-1], two.points[0]], [CORNER, CORNER])
    assert len(parted(one)) == 1


def test_a_way_that_goes_back_is_refused() -> None:
    way = bent(160.0)
    for made in (lambda: rounded(way, 1e-4), lambda: looped(way, 0.01)):
        with pytest.raises(InvalidArgumentError, match="turns by 160 degrees, nearly back: lift the tool there"):
            made()
    with pytest.raises(InvalidArgumentError, match="must be"):
        rounded(way, 0.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [("{}", "one of `round`"), ("{round: 0.1, lift: true}", "one of `round`"), ("{loop: 0}", "a number from")],
)
def test_a_file_says_what_is_done_at_corners(given: str, words: str) -> None:
    head = "schema_version: 1\nprocess: any\nrobot: arm\nspeed: 0.1\n"
    cut = f"{head}cuts: [{{part: p, points: [[0, 0, 0], [0.1, 0, 0]], normal: [0, 0, 1]}}]\ncorners: "
    with pytest.raises(MalformedFileError, match=words):
        read_cut(parse(cut + given, "a"))
    for right, count in (("{lift: true}", 2), ("{loop: 0.01}", 1), ("{round: 0.001}", 1)):
        assert len(read_cut(parse(cut + right, "a")).head.corners(bent(90.0))) == count
    mill = f"{head}cuts: [{{part: p, gcode: a.nc}}]\ncutter: {{heading: [1, 0, 0]}}\ncorners: {{lift: true}}"
    with pytest.raises(MalformedFileError, match="lifted where the G-code lifts it"):
        read_mill(parse(mill, "a"))
