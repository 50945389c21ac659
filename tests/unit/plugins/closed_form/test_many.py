"""Postures of many poses at once are to the last bit those of one pose after the other."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_plugins.closed_form.component import ClosedFormKinematics
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import InverseOptions
from virtualrobot_sdk.testing.chains import ur5

from tests.tiers import Draws

from .arms import NAMED, closed_form, numeric

WITHOUT_SEED = InverseOptions(seed=None)


def compared(kinematics: ClosedFormKinematics, poses: np.ndarray) -> int:
    """Compare both answers, and return for how many of the poses (n, 4, 4) there is one."""
    found = kinematics.inverse_many(poses)
    alone = [kinematics.inverse(pose, WITHOUT_SEED).solutions for pose in poses]
    np.testing.assert_array_equal(found.target, np.repeat(np.arange(len(poses)), [len(one) for one in alone]))
    np.testing.assert_array_equal(found.solutions, np.concatenate(alone))
    return sum(len(one) > 0 for one in alone)


@pytest.mark.parametrize("name", [*NAMED, "kr3", "wx250", "vx300s"])
def test_they_are_those_of_each_pose(name: str, rng: np.random.Generator, draws: Draws) -> None:
    """Of poses within reach and beyond; of two of these arms axes are polished, and one has five joints."""
    count, search = draws(300), numeric(name)
    poses = np.array([search.forward(q)[-1] for q in rng.uniform(-np.pi, np.pi, (count, len(search.joint_names)))])
    poses[::3, :3, 3] += rng.uniform(-1.5, 1.5, (len(poses[::3]), 3))
    reached = compared(closed_form(name), poses)
    assert count // 4 < reached < count


def test_singular_poses_and_full_turns_come_as_they_do_alone(rng: np.random.Generator) -> None:
    """Of an arm that turns by 360 degrees to both sides, and of one by 180, among poses of which each third is bent."""
    for limit in (np.pi, 2.0 * np.pi):
        kinematics = ClosedFormKinematics(ur5(limit))
        bent = rng.uniform(-np.pi, np.pi, (60, 6))
        bent[::3, 4] = 0.0
        bent[1::6, 2] = 0.0
        poses = np.array([kinematics.forward(q)[-1] for q in bent])
        assert compared(kinematics, poses) == 60


def test_no_poses_have_no_postures_and_what_is_no_pose_is_refused() -> None:
    found = closed_form("ur5").inverse_many(np.empty((0, 4, 4)))
    assert found.target.shape == (0,) and found.solutions.shape == (0, 6)
    wrong = np.tile(np.eye(4), (3, 1, 1))
    wrong[1, 0, 0] = np.nan
    with pytest.raises(ArgumentError, match="finite"):
        closed_form("ur5").inverse_many(wrong)
