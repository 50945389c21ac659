"""The component `closed_form`: names, configurations, order, limits, and what it refuses."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_plugins.closed_form.component import ClosedFormKinematics
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import InverseOptions, InverseResult, InverseStatus, SerialChain
from virtualrobot_sdk.testing.chains import iiwa, palletizer, puma560, stanford, ur5

from ..chain.chains import random_chain
from .arms import arm_chain, closed_form, distances, numeric

QN = np.array([0.0, np.pi / 4, np.pi, 0.0, np.pi / 4, 0.0])


def by_name(result: InverseResult) -> dict[str, np.ndarray]:
    """Return the solutions by the name of their configuration."""
    return dict(zip(result.configurations, result.solutions, strict=True))


def branch(configuration: str) -> str:
    """Return a configuration's name without its turns."""
    return " ".join(configuration.split()[:3])


def test_names_are_those_of_the_textbook() -> None:
    """P. Corke, Robotics, Vision and Control, 2011, 7.3.1: the pose of qn; `ikine6s` gives `lun` and `run` so."""
    kinematics = ClosedFormKinematics(puma560())
    result = kinematics.inverse(kinematics.forward(QN)[-1], InverseOptions(respect_limits=False))
    found = {branch(name): q for name, q in by_name(result).items()}
    left_up_noflip = np.array([[2.6486, -3.9270, 0.0940, 2.5326, 0.9743, 0.3734]])
    assert distances(left_up_noflip, found["left up noflip"]).max() < 1e-4
    assert distances(QN[None], found["right up noflip"]).max() < 1e-9


def test_the_elbow_is_up_where_it_is_above_the_line_from_shoulder_to_wrist(rng: np.random.Generator) -> None:
    """Seen on arms that reach straight out: the IRB 140, upright and hung from the ceiling."""
    for flip in (np.eye(3), Rotation.from_euler("x", np.pi).as_matrix()):
        upright = arm_chain("irb2400")
        pre = upright.pre.copy()
        pre[0, :3, :3] = flip @ pre[0, :3, :3]
        pre[0, :3, 3] = flip @ pre[0, :3, 3]
        kinematics = ClosedFormKinematics(upright._replace(pre=pre))
        forward = kinematics.forward(np.zeros(6))
        target = forward[-1].copy()
        # Before the arm at the height of its shoulder, the flange turned at random.
        shoulder = forward[1, :3, 3]
        target[:3, 3] = shoulder + 0.5 * (shoulder - forward[0, :3, 3]) * (1.0, 1.0, 0.0) / 0.07
        target[:3, :3] = Rotation.from_quat(rng.normal(size=4)).as_matrix()
        result = kinematics.inverse(target, InverseOptions(respect_limits=False))
        for name, q in by_name(result).items():
            frames = kinematics.forward(q)
            line = (frames[1, 2, 3] + frames[4, 2, 3]) / 2.0
            assert name.split()[1] == ("up" if frames[2, 2, 3] > line else "down"), name


def test_without_a_seed_the_order_is_always_the_same(rng: np.random.Generator) -> None:
    kinematics = ClosedFormKinematics(ur5(np.inf))
    for _ in range(50):
        target = kinematics.forward(rng.uniform(-np.pi, np.pi, 6))[-1]
        names = kinematics.inverse(target).configurations
        places = [kinematics.configurations.index(name) for name in names]
        assert places == sorted(places)


def test_with_limits_without_end_each_branch_comes_near_the_seed(rng: np.random.Generator) -> None:
    kinematics = ClosedFormKinematics(ur5(np.inf))
    for _ in range(20):
        seed = rng.uniform(-30.0, 30.0, 6)
        result = kinematics.inverse(kinematics.forward(rng.normal(size=6))[-1], InverseOptions(seed=seed))
        assert len(result.solutions) <= 8
        assert np.abs(result.solutions - seed).max() <= np.pi + 1e-9


def test_only_the_named_configuration_comes(rng: np.random.Generator) -> None:
    kinematics = closed_form("kr16")
    chain = arm_chain("kr16")
    turned = 0
    for _ in range(50):
        q = rng.uniform(chain.lower, chain.upper)
        target = numeric("kr16").forward(q)[-1]
        every = by_name(kinematics.inverse(target, InverseOptions(seed=q)))
        for name in kinematics.configurations:
            wanted = [one for one in every if one == name or one.startswith(f"{name} ")]
            result = kinematics.inverse(target, InverseOptions(seed=q, configuration=name))
            assert list(result.configurations) == wanted
            if not wanted:
                assert result.status in (InverseStatus.OUTSIDE_LIMITS, InverseStatus.UNREACHABLE)
                assert name in result.reason
        for name, solution in every.items():
            if name != branch(name):
                turned += 1
                (only,) = kinematics.inverse(target, InverseOptions(seed=q, configuration=name)).solutions
                np.testing.assert_allclose(only, solution, atol=1e-12)
    assert turned


def test_turns_are_counted_from_the_angle_within_half_a_turn() -> None:
    kinematics = ClosedFormKinematics(ur5())
    q = np.array([0.3, -1.0, 1.2, 4.0, -5.0, 0.5])
    result = kinematics.inverse(kinematics.forward(q)[-1], InverseOptions(seed=q))
    assert result.configurations[0].split()[3:] == ["joint_4+1", "joint_5-1"]
    assert len(result.solutions) == 64 * len({" ".join(name.split()[:3]) for name in result.configurations})
    (again,) = kinematics.inverse(
        kinematics.forward(q)[-1], InverseOptions(configuration=result.configurations[0])
    ).solutions
    np.testing.assert_allclose(again, q, atol=1e-9)


