"""Poses, quaternions and angles against scipy, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from scipy.spatial.transform import Rotation
from virtualrobot.geometry import checked_pose, pose_from_quaternion, poses_from_rows, quaternion_of, roll_pitch_yaw_of


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
    assert poses_from_rows(np.empty((0, 7))).shape == (0, 4, 4)


@pytest.mark.parametrize(
    "bad",
    [np.eye(3), np.zeros((4, 4)), np.full((4, 4), np.nan), np.diag([2.0, 1, 1, 1]), np.diag([-1.0, 1, 1, 1]),
     np.eye(4) + np.eye(4, k=-3)],
)  # fmt: skip
def test_what_is_no_pose_is_refused(bad: np.ndarray) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError):
        checked_pose(bad)


def test_what_gives_no_pose_is_refused() -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="finite"):
        virtualrobot.pose(np.inf)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="not zero"):
        pose_from_quaternion((0, 0, 0), (0, 0, 0, 0))
    with pytest.raises(virtualrobot.InvalidArgumentError, match="quaternion of 4"):
        pose_from_quaternion((0, 0, 0), (0, 0, 1))  # pyright: ignore[reportArgumentType] that is the test
