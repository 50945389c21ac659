"""Sections, rasters and splines: circles, spacings and lines that formulas tell."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.curves.way import Way, checked_way
from virtualrobot_apps.demos.processes.workpieces import bent
from virtualrobot_apps.processes.sources.picked import spline
from virtualrobot_apps.processes.sources.raster import raster
from virtualrobot_apps.processes.sources.sampling import sampled
from virtualrobot_apps.processes.sources.sections import section

from tests.apps.processes.workpieces import box, plate, sheet, together

RADIUS, HEIGHT = 0.1, 0.03
BALL = trimesh.creation.icosphere(4, RADIUS)
SAGITTA = RADIUS - float(np.linalg.norm(BALL.triangles_center, axis=1).min())
"""Depth of the triangles below the ball's surface (m)."""


def heights(ways: list[Way], axis: int) -> list[float]:
    """Return the coordinate of ways that each has but one of."""
    for way in ways:
        np.testing.assert_allclose(way.points[:, axis], way.points[0, axis], atol=1e-9)
    return [round(float(way.points[0, axis]), 9) for way in ways]


def test_the_section_of_a_ball_is_a_circle() -> None:
    """At a height h it has the radius sqrt(R^2 - h^2), as far as the ball's triangles are within the ball."""
    (circle,) = section(BALL, [0.0, 0.0, HEIGHT], [0.0, 0.0, 2.0])
    radius = np.sqrt(RADIUS**2 - HEIGHT**2)
    assert circle.closed
    np.testing.assert_allclose(circle.points[:, 2], HEIGHT)
    assert (np.linalg.norm(circle.points, axis=1) <= RADIUS + 1e-12).all()
    assert (np.linalg.norm(circle.points, axis=1) >= RADIUS - SAGITTA - 1e-12).all()
    assert circle.length == pytest.approx(2.0 * np.pi * radius, rel=2e-3)
    # Counter-clockwise about the material, seen from where the normal points to.
    turn = np.unwrap(np.arctan2(circle.points[:, 1], circle.points[:, 0]))
    assert turn[-1] - turn[0] == pytest.approx(2.0 * np.pi)
    assert np.einsum("ij,ij->i", circle.normals[:, 0], circle.points / RADIUS).min() > np.cos(np.radians(3.0))


def test_sections_of_boxes_are_split_at_corners() -> None:
    sides = section(plate(), [0.0, 0.0, -0.01], [0.0, 0.0, 1.0])
    assert [way.length for way in sides] == pytest.approx([0.4, 0.4, 0.3, 0.3])
    (whole,) = section(plate(), [0.0, 0.0, -0.01], [0.0, 0.0, 1.0], corner=np.pi)
    assert whole.closed and whole.length == pytest.approx(1.4)
    kept = sampled(whole, 1e-4, 5e-3)
    assert kept.length == pytest.approx(1.4)
    for corner in ([0.2, 0.15], [-0.2, 0.15], [-0.2, -0.15], [0.2, -0.15]):
        assert np.linalg.norm(kept.points[:, :2] - corner, axis=1).min() < 1e-12


def test_sections_through_corners_and_of_open_meshes() -> None:
    """A plane through corners of triangles cuts each triangle once; an open mesh has open sections."""
    for height in (0.0, 0.1):
        (line,) = section(sheet(cells=8), [0.0, 0.1 * height, 0.0], [0.0, 1.0, 0.0])
        assert not line.closed and line.length == pytest.approx(0.2)
    assert len(section(together(plate(), box((0.1, 0.1, 0.1), (0, 0, 1))), [0, 0, 0], [1, 0, 0])) == 8
    with pytest.raises(
        InvalidArgumentError, match=r"the plane doesn't cut the mesh, which is from -51 to -49 mm along"
    ):
        section(box((0.1, 0.1, 0.002)), [0.0, 0.0, 0.05], [0.0, 0.0, 1.0])
    with pytest.raises(InvalidArgumentError, match="the normal has no length"):
        section(plate(), [0.0, 0.0, 0.0], [0.0, 0.0, 0.0])


