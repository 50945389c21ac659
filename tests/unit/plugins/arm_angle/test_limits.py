"""Where limits leave room for the elbow: an arm angle is found whenever there is one, and it is the nearest."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import InverseOptions, InverseStatus

from tests.tiers import Draws

from ..closed_form.arms import arm_chain
from .arms import NAMES, arm, between, chain_of_arm

GRID = np.radians(np.arange(-180.0, 180.0, 1.0))


@pytest.mark.parametrize("name", NAMES)
def test_every_reachable_pose_is_solved_from_any_seed(name: str, rng: np.random.Generator, draws: Draws) -> None:
    kinematics, chain = arm(name), chain_of_arm(name)
    moved = 0
    for _ in range(draws(300)):
        target = kinematics.forward(rng.uniform(chain.lower, chain.upper))[-1]
        seed = rng.uniform(chain.lower, chain.upper)
        result = kinematics.inverse(target, InverseOptions(seed=seed))
        assert result.status is InverseStatus.SOLVED, result.reason
        assert max(np.abs(kinematics.forward(one)[-1] - target).max() for one in result.solutions) < 1e-9
        moved += between(result.arm_angles[0], kinematics.arm_angle(seed)) > 1e-6
    assert moved, "some seeds have their elbow where limits leave no room"


def test_the_arm_angle_that_is_found_is_the_nearest(rng: np.random.Generator) -> None:
    """Compared with each degree: none is nearer by more than a degree and the margin of half a degree."""
    kinematics, chain = arm("iiwa"), chain_of_arm("iiwa")
    tried = 0
    while tried < 5:
        target = kinematics.forward(rng.uniform(chain.lower, chain.upper))[-1]
        seed = rng.uniform(chain.lower, chain.upper)
        result = kinematics.inverse(target, InverseOptions(seed=seed))
        wanted = kinematics.arm_angle(seed)
        if min(between(angle, wanted) for angle in result.arm_angles) < 1e-6:
            continue
        tried += 1
        inside = [one for one in GRID if len(kinematics.inverse(target, InverseOptions(arm_angle=one)).solutions)]
        nearest = min((between(one, wanted) for one in inside), default=np.inf)
        assert min(between(angle, wanted) for angle in result.arm_angles) < nearest + np.radians(0.51)


def test_a_seed_brings_every_branch_that_some_arm_angle_has(rng: np.random.Generator) -> None:
    """Compared with every fourth degree of the arm angle; each branch is at no angle farther than that."""
    kinematics, chain = arm("iiwa"), chain_of_arm("iiwa")
    moved = 0
    for _ in range(30):
        q = rng.uniform(chain.lower, chain.upper)
        target = kinematics.forward(rng.uniform(chain.lower, chain.upper))[-1]
        result = kinematics.inverse(target, InverseOptions(seed=q))
        told = {
            name.partition(" lbr")[0]: between(angle, kinematics.arm_angle(q))
            for name, angle in zip(result.configurations, result.arm_angles, strict=True)
        }
        for one in GRID[::4]:
            for name in kinematics.inverse(target, InverseOptions(arm_angle=one)).configurations:
                assert told[name.partition(" lbr")[0]] < between(one, kinematics.arm_angle(q)) + np.radians(0.51)
        apart = ((result.solutions - q) ** 2).sum(axis=1)
        assert (np.diff(apart) >= -1e-9).all()
        moved += len({round(angle, 6) for angle in result.arm_angles}) > 1
    assert moved, "some branches are within limits at other arm angles only"


def test_an_arm_angle_outside_limits_is_refused_with_those_inside(rng: np.random.Generator) -> None:
    kinematics, chain = arm("iiwa"), chain_of_arm("iiwa")
    target = kinematics.forward(np.array([0.2, 1.9, 0.1, -1.0, 0.3, 1.2, 0.4]))[-1]
    told = None
    for angle in GRID:
        result = kinematics.inverse(target, InverseOptions(arm_angle=angle))
        if not len(result.solutions):
            told = result
            assert result.status is InverseStatus.OUTSIDE_LIMITS
            assert "postures reach the pose, all outside limits, for instance with lbr_iiwa_joint" in result.reason
            assert f"at the arm angle {angle:.4f} rad; arm angles within limits: " in result.reason
    assert told is not None
    for pair in told.reason.rpartition("limits: ")[2].split(", "):
        begin, end = (float(value) for value in pair.split(" to "))
        for inside in (begin + 1e-3, (begin + end) / 2.0, end - 1e-3):
            assert len(kinematics.inverse(target, InverseOptions(arm_angle=inside)).solutions)
        assert (chain.lower <= kinematics.inverse(target, InverseOptions(arm_angle=begin + 1e-3)).solutions[0]).all()


def test_a_pose_out_of_reach_is_refused_with_how_far(rng: np.random.Generator) -> None:
    target = arm("iiwa7").forward(np.array([0.3, 0.5, 0.0, 0.0, 0.0, 0.4, 0.0]))[-1]
    target[:3, 3] += 0.1 * np.array([np.cos(0.3) * np.sin(0.5), np.sin(0.3) * np.sin(0.5), np.cos(0.5)])
    result = arm("iiwa7").inverse(target)
    assert (result.status, len(result.solutions)) == (InverseStatus.UNREACHABLE, 0)
    assert result.position_error == pytest.approx(0.1)
    assert "the nearest is off by 100 mm and 0 degrees" in result.reason
    target[:3, 3] *= 1.0 + 5.0 / np.linalg.norm(target[:3, 3])
    assert "off by 5" in arm("iiwa7").inverse(target).reason and "e+" not in arm("iiwa7").inverse(target).reason


def test_options_that_make_no_sense_are_refused() -> None:
    target = arm("iiwa").forward(np.full(7, 0.3))[-1]
    for wrong in (np.nan, np.inf):
        with pytest.raises(ArgumentError, match=r"arm_angle is (nan|inf); it must be a finite number"):
            arm("iiwa").inverse(target, InverseOptions(arm_angle=wrong))
    with pytest.raises(ArgumentError, match=r"there is no configuration 'left up'; there are 'shoulder\+ elbow"):
        arm("iiwa").inverse(target, InverseOptions(configuration="left up"))


@pytest.mark.parametrize(
    ("model", "words"),
    [
        ("panda", "the wrist is not spherical: the axes of panda_joint5, panda_joint6, panda_joint7 pass by"),
        ("puma560", "6 joints that move freely; an arm angle is for seven"),
        ("iiwa14", "the shoulder is not spherical: the axes of joint_a1, joint_a2, joint_a3 pass by 0.291 mm"),
    ],
)
def test_other_arms_are_refused_with_the_reason(model: str, words: str) -> None:
    with pytest.raises(ArgumentError, match=words):
        type(arm("iiwa"))(arm_chain(model))
