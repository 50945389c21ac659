"""Postures of arms whose axes meet at both ends: forward undoes inverse, and no posture is missed."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.planning.extract import lock_coordinates
from virtualrobot_sdk.denavit_hartenberg import Row, Table
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import SerialChain
from virtualrobot_sdk.meeting_axes import MeetingAxes
from virtualrobot_sdk.reference import tip_pose
from virtualrobot_sdk.testing.chains import chain_of, iiwa, puma560, ur5

QUARTER = np.pi / 2.0


def panda() -> SerialChain:
    """Return a Franka Emika Panda by its table (Franka Control Interface, Denavit-Hartenberg parameters, Craig's)."""
    rows = (
        Row(d_meters=0.333),
        Row(alpha_radians=-QUARTER),
        Row(alpha_radians=QUARTER, d_meters=0.316),
        Row(a_meters=0.0825, alpha_radians=QUARTER),
        Row(a_meters=-0.0825, alpha_radians=-QUARTER, d_meters=0.384),
        Row(alpha_radians=QUARTER),
        Row(a_meters=0.088, alpha_radians=QUARTER),
    )
    return chain_of(Table("modified", rows), [(-3.0, 3.0)] * 7)


def held(chain: SerialChain, joint: int, value: float) -> SerialChain:
    """Return an arm without a joint, counted from 1, that is held at a value."""
    return lock_coordinates(chain, {joint - 1: value})[0]


ARMS = {
    "iiwa, joint 3": lambda: held(iiwa(), 3, 0.7),
    "iiwa, joint 3 straight": lambda: held(iiwa(), 3, 0.0),
    "iiwa, joint 1": lambda: held(iiwa(), 1, -0.4),
    "panda, joint 7": lambda: held(panda(), 7, 0.9),
    "panda, joint 7 back": lambda: held(panda(), 7, -2.0),
}


@pytest.mark.parametrize("name", ARMS)
def test_all_postures_of_a_pose_lead_there_and_the_one_it_is_of_is_among_them(seed: int, name: str) -> None:
    chain = ARMS[name]()
    given = np.random.default_rng(seed).uniform(-np.pi, np.pi, (300, 6))
    poses = tip_pose(chain, given)
    q, clear = MeetingAxes(chain).postures(poses)
    there = np.isfinite(q).all(axis=2)
    np.testing.assert_allclose(tip_pose(chain, q[there]), np.repeat(poses, there.sum(axis=1), axis=0), atol=1e-6)
    assert (np.abs(q[there]) <= np.pi).all()
    jacobians = np.array([_determinant(chain, one) for one in given])
    off = np.abs(q - given[:, None])
    off = np.where(there, np.abs(off - 2.0 * np.pi * np.round(off / (2.0 * np.pi))).max(axis=2), np.inf).min(axis=1)
    regular = np.abs(jacobians) > 1e-3 * np.abs(jacobians).max()
    assert regular.sum() > 250 and off[regular].max() < 1e-5
    assert (np.abs(clear[there]) <= 1.0 + 1e-9).all() and clear[there].any()


def _determinant(chain: SerialChain, q: np.ndarray) -> float:
    """Return the determinant of the Jacobian by differences of the forward pass."""
    pose, columns = tip_pose(chain, q), []
    for joint in range(6):
        moved = tip_pose(chain, q + 1e-6 * (np.arange(6) == joint))
        turn = (moved[:3, :3] @ pose[:3, :3].T - np.eye(3)) / 1e-6
        columns.append([*((moved[:3, 3] - pose[:3, 3]) / 1e-6), turn[2, 1], turn[0, 2], turn[1, 0]])
    return float(np.linalg.det(np.array(columns)))


def test_a_pose_out_of_reach_has_no_posture() -> None:
    far = np.eye(4)
    far[:3, 3] = 5.0, 0.0, 0.0
    for make in ARMS.values():
        q, clear = MeetingAxes(make()).postures(far[None])
        assert np.isnan(q).all() and not clear.any()


def test_other_arms_are_told_what_they_lack() -> None:
    with pytest.raises(ArgumentError, match="must meet in a point"):
        MeetingAxes(ur5(3.0))
    with pytest.raises(ArgumentError, match="six joints that turn"):
        MeetingAxes(iiwa())
    with pytest.raises(ArgumentError, match="a coordinate of its own"):
        MeetingAxes(puma560()._replace(multiplier=np.full(6, 2.0)))