@pytest.mark.parametrize("slope", [0.0, np.radians(30.0)])
def test_a_raster_on_a_slope_has_its_spacing_on_it(slope: float) -> None:
    """The spacing is that on the slope, seen along its mean normal or from above."""
    mesh = sheet(slope)
    ways = raster(mesh, 0.03, [1.0, 0.0, 0.0])
    up = np.array([0.0, np.cos(slope), np.sin(slope)])
    places = [float(way.points[0] @ up) for way in ways]
    assert len(ways) == 7
    np.testing.assert_allclose(np.diff(places), 0.03, atol=1e-9)
    np.testing.assert_allclose(np.add(places, places[::-1]), 0.0, atol=1e-9)
    for row, way in enumerate(ways):
        np.testing.assert_allclose(
            way.normals[:, 0], [[0.0, -np.sin(slope), np.cos(slope)]] * len(way.points), atol=1e-9
        )
        np.testing.assert_allclose(way.points[[0, -1], 0], [-0.1, 0.1] if row % 2 == 0 else [0.1, -0.1], atol=1e-9)
    above = raster(mesh, 0.03, [1.0, 0.0, 0.0], axis=[0.0, 0.0, -1.0])
    np.testing.assert_allclose([float(way.points[0] @ up) for way in above], places, atol=1e-9)


def test_a_raster_on_a_ball_is_even_along_its_arc() -> None:
    """At h along the step-over the ball has its ways at the angle asin(h / R): they are step-over / R apart, or less.

    Steepest are triangles, not the ball: half a triangle is 2 degrees, which is 5% at slopes of up to 50 degrees.
    """
    ways = raster(BALL, 0.02, [1.0, 0.0, 0.0], axis=[0.0, 0.0, -1.0], facing=np.radians(80.0))
    angles = np.arcsin(np.unique(heights(ways, 1)) / RADIUS)
    assert (np.diff(angles) <= 0.02 / RADIUS * 1.001).all()
    inner = angles[np.abs(angles) < np.radians(50.0)]
    assert len(inner) == 9
    np.testing.assert_allclose(np.diff(inner), 0.02 / RADIUS, rtol=0.05)


def test_a_raster_in_a_hollow_has_one_way_in_each_plane() -> None:
    """A sheet that is bent up both ways, 0.5 m wide along an arc of 0.9 m: what is seen is all of it."""
    hollow = bent(0.5, 0.6, 0.004, (-0.9, -1.2))
    ways = raster(hollow, 0.05, [0.0, 1.0, 0.0], axis=[0.0, 0.0, -1.0])

    def parabola(half: float, radius: float) -> float:
        """Return the length of x^2 / 2 r from -half to half."""
        slope = half / radius
        return radius * (slope * np.sqrt(1.0 + slope**2) + np.arcsinh(slope))

    assert len(ways) == np.ceil(parabola(0.25, 0.9) / 0.05)
    np.testing.assert_allclose([way.length for way in ways], parabola(0.3, 1.2), rtol=1e-3)


def test_a_raster_leads_in_and_out() -> None:
    ways = raster(sheet(), 0.05, [0.0, 1.0, 0.0], lead_in=0.02, lead_out=0.03, back_and_forth=False)
    for way in ways:
        np.testing.assert_allclose(way.points[[0, -1], 1], [-0.12, 0.13], atol=1e-9)


