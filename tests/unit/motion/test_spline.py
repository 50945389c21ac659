"""Splines alone, without an arm: poses that are passed, smoothness, how near a true curve they are, what makes none."""

from __future__ import annotations

import re
from itertools import pairwise
from math import pi, tau

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.line import line_between
from virtualrobot_kernel.motion.spline import MOST_GOALS, Spline, left_jacobians, spline
from virtualrobot_sdk.poses import left_jacobian

X, Y, Z = np.eye(3)


def posed(position: np.ndarray, turn: np.ndarray | None = None) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = position
    if turn is not None:
        pose[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    return pose


def random_poses(rng: np.random.Generator, count: int) -> list[np.ndarray]:
    """Return poses at distances of all sizes, each turned by up to about a quarter from the one before."""
    poses = [posed(rng.uniform(-1.0, 1.0, 3), rng.normal(size=3))]
    for _ in range(count - 1):
        step = posed(rng.normal(size=3) * 10.0 ** rng.uniform(-2.5, -0.5), rng.normal(size=3) * 0.6)
        pose = poses[-1].copy()
        pose[:3, 3] += step[:3, 3]
        pose[:3, :3] = step[:3, :3] @ pose[:3, :3]
        poses.append(pose)
    return poses


def away(one: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """Return distance and angle between two poses, the angle by scipy."""
    turn = Rotation.from_matrix(one[:3, :3].T @ other[:3, :3]).magnitude()
    return float(np.linalg.norm(one[:3, 3] - other[:3, 3])), float(turn)


def poses_of(tcp_path: Spline, count: int = 2001) -> np.ndarray:
    return np.array([tcp_path.pose(u) for u in np.linspace(0.0, 1.0, count)])


def test_a_spline_passes_each_pose_exactly_and_in_order(rng: np.random.Generator) -> None:
    for count in (2, 3, 4, 9):
        poses = random_poses(rng, count)
        tcp_path = spline(poses[0], poses[1:])
        assert tcp_path.knots == tuple(u for u, _ in tcp_path.stations[:-1])
        assert tcp_path.stations[-1] == (1.0, f"goals[{count - 2}]")
        assert list(tcp_path.u) == sorted(tcp_path.u)
        for u, pose in zip(tcp_path.u, poses, strict=True):
            np.testing.assert_allclose(tcp_path.pose(u), pose, atol=1e-12)


def test_the_twist_is_the_derivative_of_the_pose(rng: np.random.Generator) -> None:
    """By central differences of positions, and of rotations as scipy has them: O(h²) apart."""
    poses = random_poses(rng, 6)
    tcp_path, h = spline(poses[0], poses[1:]), 1e-6
    for u in rng.uniform(0.01, 0.99, 40):
        before, after = tcp_path.pose(u - h), tcp_path.pose(u + h)
        turn = Rotation.from_matrix(after[:3, :3] @ before[:3, :3].T).as_rotvec()
        difference = np.concatenate([after[:3, 3] - before[:3, 3], turn]) / (2.0 * h)
        np.testing.assert_allclose(tcp_path.twist(u), difference, atol=1e-6 * np.abs(tcp_path.twist(u)).max() + 1e-6)


def test_velocity_and_acceleration_are_continuous_where_poses_are_passed(rng: np.random.Generator) -> None:
    """One-sided: differences of second order of the twist, left and right of each pose, agree as h² goes to 0."""
    poses = random_poses(rng, 7)
    tcp_path = spline(poses[0], poses[1:])
    for before, u, after in zip(tcp_path.u[:-2], tcp_path.u[1:-1], tcp_path.u[2:], strict=True):
        h = 1e-4 * min(u - before, after - u)
        at = tcp_path.twist(u)
        left, right = ([tcp_path.twist(u + sign * k * h) for k in (1, 2)] for sign in (-1.0, 1.0))
        np.testing.assert_allclose(tcp_path.twist(np.nextafter(u, 0.0)), at, rtol=1e-9, atol=1e-9)
        slope_left = (3.0 * at - 4.0 * left[0] + left[1]) / (2.0 * h)
        slope_right = (-3.0 * at + 4.0 * right[0] - right[1]) / (2.0 * h)
        scale = np.abs(np.stack([slope_left, slope_right])).max() + np.abs(at).max() / min(u - before, after - u)
        assert np.abs(slope_left - slope_right).max() < 1e-4 * scale


def test_the_same_curve_in_whatever_frame_it_is_given(rng: np.random.Generator) -> None:
    poses, frame, tool = random_poses(rng, 5), posed(rng.normal(size=3), rng.normal(size=3)), posed(np.zeros(3), X)
    tcp_path = spline(poses[0], poses[1:])
    moved = spline(frame @ poses[0], [frame @ pose for pose in poses[1:]])
    held = spline(poses[0] @ tool, [pose @ tool for pose in poses[1:]])
    for u in rng.uniform(0.0, 1.0, 30):
        np.testing.assert_allclose(moved.pose(u), frame @ tcp_path.pose(u), atol=1e-11)
        np.testing.assert_allclose(held.pose(u), tcp_path.pose(u) @ tool, atol=1e-11)


def test_one_goal_is_a_line(rng: np.random.Generator) -> None:
    start, goal = random_poses(rng, 2)
    tcp_path, line = spline(start, [goal]), line_between(start, goal)
    for u in np.linspace(0.0, 1.0, 11):
        np.testing.assert_allclose(tcp_path.pose(u), line.pose(u), atol=1e-12)
    assert tcp_path.length == pytest.approx(line.length, rel=1e-3)
    assert tcp_path.angle == pytest.approx(line.angle, rel=1e-3)


def circle(angles: np.ndarray, radius: float = 0.3) -> list[np.ndarray]:
    return [posed(radius * np.array([np.cos(a), np.sin(a), 0.0]), a * Z) for a in angles]


@pytest.mark.parametrize("uneven", [0.0, 0.3])
def test_the_error_on_a_circle_falls_with_the_fourth_power_of_the_number_of_poses(
    uneven: float, rng: np.random.Generator
) -> None:
    """Floater (2006), Chordal cubic spline interpolation is fourth-order accurate: a sixteenth for twice the poses."""
    errors = []
    for count in (24, 48, 96):
        angles = np.linspace(0.0, 1.75 * pi, count + 1)
        if uneven:
            # A smooth distortion, so that twice the poses lie twice as densely everywhere.
            angles = angles + uneven * np.sin(2.0 * angles)
        poses = circle(angles)
        tcp_path = spline(poses[0], poses[1:])
        seen = poses_of(tcp_path, 1501)
        off = np.abs(np.linalg.norm(seen[:, :3, 3], axis=1) - 0.3).max()
        around = np.arctan2(seen[:, 1, 3], seen[:, 0, 3])
        turned = [away(posed(np.zeros(3), a * Z), one)[1] for a, one in zip(around, seen, strict=True)]
        errors.append((off, max(turned)))
    for first, second in pairwise(errors):
        assert all(one / other > 0.7 * 16 for one, other in zip(first, second, strict=True)), errors
    assert errors[-1][0] < 1e-5


def test_a_straight_row_is_gone_straight_and_evenly_and_turns_about_one_axis_evenly(rng: np.random.Generator) -> None:
    way, axis = rng.normal(size=3), rng.normal(size=3)
    marks = np.concatenate([[0.0], np.cumsum(rng.uniform(0.01, 1.0, 6))])
    poses = [posed(mark * way, mark * axis * 0.3) for mark in marks]
    tcp_path = spline(poses[0], poses[1:])
    for u in np.linspace(0.0, 1.0, 50):
        np.testing.assert_allclose(tcp_path.pose(u)[:3, 3], u * marks[-1] * way, atol=1e-12)
        assert away(tcp_path.pose(u), posed(X, u * marks[-1] * axis * 0.3))[1] < 1e-9


def test_poses_of_one_orientation_in_a_row_keep_it_between_them() -> None:
    """A cubic spline would swing by about a tenth of the turn that follows."""
    turns = [0.0, 0.0, 0.0, 1.5, 1.5, 1.5]
    poses = [posed(0.1 * k * X, turn * Z) for k, turn in enumerate(turns)]
    tcp_path = spline(poses[0], poses[1:])
    angles = np.array([Rotation.from_matrix(pose[:3, :3]).as_rotvec()[2] for pose in poses_of(tcp_path)])
    marks = np.linspace(0.0, 1.0, 2001)
    np.testing.assert_allclose(angles[marks <= tcp_path.u[2]], 0.0, atol=1e-12)
    np.testing.assert_allclose(angles[marks >= tcp_path.u[3]], 1.5, atol=1e-12)
    assert np.all(np.diff(angles) >= -1e-12)


def test_a_turn_in_place_stays_in_place() -> None:
    poses = [posed(0.0 * X), posed(0.2 * X + 0.1 * Y), posed(0.2 * X + 0.1 * Y, 0.8 * Z), posed(0.4 * X, 0.8 * Z)]
    tcp_path = spline(poses[0], poses[1:])
    for u in np.linspace(tcp_path.u[1], tcp_path.u[2], 100):
        np.testing.assert_allclose(tcp_path.pose(u)[:3, 3], [0.2, 0.1, 0.0], atol=1e-12)


def test_a_far_pose_beside_near_ones_does_not_swing_the_curve_out() -> None:
    """A quarter of a circle in steps of 2 mm, after 0.5 m along its tangent; 5% of that way is little for a spline."""
    corner = [posed(0.02 * np.array([np.sin(a), 1.0 - np.cos(a), 0.0])) for a in np.linspace(0.0, pi / 2.0, 16)]
    poses = [posed(-0.5 * X), *corner]
    positions = poses_of(spline(poses[0], poses[1:]), 4001)[:, :3, 3]
    before = positions[positions[:, 0] < 0.0]
    assert np.abs(before[:, 1]).max() < 0.025
    assert np.all(np.diff(positions[:, 0]) > -1e-9)


def test_places_tell_the_goal_that_is_nearest() -> None:
    poses = circle(np.linspace(0.0, tau, 9))
    tcp_path = spline(poses[0], poses[1:])
    assert tcp_path.length == pytest.approx(0.3 * tau, rel=1e-2)
    assert tcp_path.angle == pytest.approx(tau, rel=1e-2)
    words, metadata = tcp_path.place(0.24)
    assert "at 24.0% of the spline" in words
    assert words.endswith("nearest to goals[1],")
    assert metadata["goal"] == 1
    assert float(str(metadata["millimeters"])) == pytest.approx(0.24e3 * 0.3 * tau, rel=1e-2)
    assert tcp_path.place(0.01)[0].endswith("nearest to the start,")


def test_what_makes_no_spline_is_refused_by_name(rng: np.random.Generator) -> None:
    poses = random_poses(rng, 5)
    with pytest.raises(KernelError, match=f"1 to {MOST_GOALS} goals, not 0"):
        spline(poses[0], [])
    with pytest.raises(KernelError, match="not 1001"):
        spline(poses[0], poses[1:] * 250 + [poses[0]])
    twice = poses[2].copy()
    twice[0, 3] += 9e-6
    with pytest.raises(KernelError, match=re.escape("goals[2] of a spline is the same pose as goals[1]: 0.009 mm")):
        spline(poses[0], [poses[1], poses[2], twice, poses[3]])
    with pytest.raises(KernelError, match=re.escape("goals[0] of a spline is the same pose as the start")):
        spline(poses[0], poses)
    for bad in (np.full((4, 4), np.nan), 2.0 * np.eye(4), np.eye(3)):
        with pytest.raises(KernelError, match=re.escape("goals[1] of a spline must be")):
            spline(poses[0], [poses[1], bad])


def test_left_jacobians_of_many_turns_are_those_of_one(rng: np.random.Generator) -> None:
    sizes = np.concatenate([[0.0, 1e-9, 9.99e-3, 1.01e-2, pi], rng.uniform(0.0, tau, 20)])
    directions = rng.normal(size=(len(sizes), 3))
    turns = sizes[:, None] * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    np.testing.assert_allclose(left_jacobians(turns), [left_jacobian(turn) for turn in turns], atol=1e-12)
