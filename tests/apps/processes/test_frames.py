"""Frames of a tool by work and travel angle, offsets, passes and weaves: against formulas, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.curves.way import Way, checked_way
from virtualrobot_apps.processes.sources.edges import edges, nearest
from virtualrobot_apps.processes.sources.frames import tool_frames, weave
from virtualrobot_apps.processes.sources.offsets import offset, passes
from virtualrobot_apps.processes.sources.picked import spline
from virtualrobot_apps.processes.sources.sampling import sampled

from tests.apps.processes.workpieces import tee_joint, tee_of_pipes

UP = (0.0, 0.0, 1.0)
FOOT = sampled(nearest(edges(tee_joint()), [0.0, 0.02, 0.0]))
"""The foot of the wall on the side of +y: floor up, wall along y."""
LINE = sampled(checked_way([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]], UP))


def circle(radius: float, closed: bool = True) -> Way:
    """Return a circle about the origin, counter-clockwise seen from above, on a surface that faces up."""
    angles = np.linspace(0.0, 2.0 * np.pi, 73)[: -1 if closed else None]
    points = radius * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    return spline(points, UP, closed=closed, chord=1e-6)


def test_a_torch_is_along_the_bisector_of_a_corner() -> None:
    frames = tool_frames(FOOT)
    np.testing.assert_allclose(frames[:, :3, 2], [[0.0, -np.sqrt(0.5), -np.sqrt(0.5)]] * len(frames), atol=1e-9)
    np.testing.assert_allclose(np.abs(frames[:, 0, 0]), 1.0)
    np.testing.assert_allclose(frames[:, :3, 3], FOOT.points)
    rotations = frames[:, :3, :3]
    np.testing.assert_allclose(
        rotations @ rotations.transpose(0, 2, 1), np.tile(np.eye(3), (len(frames), 1, 1)), atol=1e-9
    )
    np.testing.assert_allclose(np.linalg.det(rotations), 1.0)


@pytest.mark.parametrize(("work", "travel"), [(30.0, 0.0), (55.0, 10.0), (45.0, -15.0), (0.0, 20.0)])
def test_work_and_travel_angle_are_those_of_the_welders(work: float, travel: float) -> None:
    """From the floor's normal to the torch's plane, and from the plane across the seam to the torch (AWS A3.0)."""
    z = tool_frames(FOOT, work=np.radians(work), travel=np.radians(travel))[:, :3, 2]
    along = FOOT.tangents
    np.testing.assert_allclose(np.degrees(np.arctan2(-z[:, 1], -z[:, 2])), work, atol=1e-9)
    np.testing.assert_allclose(np.degrees(np.arcsin(np.einsum("ij,ij->i", z, along))), travel, atol=1e-9)
    # From the wall instead of the floor.
    z = tool_frames(FOOT, work=np.radians(work), base=(0.0, 1.0, 0.0))[:, :3, 2]
    np.testing.assert_allclose(np.degrees(np.arctan2(-z[:, 2], -z[:, 1])), work, atol=1e-9)
    # A seam that goes the other way round is welded from the same side.
    turned = tool_frames(FOOT.reversed(), work=np.radians(work), travel=np.radians(travel))[:, :3, 2]
    np.testing.assert_allclose(np.degrees(np.arctan2(-turned[:, 1], -turned[:, 2])), work, atol=1e-9)


def test_on_a_surface_the_work_angle_is_to_the_left() -> None:
    frames = tool_frames(LINE, work=np.radians(20.0), standoff=0.15)
    out = np.array([0.0, np.sin(np.radians(20.0)), np.cos(np.radians(20.0))])
    np.testing.assert_allclose(frames[:, :3, 2], [-out] * len(frames), atol=1e-9)
    np.testing.assert_allclose(frames[:, :3, 3], LINE.points + 0.15 * out)


def test_frames_round_a_loop_end_as_they_begin() -> None:
    """On the saddle of two pipes, each frame against the bisector of the pipes' normals."""
    (seam,) = edges(tee_of_pipes())
    way = sampled(seam, 1e-4, 5e-3)
    frames = tool_frames(way, travel=np.radians(10.0))
    np.testing.assert_allclose(frames[0], frames[-1], atol=1e-9)
    assert np.einsum("ij,ij->i", frames[:, :3, 2], way.outward).max() < -np.cos(np.radians(12.0))
    assert np.einsum("ij,ij->i", frames[:-1, :3, 0], frames[1:, :3, 0]).min() > 0.99


def test_offsets_of_a_circle_are_circles() -> None:
    """To the left of a circle that goes counter-clockwise is its inside."""
    way = circle(0.05)
    for across, radius in ((0.01, 0.04), (-0.01, 0.06)):
        beside = offset(way, across, 0.002)
        np.testing.assert_allclose(np.linalg.norm(beside.points[:, :2], axis=1), radius, atol=1e-5)
        np.testing.assert_allclose(beside.points[:, 2], 0.002)
    with pytest.raises(InvalidArgumentError, match=r"at points\[0\] of the way, .* bends closer than 60 mm"):
        offset(way, 0.06)
    with pytest.raises(InvalidArgumentError, match="the offset away is inf m; it must be finite"):
        offset(way, 0.0, np.inf)