@pytest.mark.parametrize(
    "name",
    [
        "right up",
        "lun",
        "right up noflip joint_7+1",
        "right up noflip joint_6",
        "right up noflip joint_6+0",
        "noflip up",
    ],
)
def test_an_unknown_configuration_is_refused_with_the_valid_ones(name: str) -> None:
    kinematics = ClosedFormKinematics(puma560())
    with pytest.raises(ArgumentError, match=r"'left up noflip', 'left up flip', .* 'right down flip'") as refusal:
        kinematics.inverse(kinematics.forward(QN)[-1], InverseOptions(configuration=name))
    assert refusal.value.metadata["configuration"] == name


def test_arms_without_names_and_the_chain_refuse_a_configuration() -> None:
    for kinematics in (closed_form("al5d"), ChainKinematics(puma560())):
        target = kinematics.forward(np.full(len(kinematics.joint_names), 0.3))[-1]
        with pytest.raises(ArgumentError, match="without a configuration the branch nearest to the seed is taken"):
            kinematics.inverse(target, InverseOptions(configuration="right up noflip"))


def test_a_pose_outside_limits_says_which_joint_breaks_which_limit() -> None:
    chain = puma560()
    chain = chain._replace(lower=np.full(6, -0.1), upper=np.full(6, 0.1))
    kinematics = ClosedFormKinematics(chain)
    result = kinematics.inverse(kinematics.forward(QN)[-1])
    assert result.status is InverseStatus.OUTSIDE_LIMITS
    assert "outside -0.1000 to 0.1000" in result.reason


def test_a_model_that_rounds_its_angles_is_solved_exactly(rng: np.random.Generator) -> None:
    """A right angle written as 1.5708, as in model files: EAIK solves the arm that was meant, Newton the given one."""
    exact = puma560()
    pre = exact.pre.copy()
    for pose in pre[1:]:
        angles = Rotation.from_matrix(pose[:3, :3]).as_euler("xyz")
        pose[:3, :3] = Rotation.from_euler("xyz", np.round(angles, 4)).as_matrix()
    assert 1e-7 < np.abs(pre - exact.pre).max() < 1e-4
    rounded = exact._replace(pre=pre)
    kinematics, search = ClosedFormKinematics(rounded), ChainKinematics(rounded)
    stretched = np.pi / 2 + np.arctan2(0.0203, 0.4318)
    for _ in range(50):
        q = rng.uniform(-np.pi, np.pi, 6)
        if abs(q[2] - stretched) < 0.05:
            continue  # the arm that was meant may not reach so far; see docs/kinematics.md
        target = search.forward(q)[-1]
        result = kinematics.inverse(target, InverseOptions(respect_limits=False))
        assert len(result.solutions) == 8 or result.reason
        assert max(np.abs(search.forward(one)[-1] - target).max() for one in result.solutions) < 1e-9
        # Solutions are polished to within 1e-10 of the pose: near a singularity that is farther from the posture.
        blur = 2e-9 / np.linalg.svd(search.jacobian(q), compute_uv=False)[-1]
        assert result.reason or distances(result.solutions, q).min() < 1e-5 + blur


@pytest.mark.parametrize(
    ("chain", "words"),
    [
        (iiwa(), "7 joints .* at most 6"),
        (stanford(), "'joint_3' slides"),
        (palletizer(), "follow one coordinate"),
        (random_chain(np.random.default_rng(1), [1] * 6), "knows no closed form for this geometry .*Unknown"),
    ],
    ids=["iiwa", "stanford", "palletizer", "general"],
)
def test_other_arms_are_refused_in_words(chain: SerialChain, words: str) -> None:
    with pytest.raises(ArgumentError, match=words):
        ClosedFormKinematics(chain)


def test_without_the_library_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "eaik.pybindings.EAIK", None)
    with pytest.raises(ArgumentError, match=r"virtualrobot\[closed-form\]"):
        ClosedFormKinematics(puma560())


def test_looser_tolerances_are_met_by_the_numeric_search() -> None:
    """Two tenths of a millimetre out of reach of the stretched arm: lengths of Corke and Armstrong-Helouvry, 1994."""
    kinematics = ClosedFormKinematics(puma560())
    reach = 0.4318 + np.hypot(0.4318, 0.0203)
    target = np.eye(4)
    target[:3, 3] = np.hypot(reach + 2e-4, 0.15005), 0.0, kinematics.forward(np.zeros(6))[1, 2, 3]
    free = InverseOptions(respect_limits=False)
    result = kinematics.inverse(target, free)
    assert result.status is InverseStatus.UNREACHABLE
    assert "the nearest is off by 0.2" in result.reason
    result = kinematics.inverse(target, replace(free, position_tolerance=1e-3, rotation_tolerance=1e-2))
    assert result.status is InverseStatus.SOLVED
    reached = kinematics.forward(result.solutions[0])[-1]
    assert 1e-9 < np.abs(reached - target).max() < 1e-2
