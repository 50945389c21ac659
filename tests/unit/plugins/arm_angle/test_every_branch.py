"""All branches at an arm angle: none is missed, none is false; and the arm angle is the elbow's place."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_sdk.kinematics import InverseOptions

from ..closed_form.arms import distances
from .arms import NAMES, STRAIGHT, arm, between, chain_of_arm, elbow_angle, numeric

POSES = 150
STARTS = 15


def is_stretched(name: str, q: np.ndarray) -> bool:
    """Return whether a posture hardly tells on which side its elbow is: below 2e-7 it counts as on the line."""
    return abs(np.sin(q[3] - STRAIGHT[name])) < 1e-5


@pytest.mark.parametrize("name", NAMES)
def test_the_arm_angle_is_where_the_elbow_is(name: str, rng: np.random.Generator) -> None:
    for q in rng.uniform(-np.pi, np.pi, (200, 7)):
        q[3] = rng.uniform(0.3, 2.5) * rng.choice([-1, 1])
        assert between(arm(name).arm_angle(q), elbow_angle(name, q)) < 1e-8
        # With joint 3 at 0 the elbow is in the plane through axis 1.
        q[2] = 0.0
        assert min(between(arm(name).arm_angle(q), straight) for straight in (0.0, np.pi)) < 1e-8


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_no_posture_is_missed_at_its_arm_angle(name: str, rng: np.random.Generator) -> None:
    """A numeric search from many starts finds postures with elbows anywhere; each must be found again at its angle."""
    kinematics, search = arm(name), numeric(name)
    met = 0
    for _ in range(POSES):
        q = rng.uniform(-np.pi, np.pi, 7)
        target = search.forward(q)[-1]
        ends = (search.refined(target, start) for start in rng.uniform(-np.pi, np.pi, (STARTS, 7)))
        for posture in [q, *(end for end in ends if end is not None)]:
            met += 1
            wish = InverseOptions(respect_limits=False, arm_angle=kinematics.arm_angle(posture))
            result = kinematics.inverse(target, wish)
            assert len(result.solutions) == len(set(result.configurations)) == 8 or result.reason
            assert max(np.abs(numeric(name).forward(one)[-1] - target).max() for one in result.solutions) < 1e-9
            # The search ends within 1e-10 of the pose: near a singularity that is farther from the posture.
            blur = 2e-9 / np.linalg.svd(search.jacobian(posture), compute_uv=False)[-1]
            assert distances(result.solutions, posture).min() < 1e-5 + 10.0 * blur or result.reason
            assert all(between(kinematics.arm_angle(one), wish.arm_angle or 0.0) < 1e-6 for one in result.solutions)
    assert met > 2 * POSES, "the search itself must find postures"


@pytest.mark.parametrize("name", NAMES)
def test_the_seed_s_posture_comes_first_with_its_arm_angle(name: str, rng: np.random.Generator) -> None:
    kinematics, chain = arm(name), chain_of_arm(name)
    for q in rng.uniform(chain.lower, chain.upper, (200, 7)):
        result = kinematics.inverse(kinematics.forward(q)[-1], InverseOptions(seed=q))
        np.testing.assert_allclose(result.solutions[0], q, atol=1e-6)
        assert len(result.arm_angles) == len(result.solutions)
        assert is_stretched(name, q) or between(result.arm_angles[0], elbow_angle(name, q)) < 1e-6
        for one, angle in zip(result.solutions, result.arm_angles, strict=True):
            assert between(angle, kinematics.arm_angle(one)) < 1e-5
        assert (result.solutions >= chain.lower).all()
        assert (result.solutions <= chain.upper).all()
        apart = ((result.solutions - q) ** 2).sum(axis=1)
        assert (np.diff(apart) >= -1e-9).all()
        last = result.configurations[-1]
        only = kinematics.inverse(kinematics.forward(q)[-1], InverseOptions(seed=q, configuration=last))
        assert last in only.configurations


@pytest.mark.parametrize("name", NAMES)
def test_the_signs_in_a_name_are_those_of_joints_2_4_and_6(name: str, rng: np.random.Generator) -> None:
    """On these arms 0 is straight, but for the elbow of the WAM, whose offset makes it straight elsewhere."""
    for q in rng.uniform(-np.pi, np.pi, (100, 7)):
        found = arm(name).inverse(arm(name).forward(q)[-1], InverseOptions(seed=q, respect_limits=False))
        signs = "".join("+" if np.sin(value) > 0 else "-" for value in (q[1], q[3] - STRAIGHT[name], q[5]))
        assert is_stretched(name, q) or [word[-1] for word in found.configurations[0].split()[:3]] == list(signs)


def test_a_joint_with_room_for_two_turns_comes_with_both() -> None:
    q = np.array([0.3, -0.5, 0.4, 1.2, -2.5, 0.6, 0.1])
    wide = chain_of_arm("wam")._replace(lower=np.full(7, -5.0), upper=np.full(7, 5.0))
    kinematics = type(arm("wam"))(wide)
    result = kinematics.inverse(arm("wam").forward(q)[-1], InverseOptions(seed=q))
    turned = [name for name in result.configurations if name.endswith(" joint_5+1")]
    assert turned
    for name in turned:
        only = kinematics.inverse(arm("wam").forward(q)[-1], InverseOptions(seed=q, configuration=name))
        assert only.configurations == (name,)
        branch = kinematics.inverse(
            arm("wam").forward(q)[-1], InverseOptions(seed=q, configuration=name.partition(" joint")[0])
        )
        assert {name, name.removesuffix(" joint_5+1")} <= set(branch.configurations)