def test_passes_lie_in_the_corner() -> None:
    """Root, then beside it on the floor and on the wall: a leg of 6 mm is half of its diagonal out and across."""
    far = 0.006 / np.sqrt(2.0)
    root, first, second = passes(FOOT, [(0.0, 0.0), (far, far), (-far, far)], back_and_forth=True)
    np.testing.assert_allclose(root.points, FOOT.points)
    legs = sorted(one.points.mean(axis=0)[1:].round(9).tolist() for one in (first, second))
    np.testing.assert_allclose(legs, [[0.005, 0.006], [0.011, 0.0]], atol=1e-9)
    assert first.points[0, 0] == FOOT.points[-1, 0] and second.points[0, 0] == FOOT.points[0, 0]
    with pytest.raises(InvalidArgumentError, match=r"there are no passes: give \(across, away\)"):
        passes(FOOT, [])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"travel": np.radians(90.0)}, "the travel angle is 90 degrees; it is from -80 to 80"),
        ({"travel": np.nan}, "the travel angle is nan degrees"),
        ({"work": np.radians(90.0)}, "the work angle is 90 degrees; it is between -90 and 90"),
        ({"standoff": np.nan}, "the standoff is nan m; it must be finite"),
        ({"work": 0.1, "base": (0.0, 0.0, 0.0)}, "the base has no length"),
    ],
    ids=["travel", "nan", "work", "standoff", "base"],
)
def test_angles_that_nobody_means_are_refused(options: dict[str, float], words: str) -> None:
    with pytest.raises(InvalidArgumentError, match=words):
        tool_frames(FOOT, **options)  # pyright: ignore[reportArgumentType]


def test_a_tool_along_its_way_is_refused() -> None:
    along = checked_way([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]], (1.0, 0.0, 0.0))
    with pytest.raises(
        InvalidArgumentError, match=r"at points\[0\] of the way, \(0, 0, 0\) mm, the tool would be along"
    ):
        tool_frames(along)
    back = checked_way([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]], [[[0, 0, 1], [0, 0, -1]]] * 2)
    with pytest.raises(InvalidArgumentError, match="the faces beside the way are back to back"):
        tool_frames(back)
    with pytest.raises(InvalidArgumentError, match="the faces leave open where the work angle goes"):
        tool_frames(back, work=0.3)


def test_a_weave_swings_across_its_seam() -> None:
    """A sine of 4 mm across 100 mm in ten waves; its frames look as those of the seam do."""
    frames = tool_frames(LINE)
    woven = weave(frames, 0.004, 0.0102)
    assert woven.shape == (121, 4, 4)
    np.testing.assert_allclose(woven[:, :3, :3], np.tile(frames[0, :3, :3], (121, 1, 1)), atol=1e-12)
    x, y, z = woven[:, :3, 3].T
    np.testing.assert_allclose(x, np.linspace(0.0, 0.1, 121), atol=1e-12)
    np.testing.assert_allclose(np.abs(y), 0.002 * np.abs(np.sin(2.0 * np.pi * x / 0.01)), atol=1e-9)
    np.testing.assert_allclose(z, 0.0)
    y = weave(frames, 0.004, 0.01, "triangle")[:, 1, 3]
    np.testing.assert_allclose(np.abs(np.diff(y)), 0.001, atol=1e-9)
    y = np.abs(weave(frames, 0.004, 0.01, "trapezoid")[:13, 1, 3])
    np.testing.assert_allclose(y, 0.002 * np.array([0, 0.5, 1, 1, 1, 0.5, 0, 0.5, 1, 1, 1, 0.5, 0]), atol=1e-9)


@pytest.mark.parametrize(
    ("width", "length", "shape", "words"),
    [
        (0.11, 0.01, "sine", r"at frames\[\d+\] the way bends closer than 55 mm, half the width of the weave"),
        (0.0, 0.01, "sine", "the width of a weave is 0 m; it must be above 0"),
        (0.01, np.nan, "sine", "the length of a wave is nan m"),
        (0.01, 1.0, "sine", "a wave of 1000 mm is longer than its way, 314"),
        (0.01, 0.01, "zigzag", "a weave is one of sine, triangle, trapezoid, not 'zigzag'"),
    ],
)
def test_weaves_that_nobody_means_are_refused(width: float, length: float, shape: str, words: str) -> None:
    """Among them one wider than the bend of its way, a circle of 50 mm."""
    with pytest.raises(InvalidArgumentError, match=words):
        weave(tool_frames(circle(0.05)), width, length, shape)
    assert len(weave(tool_frames(circle(0.05)), 0.09, 0.05))
