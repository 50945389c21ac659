"""The closed form of many poses: forward undoes inverse, and no posture is missed; by the chain in plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_sdk.compiled.closed import BRANCHES, inverse_many, spherical_wrist
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, SerialChain
from virtualrobot_sdk.reference import tip_pose
from virtualrobot_sdk.testing.chains import puma560, ur5


def solved(chain: SerialChain, poses: Floats) -> tuple[Floats, Floats]:
    q, wrist = np.empty((len(poses), BRANCHES, 6)), np.empty((len(poses), BRANCHES))
    inverse_many(spherical_wrist(chain), np.ascontiguousarray(poses), q, wrist)
    return q, wrist


def turned_away(angles: Floats) -> Floats:
    return np.abs(angles - 2.0 * np.pi * np.round(angles / (2.0 * np.pi)))


def test_all_postures_of_a_pose_lead_there_and_the_one_it_is_of_is_among_them(seed: int) -> None:
    chain = puma560()
    given = np.random.default_rng(seed).uniform(-np.pi, np.pi, (300, 6))
    poses = tip_pose(chain, given)
    q, wrist = solved(chain, poses)
    there = np.isfinite(q).all(axis=2)
    reached = tip_pose(chain, q[there])
    np.testing.assert_allclose(reached, np.repeat(poses, there.sum(axis=1), axis=0), atol=1e-9)
    assert (np.abs(q[there]) <= np.pi).all()
    clear = np.abs(np.sin(given[:, 4])) > 0.01
    off = np.where(there, turned_away(q - given[:, None]).max(axis=2), np.inf).min(axis=1)
    assert off[clear].max() < 1e-7
    # Of a Puma, axes 4 and 6 are parallel where joint 5 is at 0.
    np.testing.assert_allclose(np.abs(wrist[there]), np.abs(np.sin(q[there][:, 4])), atol=1e-12)


def test_a_pose_out_of_reach_has_no_posture() -> None:
    chain = puma560()
    far = np.eye(4)
    far[:3, 3] = 5.0, 0.0, 0.0
    q, _ = solved(chain, far[None])
    assert np.isnan(q).all()


@pytest.mark.parametrize(
    ("chain", "lacks"),
    [
        (ur5(3.0), "a spherical wrist; they pass by"),
        (puma560()._replace(multiplier=np.full(6, 2.0)), "a coordinate of its own"),
        (puma560()._replace(axis=np.roll(puma560().axis, 1, axis=1)), "must be at a right angle"),
    ],
)
def test_other_arms_are_told_what_they_lack(chain: SerialChain, lacks: str) -> None:
    with pytest.raises(ArgumentError, match=lacks):
        spherical_wrist(chain)