def test_a_raster_of_a_closed_body_is_on_what_is_seen() -> None:
    """A ball from above is half a ball; what lies below something else is left out, within a step."""
    ways = raster(BALL, 0.02, [1.0, 0.0, 0.0], axis=[0.0, 0.0, -1.0], facing=np.radians(80.0))
    assert np.add(heights(ways, 1), heights(ways[::-1], 1)) == pytest.approx(0.0, abs=1e-6)
    assert min(way.points[:, 2].min() for way in ways) >= RADIUS * np.cos(np.radians(84.0))
    roof = together(box((0.2, 0.2, 0.01)), box((0.05, 0.3, 0.01), (0.0, 0.0, 0.1)))
    step = 2e-3
    ways = raster(roof, 0.04, [1.0, 0.0, 0.0], axis=[0.0, 0.0, -1.0], step=step)
    below = [way for way in ways if way.points[0, 2] < 0.05]
    assert len(below) == 10 and len(ways) == 10 + 8
    for way in below:
        inner, outer = sorted(np.abs(way.points[[0, -1], 0]))
        assert outer == pytest.approx(0.1) and 0.025 - 1e-9 <= inner <= 0.025 + step


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"step_over": 0.0}, "the step_over is 0 m; it must be above 0"),
        ({"step_over": 1e-6}, r"a surface 0.2 m wide has over 10,000 ways 1e-06 m apart; is its unit m\?"),
        ({"direction": [0, 0, 1]}, "the direction of a raster is along its axis"),
        ({"axis": [0, 0, 1]}, "nothing of the surface faces the tool within 75 degrees; turn the axis round"),
        ({"lead_in": -0.1}, "the lead_in is -0.1 m; it must be 0 or more"),
        ({"mesh": box((0.1, 0.1, 0.1))}, "a closed surface has no mean normal; give the axis"),
        ({"step": np.nan}, "the step is nan m; it must be above 0"),
    ],
    ids=lambda value: str(value)[:20] if isinstance(value, str) else "-".join(value),
)
def test_rasters_that_nobody_means_are_refused(options: dict[str, object], words: str) -> None:
    given = {"mesh": sheet(), "step_over": 0.05, "direction": [1.0, 0.0, 0.0], **options}
    with pytest.raises(InvalidArgumentError, match=words):
        raster(**given)  # pyright: ignore[reportArgumentType]


def test_a_spline_goes_through_what_was_picked() -> None:
    """Twelve points of a circle: a cubic spline is within R (h^4) / 384 of it, h the angle between them (de Boor)."""
    angles = np.arange(12) * np.pi / 6.0
    points = RADIUS * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    way = spline(points, [0.0, 0.0, 3.0], closed=True, chord=1e-5)
    assert way.closed and way.normals[:, 0].tolist() == [[0.0, 0.0, 1.0]] * len(way.points)
    assert np.abs(np.linalg.norm(way.points, axis=1) - RADIUS).max() < 5.0 * RADIUS * (np.pi / 6.0) ** 4 / 384.0
    for point in points:
        assert np.linalg.norm(way.points - point, axis=1).min() < 1e-12
    middles = 0.5 * (way.points[1:] + way.points[:-1])
    assert np.abs(RADIUS - np.linalg.norm(middles, axis=1)).max() < 1e-4
    line = spline([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]], [0.0, 0.0, 1.0], step=0.03)
    assert len(line.points) == 5 and line.length == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("points", "normals", "words"),
    [
        ([], [0, 0, 1], r"the points of a way have the shape \(n, 3\), n at least 2, not \(0,\)"),
        ([[0, 0, 0]], [0, 0, 1], r"n at least 2, not \(1, 3\)"),
        ([[0, 0, 0], [1, 0, 0], [1, 0, 0]], [0, 0, 1], r"points\[2\] of the way is the same as points\[1\]"),
        ([[0, 0, 0], [np.nan, 0, 0]], [0, 0, 1], r"points\[1\] of the way is \[nan, 0.0, 0.0\]; it must be finite"),
        ([[0, 0, 0], [1, 0, 0]], [0, 0, 0], r"normals\[0\] of the way has no length"),
        ([[0, 0, 0], [1, 0, 0]], [0, 0, np.inf], r"normals\[0\] of the way is .*inf.*; it must be finite"),
        (
            [[0, 0, 0], [1, 0, 0]],
            [[0, 0, 1]],
            r"the normals of 2 points have the shape \(3,\), \(2, 3\) or \(2, 2, 3\)",
        ),
    ],
    ids=["empty", "one", "doubled", "nan", "no normal", "infinite normal", "too few normals"],
)
def test_points_that_make_no_way_are_refused(points: list[list[float]], normals: list[float], words: str) -> None:
    for make in (spline, checked_way):
        with pytest.raises(InvalidArgumentError, match=words):
            make(points, normals)


