"""Frames along points: their axes on a circle and a line, and points and axes that make none."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LINE = np.linspace([0.0, 0.0, 0.0], [0.3, 0.0, 0.0], 4)


def test_frames_stand_at_the_points_with_z_along_the_axis_and_x_along_the_way() -> None:
    frames = virtualrobot.path_frames(LINE, (1.0, 0.0, -1.0))
    np.testing.assert_array_equal(frames[:, :3, 3], LINE)
    half = np.sqrt(0.5)
    # Of the way along x, what is across z is (half, 0, half); y is z x x.
    np.testing.assert_allclose(frames[:, :3, :3], [[[half, 0, half], [0, -1, 0], [half, 0, -half]]] * 4, atol=1e-12)


def test_the_way_along_a_circle_is_its_tangent_to_the_second_order() -> None:
    """The error of parabolas falls to a quarter where points are twice as dense, at the ends too."""
    worst = []
    for count in (21, 41):
        angles = np.linspace(0.0, np.pi, count)
        circle = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
        x = virtualrobot.path_frames(circle, np.tile([0.0, 0.0, -2.0], (count, 1)))[:, :3, 0]
        worst.append(np.abs(x - np.stack([-np.sin(angles), np.cos(angles), 0.0 * angles], axis=1)).max())
    assert worst[1] < 0.3 * worst[0] < 0.003


@pytest.mark.parametrize(
    ("points", "axis", "words"),
    [
        (np.zeros((0, 3)), (0.0, 0.0, 1.0), r"the shape \(n, 3\), n at least 2, not \(0, 3\)"),
        (LINE[:, :2], (0.0, 0.0, 1.0), r"not \(4, 2\)"),
        (LINE[[0, 1, 1, 2]], (0.0, 0.0, 1.0), r"points\[2\] is the same as points\[1\]; leave it out"),
        (
            LINE * [[1.0], [np.nan], [1.0], [1.0]],
            (0.0, 0.0, 1.0),
            r"points\[1\] is \[nan, nan, nan\]; it must be finite",
        ),
        (LINE, (0.0, 0.0, 0.0), r"the axis at points\[0\] has no length"),
        (LINE, (0.0, np.inf, 0.0), r"axis\[0\] is .*; it must be finite"),
        (LINE, (-1.0, 0.0, 1e-5), r"the axis at points\[0\] is along the way there, which leaves open how"),
        (LINE, np.eye(3), r"the axis of a path has the shape \(3,\), or \(4, 3\) as its points, not \(3, 3\)"),
    ],
)
def test_what_makes_no_frames_is_told(points: Floats, axis: Floats, words: str) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match=words):
        virtualrobot.path_frames(points, axis)
