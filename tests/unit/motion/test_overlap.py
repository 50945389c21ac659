"""Motions that overlap, and laws through rounded corners: limits kept, nothing jumps, and sooner than with a stop."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from virtualrobot_kernel.motion.blend import Rounded, round_corner, rounded
from virtualrobot_kernel.motion.blend_law import law_through
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.overlap import overlap, overlapped
from virtualrobot_kernel.motion.path import joint_line
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.planned import Track, peaks
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.rates import joint_rates

from tests.unit.motion.motions import random_limits


def peak(track: Track, limits: JointLimits) -> float:
    """Return the largest share of a limit that joints take, at moments of our own."""
    values = np.abs(track.derivatives(np.linspace(0.0, track.time_law.end, 20_001))[1:]).max(axis=1)
    return float((values / [limits.velocity, limits.acceleration, limits.jerk]).max())


def points(rng: np.random.Generator, limits: JointLimits, count: int) -> np.ndarray:
    """Return random joints within limits."""
    return rng.uniform(0.7 * limits.lower, 0.7 * limits.upper, (count, len(limits.names)))


def test_an_overlap_keeps_the_limits_and_what_is_outside_it(rng: np.random.Generator) -> None:
    found = None
    while found is None:
        limits = random_limits(rng, 5)
        first, corner, last = points(rng, limits, 3)
        before, after = plan_ptp(first, corner, limits).tracks[0], plan_ptp(corner, last, limits).tracks[0]
        leave, join = rng.uniform(0.1, 0.4) * before.time_law.end, rng.uniform(0.1, 0.4) * after.time_law.end
        rows = np.stack([limits.velocity, limits.acceleration, limits.jerk])
        found = overlap(before, after, leave, join, rows, lambda quintic: True)
    assert found.leave <= leave and found.join <= join and found.saved > 0.0
    whole, ((begin, end),) = overlapped([before, after], [found])
    assert np.isclose(whole.time_law.end, before.time_law.end + after.time_law.end - found.saved, rtol=1e-12)
    assert peak(whole, limits) <= 1.005
    t = np.linspace(0.0, begin, 100)
    assert np.allclose(whole.derivatives(t)[:3], before.derivatives(t)[:3], rtol=0.0, atol=1e-7)
    t = np.linspace(end, whole.time_law.end, 100)
    assert np.allclose(whole.derivatives(t)[:3], after.derivatives(t - end + found.join)[:3], rtol=0.0, atol=1e-7)
    t = np.linspace(begin, end, 100)
    assert np.allclose(whole.derivatives(t)[0], found.quintic.evaluate(t - begin), rtol=0.0, atol=1e-6)
    for x in whole.path.breaks[1:-1]:
        left, right = whole.path.states(np.array([np.nextafter(x, -1.0), x]), 2).transpose(1, 0, 2)
        assert np.allclose(left, right, rtol=1e-6, atol=1e-6 * np.abs(left).max())


def test_the_overlap_has_the_jerk_of_its_quintic_whatever_the_parameters_are(rng: np.random.Generator) -> None:
    """One motion's parameter may grow many times as fast as the other's, as that of an arc beside one of joints."""
    scale, found = float(rng.choice([30.0, 1.0 / 30.0])), None
    while found is None:
        limits = random_limits(rng, 4)
        before, after = (plan_ptp(*ends, limits).tracks[0] for ends in pairwise(points(rng, limits, 3)))
        law = PiecewisePolynomial(after.time_law.breaks, scale * after.time_law.coefficients)
        after = Track(after.path.onto(scale * after.path.start, scale * after.path.end), law)
        rows = np.stack([limits.velocity, limits.acceleration, limits.jerk])
        found = overlap(before, after, 0.4 * before.time_law.end, 0.4 * law.end, rows, lambda quintic: True)
    track, ((begin, _),) = overlapped([before, after], [found])
    times = rng.uniform(0.0, found.quintic.end, 2000)
    meant = found.quintic.states(times, 3)[1:]
    off = np.abs(track.derivatives(begin + times)[1:] - meant).max(axis=(1, 2))
    assert np.all(off <= [1e-6, 1e-3, 1e-2] * np.abs(meant).max(axis=(1, 2)))


def test_what_does_not_fit_is_not_taken(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 3)
    first, corner, last = points(rng, limits, 3)
    before, after = plan_ptp(first, corner, limits).tracks[0], plan_ptp(corner, last, limits).tracks[0]
    rows = np.full((3, 3), np.inf)
    asked: list[float] = []

    def never(quintic: object) -> bool:
        asked.append(quintic.end)  # pyright: ignore[reportAttributeAccessIssue] it is a polynomial
        return False

    assert overlap(before, after, 0.1, 0.1, rows, never) is None
    assert 1 < len(asked) <= 20
    assert overlap(before, after, 0.1, 0.1, 1e-9 * np.ones((3, 3)), lambda quintic: True) is None


def test_without_a_corner_the_law_is_the_double_s(rng: np.random.Generator) -> None:
    """As ruckig computes it for PTP."""
    limits = random_limits(rng, 4)
    start, goal = points(rng, limits, 2)
    plan = plan_ptp(start, goal, limits)
    path = joint_line(start, goal).onto(0.0, float(rng.uniform(0.1, 10.0)))
    law = law_through(Rounded(path, ((0.0, path.end),), ()), joint_rates(path, limits, []))
    assert np.isclose(law.end, plan.duration, rtol=1e-3)
    assert law.coefficients.shape[1] == 4


def test_the_law_through_corners_keeps_the_limits_at_a_constant_rate_in_each(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 5)
    way = points(rng, limits, 6)
    paths = [joint_line(a, b) for a, b in pairwise(way)]
    shares = rng.uniform(0.05, 0.5, 4)
    corners = [round_corner(a, b, share, share) for a, b, share in zip(paths[:-1], paths[1:], shares, strict=True)]
    whole = rounded(paths, corners)
    law = law_through(whole, joint_rates(whole.path, limits, []))
    assert np.isclose(law.evaluate(law.end)[0], whole.path.end, rtol=1e-12)
    assert peak(Track(whole.path, law), limits) <= 1.0 + 1e-3
    taus = np.linspace(0.0, law.end, 20_001)
    s, speed, slope = law.states(taus, 2)[:, :, 0]
    assert np.all(speed[1:-1] > 0.0)
    for begin, end in whole.corners:
        inside = (s > begin + 1e-9) & (s < end - 1e-9)
        assert np.ptp(speed[inside]) < 1e-9 and np.abs(slope[inside]).max() < 1e-9
    for x in law.breaks[1:-1]:
        before, after = law.states(np.array([np.nextafter(x, -1.0), x]), 2)[:, :, 0].T
        assert np.allclose(before, after, rtol=1e-9, atol=1e-9)


def test_a_law_with_room_to_spare_uses_a_limit_up(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 5)
    way = points(rng, limits, 3)
    paths = [joint_line(a, b) for a, b in pairwise(way)]
    whole = rounded(paths, [round_corner(paths[0], paths[1], 0.3, 0.3)])
    law = law_through(whole, joint_rates(whole.path, limits, []))
    assert peak(Track(whole.path, law), limits) > 0.99


def test_peaks_are_those_of_the_motion_where_path_and_law_break_together() -> None:
    """A millisecond of one parameter is a second of another one, as in an overlap: all the way q = 0.2 t^3, jerk 1.2.

    Right before the break the place on the path rounds to the break: the law's piece before with the path's after.
    """
    for begin in (1000.0, 1e-3):
        for slower in (1e-3, 1e3):
            seconds = np.array([0.0, 1.0, 2.0])
            law = PiecewisePolynomial(seconds, np.array([[[begin], [1.0]], [[begin + 1.0], [slower]]]))
            one, other = [0.0, 0.0, 0.0, 0.2], [0.2, 0.6 / slower, 0.6 / slower**2, 0.2 / slower**3]
            places = np.array([begin, begin + 1.0, begin + 1.0 + slower])
            track = Track(PiecewisePolynomial(places, np.array([one, other])[:, :, None]), law)
            np.testing.assert_allclose(peaks(track)[:, 0], [2.4, 2.4, 1.2], rtol=1e-6)
