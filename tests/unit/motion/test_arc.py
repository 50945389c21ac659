"""Arcs alone, without an arm: the circle, its ends, how the tool turns, its limits, and what makes no arc."""

from __future__ import annotations

import re
from math import pi, tau

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.arc import Arc
from virtualrobot_kernel.motion.circle import Center, Via, arc
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.profile import jerk_limited_profile

FRACTIONS = np.linspace(0.0, 1.0, 41)
X, Y, Z = np.eye(3)


def posed(position: np.ndarray, rotation: np.ndarray | None = None) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = position
    if rotation is not None:
        pose[:3, :3] = rotation
    return pose


def random_pose(rng: np.random.Generator) -> np.ndarray:
    return posed(rng.uniform(-1.0, 1.0, 3), Rotation.from_rotvec(rng.normal(size=3)).as_matrix())


def circle_through(points: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Return centre, radius and unit normal: the point of the plane that is equally far from three points (3, 3)."""
    a, b, c = points
    normal = np.cross(b - a, c - a)
    system = np.array([b - a, c - a, normal])
    right = np.array([b @ b - a @ a, c @ c - a @ a, 2.0 * normal @ a]) / 2.0
    center = np.linalg.solve(system, right)
    return center, float(np.linalg.norm(a - center)), normal / np.linalg.norm(normal)


def positions(tcp_path: Arc) -> np.ndarray:
    return np.array([tcp_path.pose(u)[:3, 3] for u in FRACTIONS])


def test_an_arc_through_a_point_is_on_the_circle_of_the_three_and_passes_them_in_order(
    rng: np.random.Generator,
) -> None:
    """The circle by a linear system, slerp by scipy."""
    for _ in range(50):
        start, goal, via = random_pose(rng), random_pose(rng), rng.uniform(-1.0, 1.0, 3)
        tcp_path = arc(start, Via(via), goal)
        center, radius, normal = circle_through(np.array([start[:3, 3], via, goal[:3, 3]]))
        away = positions(tcp_path) - center
        np.testing.assert_allclose(np.linalg.norm(away, axis=1), radius, atol=1e-11, rtol=1e-10)
        np.testing.assert_allclose(away @ normal, 0.0, atol=1e-10)
        assert tcp_path.via is not None
        assert 0.0 < tcp_path.via < 1.0
        np.testing.assert_allclose(tcp_path.pose(tcp_path.via)[:3, 3], via, atol=1e-9)
        np.testing.assert_allclose(tcp_path.pose(1.0), goal, atol=1e-9)
        np.testing.assert_array_equal(tcp_path.pose(0.0), start)
        slerp = Slerp([0.0, 1.0], Rotation.from_matrix([start[:3, :3], goal[:3, :3]]))
        turned = Rotation.from_matrix([tcp_path.pose(u)[:3, :3] for u in FRACTIONS])
        assert (slerp(FRACTIONS).inv() * turned).magnitude().max() < 1e-7


def test_the_twist_is_the_derivative_of_the_pose(rng: np.random.Generator) -> None:
    for with_arc in (False, True):
        tcp_path = arc(random_pose(rng), Via(rng.uniform(-1.0, 1.0, 3)), random_pose(rng), with_arc)
        for u in FRACTIONS:
            before, after = tcp_path.pose(u - 1e-6), tcp_path.pose(u + 1e-6)
            turn = Rotation.from_matrix(after[:3, :3] @ before[:3, :3].T).as_rotvec()
            difference = np.concatenate([after[:3, 3] - before[:3, 3], turn]) / 2e-6
            np.testing.assert_allclose(tcp_path.twist(u), difference, atol=1e-8 * (1.0 + tcp_path.length**2))
            assert np.linalg.norm(tcp_path.twist(u)[:3]) == pytest.approx(tcp_path.length)


def test_an_arc_by_an_angle_ends_where_a_turning_disc_would(rng: np.random.Generator) -> None:
    """The disc's turn about an axis is scipy's."""
    angles = rng.uniform(0.01, 20.0 * pi, 20) * rng.choice([-1.0, 1.0], 20)  # nearer to 0 it may have no length
    for angle in (*angles, tau, -tau, pi, 20.0 * pi):
        start, axis, radial = random_pose(rng), rng.normal(size=3), rng.normal(size=3)
        center = start[:3, 3] + np.cross(axis, radial)
        tcp_path = arc(start, Center(center, axis, float(angle)), None)
        fixed = arc(start, Center(center, axis, float(angle)), None, with_arc=True)
        unit = axis / np.linalg.norm(axis)
        for u in FRACTIONS:
            turn = Rotation.from_rotvec(u * angle * unit).as_matrix()
            np.testing.assert_allclose(
                tcp_path.pose(u)[:3, 3], center + turn @ (start[:3, 3] - center), atol=1e-11, err_msg=f"{angle}"
            )
            np.testing.assert_array_equal(tcp_path.pose(u)[:3, :3], start[:3, :3])
            np.testing.assert_allclose(fixed.pose(u)[:3, :3], turn @ start[:3, :3], atol=1e-11)
        assert tcp_path.length == pytest.approx(abs(angle) * np.linalg.norm(center - start[:3, 3]))
        np.testing.assert_allclose(tcp_path.center, center, atol=1e-12)


def test_without_an_axis_it_goes_the_shorter_way_and_with_one_by_the_right_hand() -> None:
    start, goal = posed(X), posed(np.array([np.cos(2.0), np.sin(2.0), 0.0]))
    for axis, sweep in ((None, 2.0), (Z, 2.0), (5.0 * Z, 2.0), (-Z, tau - 2.0)):
        tcp_path = arc(start, Center(np.zeros(3), axis), goal)
        assert tcp_path.sweep == pytest.approx(sweep, rel=1e-12)
        np.testing.assert_allclose(tcp_path.pose(1.0), goal, atol=1e-12)
        assert tcp_path.pose(1e-3)[1, 3] > 0.0 if sweep == 2.0 else tcp_path.pose(1e-3)[1, 3] < 0.0


def test_an_angle_to_a_goal_says_after_how_many_turns() -> None:
    start, goal = posed(X), posed(Y, Rotation.from_rotvec([0.0, 0.3, 0.0]).as_matrix())
    for angle in (pi / 2, pi / 2 + tau, pi / 2 + 4 * tau, pi / 2 - tau, pi / 2 + 5e-5):
        tcp_path = arc(start, Center(np.zeros(3), Z, angle), goal)
        assert tcp_path.sweep == pytest.approx(abs(angle), abs=1e-4)
        np.testing.assert_allclose(tcp_path.pose(1.0), goal, atol=1e-12)
    whole = arc(start, Center(np.zeros(3), Z, -tau), start)
    assert whole.sweep == pytest.approx(tau)
    assert whole.pose(0.25)[1, 3] == pytest.approx(-1.0)


def test_a_center_that_is_a_little_off_gives_way_and_the_ends_do_not(rng: np.random.Generator) -> None:
    for _ in range(20):
        start, goal = posed(X), posed(np.array([np.cos(2.0), np.sin(2.0), 0.0]))
        off = rng.uniform(-4e-5, 4e-5, 3)
        for axis in (None, Z, np.array([1e-5, -1e-5, 1.0])):
            tcp_path = arc(start, Center(off, axis), goal)
            np.testing.assert_allclose(tcp_path.pose(1.0), goal, atol=1e-12)
            assert np.abs(positions(tcp_path) @ Z).max() < 1e-4
            assert np.abs(np.linalg.norm(positions(tcp_path), axis=1) - 1.0).max() < 2e-4


@pytest.mark.parametrize("bow", [2e-5, 1e-3, 0.3])
def test_a_flat_arc_is_as_exact_as_a_round_one(bow: float, rng: np.random.Generator) -> None:
    # 0.02 mm over 1 m is a circle of 6 km.
    turn, offset = Rotation.from_rotvec(rng.normal(size=3)).as_matrix(), rng.uniform(-1.0, 1.0, 3)
    start, via, goal = (turn @ point + offset for point in (0.0 * X, 0.5 * X + bow * Y, X))
    tcp_path = arc(posed(start), Via(via), posed(goal))
    assert tcp_path.radius == pytest.approx((0.25 + bow**2) / (2.0 * bow), rel=1e-6)
    np.testing.assert_allclose(tcp_path.pose(1.0)[:3, 3], goal, atol=1e-10)
    np.testing.assert_allclose(tcp_path.pose(0.5)[:3, 3], via, atol=1e-10)


def test_limits_along_the_arc_keep_those_in_space_and_are_the_line_s_on_large_circles(
    rng: np.random.Generator,
) -> None:
    # The derivatives of r (cos s/r, sin s/r): along it s'' and s''' - s'^3/r², across it s'²/r and 3 s' s''/r.
    for _ in range(40):
        velocity, acceleration = 10.0 ** rng.uniform(-2.0, 1.0), 10.0 ** rng.uniform(-1.0, 1.0)
        limits = CartesianLimits(velocity, acceleration, acceleration * 10.0 ** rng.uniform(0.0, 2.0))
        radius, speed = 10.0 ** rng.uniform(-3.0, 1.0), float(rng.uniform(0.01, 1.0))
        tcp_path = arc(posed(radius * X), Center(np.zeros(3), Z, float(rng.uniform(0.1, tau))), None)
        greatest, along, jerk = tcp_path.tangential(limits, speed)
        law = jerk_limited_profile(tcp_path.length, greatest * speed, along, jerk)
        _, v, a, j = law.states(np.linspace(0.0, law.end, 4001), 3)[:, :, 0]
        assert np.hypot(a, v**2 / radius).max() <= limits.acceleration * (1.0 + 1e-9)
        assert np.hypot(j - v**3 / radius**2, 3.0 * v * a / radius).max() <= limits.jerk * (1.0 + 1e-9)
        assert 0.0 < greatest <= limits.velocity
        assert min(along / limits.acceleration, jerk / limits.jerk) > 0.0
    flat = arc(posed(1e4 * X), Center(np.zeros(3), Z, 1e-4), None)
    line = CartesianLimits(0.25, 1.0, 10.0)
    np.testing.assert_allclose(flat.tangential(line, 1.0), (0.25, 1.0, 10.0), rtol=1e-6)


START, GOAL = posed(X), posed(Y)
ABOUT = np.zeros(3)
REFUSED = {
    "in a line": (Via(0.5 * X + 0.5 * Y + 5e-6 * Z), GOAL, r"are in a line: only 0\.005 mm off it; .* 0\.01 mm"),
    "beyond the goal in a line": (Via(2.0 * Y - X), GOAL, "are in a line"),
    "via is the start": (Via(X + 1e-6 * Y), GOAL, r"the via point is the start: .* are 0\.001 mm apart"),
    "via is the goal": (Via(Y), GOAL, "the via point is the goal"),
    "start is the goal": (Via(-X), START, "the same point; for a whole turn give a centre, an axis and an angle"),
    "no goal": (Via(Z), None, "through a via point needs a goal"),
    "NaN via": (Via(np.array([np.nan, 0.0, 0.0])), GOAL, "via point of a CIRC motion must be three finite numbers"),
    "NaN goal": (Via(Z), np.full((4, 4), np.nan), "goal of a CIRC motion must be a finite pose"),
    "no pose": (Via(Z), 2.0 * np.eye(4), "goal of a CIRC motion must be a rigid transform"),
    "centre is the start": (Center(X, Z, 1.0), None, "is its start"),
    "nothing to end at": (Center(ABOUT, Z), None, "needs a goal, or an axis and an angle"),
    "an angle about nothing": (Center(ABOUT, None, 1.0), GOAL, "needs the axis about which it turns"),
    "a whole turn without angle": (Center(ABOUT, Z), START, r"are the same point .* give an angle of 6\.283185"),
    "half a turn without axis": (Center(ABOUT), posed(-X), "are in a line: .* needs an axis"),
    "not as far": (
        Center(ABOUT),
        posed(1.1 * Y),
        r"is 1000\.0000 mm from the start .* but 1100\.0000 mm from the goal",
    ),
    "angle 0": (Center(ABOUT, Z, 0.0), None, "an arc of 0 rad has no length"),
    "angle almost 0": (Center(ABOUT, Z, -1e-9), None, "has no length"),
    "angle 0 to the start": (Center(ABOUT, Z, 0.0), START, "has no length"),
    "NaN angle": (Center(ABOUT, Z, np.nan), None, "must be finite and at most 62.8319 rad, ten turns, not nan"),
    "eleven turns": (Center(ABOUT, Z, 22.0 * pi), None, "at most 62.8319 rad"),
    "angle past the goal": (Center(ABOUT, Z, 1.6), GOAL, r"ends 29\.2 mm along the circle from the goal"),
    "axis of no length": (Center(ABOUT, 0.0 * Z, 1.0), None, "must have a length above 0"),
    "NaN axis": (Center(ABOUT, np.array([0.0, 0.0, np.inf]), 1.0), None, "axis of a CIRC motion must be three finite"),
    "axis not across": (Center(ABOUT, Z + 0.1 * X, 1.0), None, r"start .* is 99\.5 mm off the plane"),
    "goal off the plane": (Center(ABOUT, Z), posed(Y + 0.01 * Z), r"goal .* is 10 mm off the plane"),
    "NaN centre": (Center(np.array([0.0, np.nan, 0.0]), Z, 1.0), None, "centre of a CIRC motion must be three finite"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_makes_no_arc_is_refused_with_the_amount(what: str) -> None:
    shape, goal, words = REFUSED[what]
    with pytest.raises(KernelError, match=words) as refusal:
        arc(START, shape, goal)
    assert not re.search(r"nan mm|array\(", str(refusal.value))


def test_a_shape_is_seen_from_another_frame(rng: np.random.Generator) -> None:
    frame = random_pose(rng)
    start, goal, via = random_pose(rng), random_pose(rng), rng.uniform(-1.0, 1.0, 3)
    own = arc(start, Via(via), goal)
    while abs(own.sweep - pi) < 0.01:  # half a turn about a centre needs an axis
        goal = random_pose(rng)
        own = arc(start, Via(via), goal)
    for shape in (Via(via), Center(own.center), Center(own.center, np.cross(own.along, own.inward), own.sweep)):
        one, other = arc(start, shape, goal), arc(frame @ start, shape.seen_from(frame), frame @ goal)
        for u in FRACTIONS:
            np.testing.assert_allclose(other.pose(u), frame @ one.pose(u), atol=1e-8)
