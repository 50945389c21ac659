"""Postures of arms with three parallel axes: forward undoes inverse, and no posture is missed."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import SerialChain
from virtualrobot_sdk.parallel_axes import ParallelAxes, has_parallel_axes
from virtualrobot_sdk.reference import tip_pose
from virtualrobot_sdk.testing.chains import puma560, ur5


def turned_over(chain: SerialChain) -> SerialChain:
    """Return an arm whose joint 3 turns the other way."""
    return chain._replace(axis=chain.axis * np.where(np.arange(6) == 2, -1.0, 1.0)[:, None])


@pytest.mark.parametrize("chain", [ur5(3.0), turned_over(ur5(3.0))], ids=["ur5", "elbow turned over"])
def test_all_postures_of_a_pose_lead_there_and_the_one_it_is_of_is_among_them(seed: int, chain: SerialChain) -> None:
    given = np.random.default_rng(seed).uniform(-np.pi, np.pi, (300, 6))
    poses = tip_pose(chain, given)
    q, clear = ParallelAxes(chain).postures(poses)
    there = np.isfinite(q).all(axis=2)
    np.testing.assert_allclose(tip_pose(chain, q[there]), np.repeat(poses, there.sum(axis=1), axis=0), atol=1e-7)
    assert (np.abs(q[there]) <= np.pi).all()
    regular = (np.abs(np.sin(given[:, 4])) > 0.01) & (np.abs(np.sin(given[:, 2])) > 0.01)
    off = np.abs(q - given[:, None])
    off = np.where(there, np.abs(off - 2.0 * np.pi * np.round(off / (2.0 * np.pi))).max(axis=2), np.inf).min(axis=1)
    assert off[regular].max() < 1e-5
    # Of a UR, axis 6 is parallel to axes 2, 3 and 4 where joint 5 is at 0.
    np.testing.assert_allclose(np.abs(clear[there]), np.abs(np.sin(q[there][:, 4])), atol=1e-9)


def test_a_pose_out_of_reach_has_no_posture() -> None:
    far = np.eye(4)
    far[:3, 3] = 5.0, 0.0, 0.0
    q, clear = ParallelAxes(ur5(3.0)).postures(far[None])
    assert np.isnan(q).all() and not clear.any()


def test_other_arms_are_told_what_they_lack() -> None:
    assert has_parallel_axes(ur5(3.0)) and not has_parallel_axes(puma560())
    with pytest.raises(ArgumentError, match="a coordinate of its own"):
        ParallelAxes(ur5(3.0)._replace(multiplier=np.full(6, 2.0)))
    apart = ur5(3.0)
    pre = apart.pre.copy()
    pre[5, :3, 3] += 0.01 * np.cross(pre[5, :3, :3] @ apart.axis[5], apart.axis[4])
    with pytest.raises(ArgumentError, match="must meet; they pass by 10 mm"):
        ParallelAxes(apart._replace(pre=pre))
