"""Rounded corners: smooth at their borders, between the legs, and nothing else of the paths is touched."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.motion.blend import round_corner, rounded
from virtualrobot_kernel.motion.blend_law import law_through
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.path import joint_line, quintic_hermite
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.rates import joint_rates


def curve(rng: np.random.Generator, start: np.ndarray) -> PiecewisePolynomial:
    """Return a random path of four joints from `start`, twice continuously differentiable, with a random length."""
    knots = np.cumsum(rng.uniform(0.2, 1.0, 5))
    positions, rates, curvatures = (rng.normal(size=(5, 4)) for _ in range(3))
    positions[0] = start
    return quintic_hermite(knots - knots[0], positions, rates, curvatures)


def test_the_whole_is_twice_differentiable_and_the_same_outside_its_corners(rng: np.random.Generator) -> None:
    paths = [curve(rng, rng.normal(size=4))]
    for _ in range(4):
        paths.append(curve(rng, paths[-1].evaluate(paths[-1].end)))
    shares = rng.uniform(0.05, 0.5, (4, 2))
    corners = [
        round_corner(before, after, left * before.end, right * after.end)
        for before, after, (left, right) in zip(paths[:-1], paths[1:], shares, strict=True)
    ]
    whole = rounded(paths, corners)
    for x in whole.path.breaks[1:-1]:
        before, after = whole.path.states(np.array([np.nextafter(x, -1.0), x]), 2).transpose(1, 0, 2)
        assert np.allclose(before, after, rtol=1e-9, atol=1e-9)
    for place, (path, (begin, end)) in enumerate(zip(paths, whole.moves, strict=True)):
        skipped = shares[place - 1, 1] * path.end if place else 0.0
        x = np.linspace(begin, end, 50)
        assert np.allclose(whole.path.evaluate(x), path.evaluate(x - begin + skipped), rtol=0.0, atol=1e-9)
    ranges = sorted([*whole.moves, *whole.corners])
    assert ranges[0][0] == 0.0 and ranges[-1][1] == whole.path.end
    assert all(one[1] == other[0] for one, other in pairwise(ranges))


@pytest.mark.parametrize("slower", [1.0, 3.0, 100.0])
def test_a_corner_of_straight_lines_stays_between_them_however_much_slower_one_is(
    rng: np.random.Generator, slower: float
) -> None:
    corner, ahead, behind = rng.normal(size=(3, 3))
    before, after = joint_line(ahead, corner), joint_line(corner, behind).onto(0.0, slower)
    left, right = rng.uniform(0.1, 0.5, 2) * (1.0, slower)
    piece = round_corner(before, after, left, right).piece
    points = piece.evaluate(np.linspace(0.0, piece.end, 200)) - corner
    legs = np.stack([ahead - corner, behind - corner], axis=1)
    shares, residuals = np.linalg.lstsq(legs, points.T, rcond=None)[:2]
    assert np.all(residuals < 1e-20)  # in the plane of the legs
    assert np.all(shares >= -1e-12)  # between them
    assert np.all(shares[0] / left + shares[1] * slower / right <= 1.0 + 1e-9)  # nearer than the borders' line


def test_going_straight_on_at_the_same_speed_is_a_straight_line(rng: np.random.Generator) -> None:
    start, way = rng.normal(size=(2, 3))
    before, after = joint_line(start, start + way), joint_line(start + way, start + 2.0 * way)
    piece = round_corner(before, after, 0.3, 0.3).piece
    x = np.linspace(0.0, piece.end, 50)
    assert np.allclose(piece.evaluate(x), start + (0.7 + x)[:, None] * way, rtol=0.0, atol=1e-12)


def test_two_corners_may_meet_in_the_middle_of_a_move(rng: np.random.Generator) -> None:
    points = rng.normal(size=(4, 3))
    paths = [joint_line(points[i], points[i + 1]) for i in range(3)]
    corners = [round_corner(paths[i], paths[i + 1], 0.5, 0.5) for i in range(2)]
    whole = rounded(paths, corners)
    assert whole.moves[1][0] == whole.moves[1][1] == whole.corners[0][1] == whole.corners[1][0]
    middle = whole.path.evaluate(whole.moves[1][0])
    assert np.allclose(middle, 0.5 * (points[1] + points[2]), rtol=0.0, atol=1e-12)


def test_limits_may_be_as_large_as_numbers_go(rng: np.random.Generator) -> None:
    """An acceleration that some model names so that nothing ever keeps to it: speed and jerk count then."""
    start, corner, goal = rng.normal(size=(3, 3))
    before, after = joint_line(start, corner), joint_line(corner, goal)
    whole = rounded([before, after], [round_corner(before, after, 0.2, 0.2)])
    laws = []
    for acceleration in (1e3, 1e300):
        limits = JointLimits(("a", "b", "c"), *(np.full(3, end) for end in (-9.0, 9.0, 1.0, acceleration, 50.0)))
        laws.append(law_through(whole, joint_rates(whole.path, limits, [])))
    assert 0.0 < laws[1].end <= 1.2 * laws[0].end  # a little less jerk is used where sums are rounded
