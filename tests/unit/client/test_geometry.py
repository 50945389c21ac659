"""Poses, quaternions and angles against scipy, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from scipy.spatial.transform import Rotation, Slerp
from virtualrobot.geometry import (
    checked_pose,
    pose_between,
    pose_from_quaternion,
    poses_from_rows,
    quaternion_of,
    roll_pitch_yaw_of,
    rotation_from_vector,
    rotation_vector_of,
    rows_from_poses,
    turn_between,
)


def test_pose_turns_about_fixed_x_then_y_then_z(rng: np.random.Generator) -> None:
    """URDF's convention; scipy's lower-case `xyz` is the same sequence about fixed axes."""
    for _ in range(100):
        position, angles = rng.uniform(-2, 2, 3), rng.uniform(-np.pi, np.pi, 3)
        matrix = virtualrobot.pose(*position, *angles)
        np.testing.assert_allclose(matrix[:3, :3], Rotation.from_euler("xyz", angles).as_matrix(), atol=1e-15)
        np.testing.assert_array_equal(matrix[:3, 3], position)
        np.testing.assert_array_equal(matrix[3], (0, 0, 0, 1))


def test_angles_come_back(rng: np.random.Generator) -> None:
    angles = [*rng.uniform(-np.pi, np.pi, (200, 3)), (0.3, np.pi / 2, 0.7), (-0.4, -np.pi / 2, 2.0), (np.pi, 0, np.pi)]
    for roll, pitch, yaw in angles:
        matrix = virtualrobot.pose(roll=roll, pitch=pitch, yaw=yaw)
        again = virtualrobot.pose(0, 0, 0, *roll_pitch_yaw_of(matrix))
        np.testing.assert_allclose(again, matrix, atol=1e-9)


@pytest.mark.parametrize("off", [1e-12, 1e-9, 1e-8, 1e-6, 1e-3])
def test_angles_come_back_near_a_quarter_turn_of_pitch(off: float, rng: np.random.Generator) -> None:
    """Of matrices that were computed: their small entries are off by as much as their large ones."""
    for turn in Rotation.random(100, rng=rng).as_matrix():
        roll, yaw = rng.uniform(-np.pi, np.pi, 2)
        matrix = np.eye(4)
        matrix[:3, :3] = turn @ (turn.T @ virtualrobot.pose(roll=roll, pitch=np.pi / 2 - off, yaw=yaw)[:3, :3])
        again = virtualrobot.pose(0, 0, 0, *roll_pitch_yaw_of(matrix))
        np.testing.assert_allclose(again, matrix, rtol=0.0, atol=2e-9 if off < 1e-8 else 1e-14)


def test_quaternions_agree_with_scipy(rng: np.random.Generator) -> None:
    halves = [Rotation.from_rotvec(np.pi * axis) for axis in (*np.eye(3), np.array([1, 1, 0]) / np.sqrt(2))]
    for rotation in [*Rotation.random(300, rng=rng), *halves, Rotation.identity()]:
        expected = rotation.as_quat()
        found = quaternion_of(rotation.as_matrix())
        assert found[3] >= 0
        assert abs(abs(found @ expected) - 1) < 1e-12
        matrix = pose_from_quaternion((1, 2, 3), 5.0 * expected)
        np.testing.assert_allclose(matrix[:3, :3], rotation.as_matrix(), atol=1e-12)


def test_rows_become_poses(rng: np.random.Generator) -> None:
    rows = np.hstack([rng.uniform(-1, 1, (50, 3)), Rotation.random(50, rng=rng).as_quat()])
    poses = poses_from_rows(rows)
    np.testing.assert_allclose(poses[:, :3, :3], Rotation.from_quat(rows[:, 3:]).as_matrix(), atol=1e-12)
    np.testing.assert_array_equal(poses[:, :3, 3], rows[:, :3])
    np.testing.assert_allclose(
        rows_from_poses(poses), rows * np.where(rows[:, [6]] < 0.0, [1, 1, 1, -1, -1, -1, -1], 1)
    )
    assert poses_from_rows(np.empty((0, 7))).shape == (0, 4, 4)
    assert rows_from_poses(np.empty((0, 4, 4))).shape == (0, 7)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-7, 1e-3, 1.0, 3.0, np.pi - 1e-7, np.pi - 1e-12, np.pi])
def test_rotation_vectors_are_scipys_and_come_back(angle: float, rng: np.random.Generator) -> None:
    for _ in range(10):
        axis = rng.normal(size=3)
        vector = angle * axis / np.linalg.norm(axis)
        matrix = rotation_from_vector(vector)
        np.testing.assert_allclose(matrix, Rotation.from_rotvec(vector).as_matrix(), rtol=0.0, atol=4e-15)
        again = rotation_vector_of(matrix)
        np.testing.assert_allclose(rotation_from_vector(again), matrix, rtol=0.0, atol=4e-15)
        assert np.linalg.norm(again) == pytest.approx(angle, abs=4e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, np.pi - 1e-6, np.pi])
def test_poses_are_turned_against_each_other_by_their_angle(angle: float, rng: np.random.Generator) -> None:
    """Near 0 and half a turn, too, where a sine or a cosine alone has half of the digits."""
    axis = rng.normal(size=3)
    turned = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
    start = Rotation.random(rng=rng).as_matrix()
    assert turn_between(start, start @ turned) == pytest.approx(angle, abs=4e-15)


def test_a_pose_between_is_on_the_line_and_turned_as_scipys_slerp(rng: np.random.Generator) -> None:
    for share in (0.0, 0.25, 1.0):
        first, last = np.eye(4), np.eye(4)
        turns = Rotation.random(2, rng=rng)
        first[:3, :3], last[:3, :3] = turns.as_matrix()
        first[:3, 3], last[:3, 3] = rng.uniform(-1.0, 1.0, (2, 3))
        found = pose_between(first, last, share)
        np.testing.assert_allclose(found[:3, :3], Slerp([0.0, 1.0], turns)(share).as_matrix(), atol=1e-12)
        np.testing.assert_allclose(found[:3, 3], (1.0 - share) * first[:3, 3] + share * last[:3, 3], atol=1e-15)


@pytest.mark.parametrize(
    "bad",
    [np.eye(3), np.zeros((4, 4)), np.full((4, 4), np.nan), np.diag([2.0, 1, 1, 1]), np.diag([-1.0, 1, 1, 1]),
     np.eye(4) + np.eye(4, k=-3)],
)  # fmt: skip
def test_what_is_no_pose_is_refused(bad: np.ndarray) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError):
        checked_pose(bad)


def test_a_number_of_a_pose_that_is_none_is_told_with_its_place() -> None:
    pose = np.eye(4)
    pose[1, 3] = np.nan
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"finite numbers, not nan at \[1, 3\]"):
        checked_pose(pose)


def test_what_gives_no_pose_is_refused() -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="finite"):
        virtualrobot.pose(np.inf)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="not zero"):
        pose_from_quaternion((0, 0, 0), (0, 0, 0, 0))
    with pytest.raises(virtualrobot.InvalidArgumentError, match="quaternion of 4"):
        pose_from_quaternion((0, 0, 0), (0, 0, 1))  # pyright: ignore[reportArgumentType] that is the test
