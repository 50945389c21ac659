"""The component `chain`: what it answers where there is no solution, what it refuses, and that equal calls agree."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import InverseOptions, InverseStatus, Kinematics

from ...numeric.urdf_arrays import ARMS
from .arms import arm, arm_chain

PLUGINS = Path(__file__).parents[4] / "plugins"


@pytest.fixture(scope="module")
def iiwa() -> ChainKinematics:
    return arm("iiwa")


def test_it_is_a_kinematics_component(iiwa: ChainKinematics) -> None:
    component: Kinematics = iiwa
    assert component.joint_names == tuple(f"lbr_iiwa_joint_{i}" for i in range(1, 8))
    assert component.lower.shape == component.upper.shape == (7,)
    assert component.forward(np.zeros(7)).shape == (8, 4, 4)
    assert component.jacobian(np.zeros(7)).shape == (6, 7)


@pytest.mark.parametrize("name", sorted(ARMS))
def test_the_seed_is_kept_where_it_solves(name: str, rng: np.random.Generator) -> None:
    kinematics = arm(name)
    q = rng.uniform(kinematics.lower, kinematics.upper)
    result = kinematics.inverse(kinematics.forward(q)[-1], InverseOptions(seed=q))
    np.testing.assert_allclose(result.solutions, q[None], atol=1e-9)
    assert (result.starts, result.configurations) == (1, ("",))


def test_small_moves_of_the_target_give_small_moves_of_the_joints(iiwa: ChainKinematics) -> None:
    q = np.array([0.3, 0.6, -0.2, -1.2, 0.4, 0.8, 0.1])
    for _ in range(100):
        target = iiwa.forward(q)[-1]
        target[0, 3] += 0.001
        following = iiwa.inverse(target, InverseOptions(seed=q)).solutions[0]
        assert np.abs(following - q).max() < 0.02
        q = following


@pytest.mark.parametrize("name", sorted(ARMS))
def test_equal_calls_give_equal_answers_to_the_last_bit(name: str, rng: np.random.Generator) -> None:
    first, second = arm(name), arm(name)
    for q in rng.uniform(first.lower, first.upper, (100, len(first.lower))):
        target = first.forward(q)[-1]
        one, other = first.inverse(target), second.inverse(target)
        assert one.solutions.tobytes() == other.solutions.tobytes()
        assert (one.starts, one.iterations) == (other.starts, other.iterations)


def test_another_random_seed_may_find_another_solution(rng: np.random.Generator) -> None:
    puma = arm("puma560")
    targets = [puma.forward(q)[-1] for q in rng.uniform(puma.lower, puma.upper, (50, 6))]
    found = [[puma.inverse(t, InverseOptions(random_seed=s)).solutions[0] for t in targets] for s in (0, 1)]
    # Only a third of the Puma's poses are found from mid-range; the rest take a start drawn by the seed.
    assert not np.allclose(found[0], found[1])


def test_a_target_beyond_all_links_is_refused_with_both_distances(iiwa: ChainKinematics) -> None:
    target = np.eye(4)
    target[:3, 3] = [0, 3, 0.1575]
    result = iiwa.inverse(target)
    assert result.status is InverseStatus.UNREACHABLE
    assert result.solutions.shape == (0, 7)
    # The iiwa 14's offsets between joints in the URDF; the first joint is 0.1575 above the base.
    reach = sum([0.2025, 0.2045, 0.2155, 0.1845, 0.2155, 0.081])
    assert result.starts == 0
    assert "3.0000 m" in result.reason
    assert f"{reach:.4f} m" in result.reason
    assert result.position_error == pytest.approx(3.0 - reach, abs=1e-9)


def test_a_target_within_reach_that_nothing_solves_says_how_near_it_came(iiwa: ChainKinematics) -> None:
    # Upper arm and forearm reach 0.82 m from the shoulder, at 0.36 m height; pointing back from 0.85 m the wrist would
    # have to be farther out than that.
    target = np.array([[0, 0, -1.0, 0.85], [0, 1, 0, 0], [1, 0, 0, 0.36], [0, 0, 0, 1]])
    result = iiwa.inverse(target, InverseOptions(max_restarts=50))
    assert result.status is InverseStatus.UNREACHABLE
    assert result.solutions.shape == (0, 7)
    assert result.starts == 51
    assert result.position_error > 1e-3
    assert "no solution within limits after 51 starts" in result.reason
    assert f"{result.position_error * 1e3:.3g} mm" in result.reason


def test_a_target_outside_limits_names_the_joint(iiwa: ChainKinematics) -> None:
    chain = arm_chain("iiwa")
    narrow = chain._replace(lower=chain.lower.copy(), upper=chain.upper.copy())
    narrow.upper[3] = -0.5
    kinematics = ChainKinematics(narrow)
    target = iiwa.forward([0.3, 0.5, 0.2, -0.1, 0.4, 0.5, 0.1])[-1]  # the elbow alone sets the distance to the wrist
    result = kinematics.inverse(target, InverseOptions(max_restarts=50))
    assert result.status is InverseStatus.OUTSIDE_LIMITS
    assert result.solutions.shape == (0, 7)
    assert "'lbr_iiwa_joint_4' at" in result.reason
    free = kinematics.inverse(target, InverseOptions(respect_limits=False))
    assert free.status is InverseStatus.SOLVED
    assert abs(free.solutions[0, 3]) == pytest.approx(0.1, abs=1e-6)
    np.testing.assert_allclose(kinematics.forward(free.solutions[0])[-1], target, atol=1e-8)


def test_a_loose_tolerance_takes_the_nearest_posture(iiwa: ChainKinematics) -> None:
    # Straight up, 0.5 mm higher than the iiwa reaches: 0.1575 + the offsets of the test above.
    target = np.eye(4)
    target[2, 3] = iiwa.forward(np.zeros(7))[-1][2, 3] + 0.0005
    assert iiwa.inverse(target, InverseOptions(max_restarts=5)).status is InverseStatus.UNREACHABLE
    loose = iiwa.inverse(target, InverseOptions(position_tolerance=1e-3, rotation_tolerance=1e-3))
    assert loose.status is InverseStatus.SOLVED
    assert 0.0005 - 1e-9 < loose.position_error < 1e-3


def test_a_target_written_with_five_digits_is_taken(iiwa: ChainKinematics, rng: np.random.Generator) -> None:
    q = rng.uniform(iiwa.lower, iiwa.upper) / 2
    q[3] = rng.choice([-1.0, 1.0]) * rng.uniform(0.1, 1.0)  # stretched, the arm would not reach what is rounded up
    target = iiwa.forward(q)[-1]
    result = iiwa.inverse(np.round(target, 5))
    assert result.status is InverseStatus.SOLVED
    np.testing.assert_allclose(iiwa.forward(result.solutions[0])[-1], target, atol=2e-5)


def test_nan_targets_are_refused_with_their_place(iiwa: ChainKinematics) -> None:
    target = np.eye(4)
    target[1, 3] = np.nan
    with pytest.raises(ArgumentError, match="nan in row 1, column 3") as caught:
        iiwa.inverse(target)
    assert caught.value.metadata["row"] == "1"


@pytest.mark.parametrize(
    ("target", "said"),
    [
        (np.diag([1.0, 1.0, -1.0, 1.0]), "reflection"),
        (np.diag([1.1, 1.0, 1.0, 1.0]), "off by 0.21"),
        (np.eye(4) + np.eye(4)[[3, 0, 1, 2]], "no rigid transform"),
        (np.eye(3), r"shape \(3, 3\)"),
        (np.full((4, 4), np.inf), "inf in row 0, column 0"),
    ],
)
def test_targets_that_are_no_poses_are_refused(iiwa: ChainKinematics, target: np.ndarray, said: str) -> None:
    with pytest.raises(ArgumentError, match=said):
        iiwa.inverse(target)


def test_joint_values_that_make_no_sense_are_refused(iiwa: ChainKinematics) -> None:
    with pytest.raises(ArgumentError, match="7 values"):
        iiwa.forward(np.zeros(6))
    with pytest.raises(ArgumentError, match="'lbr_iiwa_joint_3' is nan"):
        iiwa.jacobian([0, 0, np.nan, 0, 0, 0, 0])
    with pytest.raises(ArgumentError, match="the seed of joint 'lbr_iiwa_joint_1' is inf"):
        iiwa.inverse(np.eye(4), InverseOptions(seed=np.full(7, np.inf)))


@pytest.mark.parametrize(
    "options",
    [
        InverseOptions(position_tolerance=0.0),
        InverseOptions(rotation_tolerance=float("nan")),
        InverseOptions(max_restarts=-1),
        InverseOptions(random_seed=-1),
    ],
)
def test_options_that_make_no_sense_are_refused(iiwa: ChainKinematics, options: InverseOptions) -> None:
    with pytest.raises(ArgumentError, match="must be"):
        iiwa.inverse(np.eye(4), options)


def test_chains_that_make_no_sense_are_refused() -> None:
    chain = arm_chain("iiwa")
    with pytest.raises(ArgumentError, match="3 lower and upper limits"):
        ChainKinematics(chain._replace(joint_names=("a", "b", "c")))
    swapped = chain._replace(lower=chain.upper, upper=chain.lower)
    with pytest.raises(ArgumentError, match="'0' has lower limit"):
        ChainKinematics(swapped._replace(joint_names=tuple("0123456")))


@pytest.mark.long
def test_two_processes_agree() -> None:
    program = (
        "from virtualrobot_plugins.chain.component import ChainKinematics\n"
        "from virtualrobot_plugins.chain.serial import SerialChain\n"
        "import numpy as np\n"
        "n = 6; eye = np.tile(np.eye(4), (n, 1, 1)); eye[:, :3, 3] = np.arange(18).reshape(6, 3) / 50\n"
        "axis = np.eye(3)[[2, 1, 1, 0, 1, 0]]\n"
        "chain = SerialChain(eye, axis, np.ones(n, np.int8), np.arange(n, dtype=np.int32), np.ones(n), np.zeros(n),\n"
        "    np.eye(4), np.full(n, -2.0), np.full(n, 2.0), tuple('abcdef'))\n"
        "arm = ChainKinematics(chain)\n"
        "solved = arm.inverse(arm.forward(np.linspace(-1.9, 1.9, n))[-1])\n"
        "print(solved.solutions.tobytes().hex(), solved.starts)\n"
    )
    answers = {
        subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "PYTHONPATH": str(PLUGINS)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for _ in range(2)
    }
    assert len(answers) == 1
