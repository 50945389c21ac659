"""Gaits, steps, courses and support of walking machines: laws and closed forms, without a kernel."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from virtualrobot_apps.vehicles.walking.course import Part, course, placed
from virtualrobot_apps.vehicles.walking.feet import blend, lift, swing, swing_height
from virtualrobot_apps.vehicles.walking.footholds import Stand, slope
from virtualrobot_apps.vehicles.walking.gaits import (
    HEXAPOD_GAITS,
    QUADRUPED_GAITS,
    Gait,
    longitudinal_margin_of_wave,
    wave_gait,
)
from virtualrobot_apps.vehicles.walking.support import longitudinal_margin, stability_margin, support_polygon
from virtualrobot_apps.vehicles.walking.terrain import rolling, triangles_of
from virtualrobot_apps.vehicles.walking.walk import Walk, plan_walk

PITCH, WIDTH = 0.14, 0.3
SIX = np.array([(x, y) for x in (PITCH, 0.0, -PITCH) for y in (WIDTH / 2, -WIDTH / 2)])
FOUR = np.array([(x, y) for x in (PITCH / 2, -PITCH / 2) for y in (WIDTH / 2, -WIDTH / 2)])


def straight(gait: Gait, feet: np.ndarray, stroke: float, cycles: int = 3) -> Walk:
    return plan_walk(gait, Stand(feet, 0.1), [Part(cycles * gait.cycle, forward=gait.speed(stroke))])


@pytest.mark.parametrize("duty_factor", [1 / 2, 0.6, 2 / 3, 0.75, 5 / 6])
@pytest.mark.parametrize("pairs", [2, 3, 4])
def test_the_least_longitudinal_margin_is_that_of_the_closed_form(pairs: int, duty_factor: float) -> None:
    """Song and Waldron 1989; of four legs McGhee and Frank 1968. Over the cycles of even speed."""
    if duty_factor < 3.0 / (2 * pairs):
        with pytest.raises(ValueError, match="has a duty factor from"):
            wave_gait(pairs, duty_factor, 1.0)
        return
    gait = wave_gait(pairs, duty_factor, 1.0)
    x = PITCH * (np.arange(pairs)[::-1] - (pairs - 1) / 2.0)
    feet = np.array([(place, side) for place in x for side in (WIDTH / 2, -WIDTH / 2)])
    stroke = 0.6 * PITCH
    walk = straight(gait, feet, stroke)
    even = (walk.times > gait.cycle * 2.0) & (walk.times < 3.0 * gait.cycle)
    margins = [
        longitudinal_margin(body[:2, 3], 0.0, places[standing][:, :2])
        for body, places, standing in zip(walk.bodies[even], walk.feet[even], walk.stance[even], strict=True)
    ]
    told = longitudinal_margin_of_wave(pairs, duty_factor, PITCH, stroke)
    # Between two instants of the walk the body goes on by this much.
    step = 0.008 * gait.speed(stroke)
    assert told - 1e-9 <= min(margins) <= told + step


def test_feet_step_as_the_gait_says() -> None:
    for gaits in (HEXAPOD_GAITS, QUADRUPED_GAITS):
        for gait in gaits.values():
            times = np.linspace(5.0 * gait.cycle, 6.0 * gait.cycle, 2001)[:-1]
            air = np.zeros((len(gait.phases), len(times)), bool)
            for leg in range(len(gait.phases)):
                for begin, end in gait.swings(leg, 10.0 * gait.cycle):
                    air[leg] |= (times > begin) & (times < end)
                    assert begin >= -1e-9 and end - begin == pytest.approx(gait.swing_time)
                    after = end / gait.cycle - gait.phases[leg]
                    assert after == pytest.approx(round(after), abs=1e-9)
            assert air.mean(axis=1) == pytest.approx(1.0 - gait.duty_factor, abs=2e-3)
    assert HEXAPOD_GAITS["tripod"].phases == (0.0, 0.5, 0.5, 0.0, 0.0, 0.5)
    # A crawl: left front, right rear, right front, left rear (McGhee and Frank 1968).
    assert np.argsort(QUADRUPED_GAITS["crawl"].phases).tolist() == [0, 3, 1, 2]


def test_speed_is_stroke_by_duty_factor_and_cycle() -> None:
    gait = HEXAPOD_GAITS["ripple"]
    walk = straight(gait, SIX, 0.05)
    even = (walk.times >= gait.cycle) & (walk.times <= 3.0 * gait.cycle)
    x, times = walk.bodies[even, 0, 3], walk.times[even]
    assert np.diff(x) / np.diff(times) == pytest.approx(0.05 / (2 / 3 * gait.cycle), rel=1e-9)
    assert gait.stroke(gait.speed(0.05)) == pytest.approx(0.05)
    off = walk.body_t_feet[:, 0, 0] - SIX[0, 0]
    standing = even & walk.stance[:, 0] & (walk.times > 1.5 * gait.cycle)
    assert np.ptp(off[standing]) == pytest.approx(0.05, abs=0.008 * gait.speed(0.05) + 1e-9)
    assert walk.bodies[-1, 0, 3] == pytest.approx(3.0 * gait.cycle * gait.speed(0.05))


@pytest.mark.parametrize("gait", [*HEXAPOD_GAITS.values()], ids=lambda gait: gait.name)
def test_a_walk_begins_and_ends_at_rest_on_all_feet_and_no_foot_slips(gait: Gait, rng: np.random.Generator) -> None:
    parts = [Part(2.0 * gait.cycle, 0.05, 0.0, 0.2), Part(gait.cycle, 0.0, -0.05), Part(1.3 * gait.cycle, turn=-0.4)]
    start = (0.3, -0.2, float(rng.uniform(-3.0, 3.0)))
    walk = plan_walk(gait, Stand(SIX, 0.09, 0.008), parts, start=start)
    assert walk.stance[0].all() and walk.stance[-1].all()
    for row in (0, -1):
        np.testing.assert_allclose(walk.body_t_feet[row, :, :2], SIX, atol=1e-9)
        np.testing.assert_allclose(walk.body_t_feet[row, :, 2], 0.008 - 0.09, atol=1e-12)
    assert walk.bodies[0, :2, 3] == pytest.approx(start[:2])
    assert np.arctan2(walk.bodies[0, 1, 0], walk.bodies[0, 0, 0]) == pytest.approx(start[2])
    both = walk.stance[1:] & walk.stance[:-1]
    assert np.abs(np.diff(walk.feet, axis=0)[both]).max() < 1e-12
    speeds = np.diff(walk.feet, axis=0) / np.diff(walk.times)[:, None, None]
    assert np.abs(speeds[[0, -1]]).max() < 0.01 * np.abs(speeds).max()
    for number, time in enumerate(walk.times.tolist()):
        assert (walk.stance_at(time) == walk.stance[number]).all()
    for body, feet, standing in zip(walk.bodies, walk.feet, walk.stance, strict=True):
        assert stability_margin(body[:2, 3], feet[standing][:, :2]) > 0.0


def test_a_course_is_an_exact_arc_while_it_is_even() -> None:
    times = np.arange(0.0, 8.001, 0.008)
    poses = course(times, [Part(6.0, 0.2, 0.05, 0.5)], 1.0, (1.0, 2.0, 0.3))
    first, last = poses[125], poses[750]  # at 1 s and 6 s
    turned = 0.5 * (times[750] - times[125])
    assert last[2] - first[2] == pytest.approx(turned, abs=1e-12)
    way = np.array([[np.sin(turned), np.cos(turned) - 1.0], [1.0 - np.cos(turned), np.sin(turned)]]) @ [0.2, 0.05] / 0.5
    assert placed(first, way) == pytest.approx(last[:2], abs=1e-10)
    assert poses[-1] == pytest.approx(poses[-50])


def test_the_support_polygon_is_the_convex_hull(rng: np.random.Generator) -> None:
    """Against Qhull; the margin against the distance from each edge, and by moving the point there."""
    for _ in range(20):
        feet = rng.uniform(-1.0, 1.0, (int(rng.integers(3, 9)), 2))
        hull = ConvexHull(feet)
        corners = support_polygon(feet)
        assert {tuple(corner) for corner in corners.tolist()} == {tuple(feet[i]) for i in hull.vertices}
        point = rng.uniform(-1.0, 1.0, 2)
        outward = hull.equations @ [*point, 1.0]
        margin = stability_margin(point, feet)
        if outward.max() < 0.0:
            assert margin == pytest.approx(-outward.max())
        else:
            assert -margin >= outward.max() - 1e-12  # beyond a corner it is farther than from the edge's line
    assert stability_margin(np.zeros(2), np.array([(1.0, 1.0), (1.0, -1.0)])) == pytest.approx(-1.0)
    assert stability_margin(np.zeros(2), np.array([(3.0, 4.0)])) == pytest.approx(-5.0)
    assert stability_margin(np.zeros(2), np.empty((0, 2))) == -np.inf
    square = np.array([(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, 0.0)])
    assert stability_margin(np.array([0.5, 0.0]), square) == pytest.approx(0.5)
    assert longitudinal_margin(np.zeros(2), math.pi / 4, square) == pytest.approx(math.sqrt(2.0))
    assert longitudinal_margin(np.array([0.0, 2.0]), 0.0, square) == -np.inf


def test_a_swing_is_smooth_and_clears_what_lies_between() -> None:
    u = np.linspace(0.0, 1.0, 1001)
    for curve in (blend, lift):
        speed, acceleration = np.gradient(curve(u), u), np.gradient(np.gradient(curve(u), u), u)
        assert np.abs(speed[[0, -1]]).max() < 1e-3 and np.abs(acceleration[[0, -1]]).max() < 0.2
    assert lift(np.array([0.5])) == pytest.approx(1.0)
    ground = np.array([0.0, 0.0, 0.0, 0.0, 0.07, 0.0, 0.0, 0.0, 0.02])
    height = swing_height(0.0, 0.02, 0.03, ground)
    way = swing(u, np.zeros(3), np.array([0.08, 0.0, 0.02]), height)
    assert np.interp(0.04, way[:, 0], way[:, 2]) >= 0.07 + 0.03 - 1e-6
    assert swing_height(0.0, 0.02, 0.03, np.linspace(0.0, 0.02, 9)) == pytest.approx(0.04)


def test_the_body_lies_as_the_slope_does() -> None:
    gait = HEXAPOD_GAITS["tripod"]
    walk = plan_walk(gait, Stand(SIX, 0.1), [Part(2.0 * gait.cycle, 0.05)], slope(0.2), (0.0, 0.0, 0.7))
    normal = np.tile([-np.sin(0.2), 0.0, np.cos(0.2)], (len(walk.times), 1))
    np.testing.assert_allclose(walk.bodies[:, :3, 2], normal, atol=1e-9)
    np.testing.assert_allclose(walk.bodies[:, 2, 3], np.tan(0.2) * walk.bodies[:, 0, 3] + 0.1, atol=1e-9)


def test_rolling_ground_is_the_same_for_the_same_seed(seed: int) -> None:
    heights = rolling(np.random.default_rng(seed))
    assert (heights == rolling(np.random.default_rng(seed))).all()
    assert (heights != rolling(np.random.default_rng(seed + 1))).any()
    assert heights.min() >= 0.0 and 0.015 < heights.max() <= 0.03
    assert heights[39:42, 39:42].max() == 0.0
    corners, triangles = triangles_of(heights, 0.05)
    a, b, c = (corners[triangles[:, place]] for place in range(3))
    normals = np.cross(b - a, c - a)
    assert (normals[:, 2] > 0.0).all()
    assert normals[:, 2].sum() / 2.0 == pytest.approx((80 * 0.05) ** 2)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Gait("none", 1.0, (0.0,), 1.0), "a duty factor is above 0 and below 1, not 1"),
        (lambda: Gait("none", 0.5, (1.0,), 1.0), "phases are from 0 to below 1"),
        (lambda: Gait("none", 0.5, (0.0,), 0.0), "a cycle is longer than 0 s, not 0"),
        (lambda: wave_gait(1, 0.8, 1.0), "two pairs of legs or more, not 1"),
        (lambda: Part(0.0, 0.1), "lasts longer than 0 s, not 0"),
        (lambda: Part(1.0, math.nan), "speeds are finite, not nan"),
        (
            lambda: plan_walk(HEXAPOD_GAITS["wave"], Stand(FOUR, 0.1), [Part(1.0)]),
            "is of 6 legs, and the machine has 4",
        ),
        (lambda: plan_walk(HEXAPOD_GAITS["wave"], Stand(SIX, 0.1), []), "a course has a part at least"),
    ],
)
def test_what_makes_no_walk_is_refused(make: object, said: str) -> None:
    assert callable(make)
    with pytest.raises(ValueError, match=said):
        make()
