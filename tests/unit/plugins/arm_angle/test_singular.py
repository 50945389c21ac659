"""Singular poses of arms with an arm angle: right, and with the singularity's name."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_plugins.closed_form.singularities import SINGULAR_OF_SEVEN
from virtualrobot_sdk.kinematics import InverseOptions

from .arms import NAMES, STRAIGHT, arm, axes, chain_of_arm, meeting


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("joints", [(1,), (3,), (5,), (1, 3), (1, 5), (3, 5), (1, 3, 5)], ids=str)
@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-9, 1e-6, 1e-5], ids=str)
def test_a_singular_posture_is_found_again(
    name: str, joints: tuple[int, ...], off: float, rng: np.random.Generator
) -> None:
    kinematics, chain = arm(name), chain_of_arm(name)
    for _ in range(10):
        q = rng.uniform(np.maximum(chain.lower, -2.5), np.minimum(chain.upper, 2.5))
        for joint in joints:
            q[joint] = off * rng.choice([-1, 1]) + (STRAIGHT[name] if joint == 3 else 0.0)
        target = kinematics.forward(q)[-1]
        result = kinematics.inverse(target, InverseOptions(seed=q))
        assert len(result.solutions), result.reason
        assert max(np.abs(kinematics.forward(one)[-1] - target).max() for one in result.solutions) < 1e-9
        # What is lost of the bend of a stretched arm is the root of what is lost of its length.
        np.testing.assert_allclose(result.solutions[0], q, atol=1e-6 if 3 in joints else 1e-5)
        # Joints that are drawn, and those of other branches, may be nearly straight too.
        every = kinematics.inverse(target, InverseOptions(seed=q, respect_limits=False)).solutions
        for joint, word in ((1, "the shoulder"), (3, "the elbow"), (5, "the wrist")):
            straight = STRAIGHT[name] if joint == 3 else 0.0
            is_near = np.abs(np.sin(every[:, joint] - straight)).min() < SINGULAR_OF_SEVEN
            assert is_near or joint not in joints
            assert (word in result.reason) == is_near


def test_the_wrist_above_axis_1_has_an_arm_angle() -> None:
    """There the angle counts from joint 1 at 0, so that it says where the elbow is all the same."""
    kinematics = arm("iiwa7")
    bend = 1.1
    # Upper arm and forearm have equal lengths: the wrist is above axis 1 where joint 2 takes half of the bend.
    q = np.array([0.7, -bend / 2.0, 0.0, -bend, 0.2, 0.5, 0.3])
    h, p = axes("iiwa7", q)
    assert np.abs(meeting(h, p, 5, 6)[:2]).max() < 1e-9
    target = kinematics.forward(q)[-1]
    result = kinematics.inverse(target, InverseOptions(seed=q))
    np.testing.assert_allclose(result.solutions[0], q, atol=1e-9)
    turned = kinematics.inverse(target, InverseOptions(seed=q, arm_angle=result.arm_angles[0] + 0.4))
    np.testing.assert_allclose(turned.solutions[0][:4], q[:4] + np.array([0.4, 0.0, 0.0, 0.0]), atol=1e-9)


def test_no_pose_near_a_singular_one_goes_wrong(rng: np.random.Generator) -> None:
    kinematics, chain = arm("iiwa"), chain_of_arm("iiwa")
    for _ in range(500):
        q = rng.uniform(chain.lower, chain.upper)
        near = rng.choice([1, 3, 5], rng.integers(1, 4), replace=False)
        q[near] = 10.0 ** rng.uniform(-12.0, -2.0, len(near)) * rng.choice([-1.0, 1.0], len(near))
        target = kinematics.forward(q)[-1]
        result = kinematics.inverse(target, InverseOptions(seed=q))
        assert len(result.solutions), (q.tolist(), result.reason)
        np.testing.assert_allclose(result.solutions[0], q, atol=2e-6)