def rounded(radius: float, sides: int) -> Way:
    """Return a square of 200 mm with corners rounded by arcs of `sides` lines each, as a mesh would have it."""
    turn = np.linspace(0.0, 0.5 * np.pi, sides + 1)
    arc = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1) + 0.1 - radius
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    flat = np.concatenate([arc @ np.linalg.matrix_power(quarter.T, k) for k in range(4)])
    points = np.column_stack([np.concatenate([flat, flat[:1]]), np.zeros(4 * sides + 5)])
    return checked_way(points, [0.0, 0.0, 1.0], closed=True)


def test_what_is_straight_stays_so_beside_arcs() -> None:
    """A tangent of an arc's short lines would bulge the long ones beside it by a millimeter; arcs stay arcs."""
    radius = 0.02
    way = sampled(rounded(radius, 16), 1e-4, 5e-3)
    x, y = np.abs(way.points[:, :2]).T
    inner = 0.1 - radius
    straight = (x < inner) | (y < inner)
    np.testing.assert_allclose(np.maximum(x, y)[straight], 0.1, atol=1e-9)
    # Points of a cubic with one direction off by half a side's turn, 2.8 degrees, at the joints: within its sagitta.
    arcs = np.hypot(x - inner, y - inner)[~straight]
    np.testing.assert_allclose(arcs, radius, atol=radius * (1.0 - np.cos(np.pi / 64.0)))
    assert way.length == pytest.approx(8.0 * inner + 2.0 * np.pi * radius, rel=1e-3)


def test_a_polygon_is_no_circle_unless_the_chord_lets_it() -> None:
    """24 sides are R (1 - cos(pi / 24)) within their circle, 0.86 mm: a chord of 0.1 mm is less, one of 1.2 mm more."""
    angles = np.arange(25) * np.pi / 12.0
    points = RADIUS * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    points[-1] = points[0]
    way = checked_way(points, [0.0, 0.0, 1.0], closed=True)
    sharp, smooth = sampled(way, 1e-4), sampled(way, 1.2e-3)
    assert np.linalg.norm(sharp.points, axis=1).min() == pytest.approx(RADIUS * np.cos(np.pi / 24.0), rel=1e-4)
    # Derivatives at the points are those of parabolas, 1 - cos(pi / 24) short: 0.9% of the sagitta.
    assert np.abs(np.linalg.norm(smooth.points, axis=1) - RADIUS).max() < 2e-5


def test_a_chord_that_takes_too_many_points_is_refused() -> None:
    with pytest.raises(InvalidArgumentError, match=r"a curve within 1e-13 m of the lines between its points has over"):
        spline([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]], [0.0, 0.0, 1.0], chord=1e-13)


def test_a_loop_smaller_than_its_chord_is_refused() -> None:
    loop = spline(1e-6 * np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]), [0.0, 0.0, 1.0], closed=True)
    with pytest.raises(InvalidArgumentError, match="mm is shorter than its chord lets it be"):
        sampled(loop)


def test_a_way_in_millimeters_is_refused() -> None:
    with pytest.raises(InvalidArgumentError, match=r"a way of 1e\+06 m in steps of 0.005 m has over 100,000 points"):
        spline([[0.0, 0.0, 0.0], [1e6, 0.0, 0.0]], [0.0, 0.0, 1.0])
