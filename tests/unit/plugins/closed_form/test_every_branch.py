"""No solution is missed and none is false: 1,000 fresh poses of each arm against a numeric search from many starts."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from virtualrobot_sdk.kinematics import InverseOptions, InverseStatus

from tests.tiers import Draws

from .arms import NAMED, arm_chain, closed_form, closure, distances, factors, numeric

POSES = 1000
STARTS = 60
ANYWHERE = InverseOptions(respect_limits=False)
OTHERS = ("kr3", "kr5", "kr6_r700", "kr6_r900", "kr10", "kr120", "kr150", "kr210", "puma560_meshes", "wx250s", "vx300s")
SHORT = ("al5d", "px150", "rx200", "wx250")


def missed(name: str, poses: int, rng: np.random.Generator) -> list[str]:
    """Return what the search finds and the closed form doesn't, without regard to limits; every branch must close."""
    kinematics, search = closed_form(name), numeric(name)
    k = len(kinematics.joint_names)
    found = []
    met = 0
    for _ in range(poses):
        q = rng.uniform(-np.pi, np.pi, k)
        target = search.forward(q)[-1]
        result = kinematics.inverse(target, ANYWHERE)
        assert closure(name, result.solutions, target) < 1e-9
        ends = (search.refined(target, start) for start in rng.uniform(-np.pi, np.pi, (STARTS, k)))
        for other in [q, *(end for end in ends if end is not None)]:
            met += 1
            # The search ends within 1e-10 of the pose: near a singularity that is farther from the posture.
            blur = 2e-9 / np.linalg.svd(search.jacobian(other), compute_uv=False)[-1]
            if distances(result.solutions, other).min() > 1e-5 + blur and not result.reason:
                found.append(f"pose of {q.tolist()}: {other.tolist()}")
    # The search itself must work: each pose is met more often than by its own posture.
    assert met > 3 * poses
    return found


@pytest.mark.parametrize("name", NAMED)
def test_no_solution_of_a_thousand_poses_is_missed(name: str, rng: np.random.Generator, draws: Draws) -> None:
    assert missed(name, draws(POSES), rng) == []


@pytest.mark.long
@pytest.mark.parametrize("name", [*OTHERS, *SHORT])
def test_no_solution_of_other_models_is_missed(name: str, rng: np.random.Generator, draws: Draws) -> None:
    assert missed(name, draws(100), rng) == []


@pytest.mark.parametrize("name", NAMED)
def test_every_posture_within_limits_is_among_the_solutions_with_its_turns(
    name: str, rng: np.random.Generator, draws: Draws
) -> None:
    """The seed's own posture comes first; all are within limits and close."""
    kinematics, chain = closed_form(name), arm_chain(name)
    for _ in range(draws(200)):
        q = rng.uniform(chain.lower, chain.upper)
        target = numeric(name).forward(q)[-1]
        result = kinematics.inverse(target, InverseOptions(seed=q))
        if result.reason:
            continue
        np.testing.assert_allclose(result.solutions[0], q, atol=1e-6)
        assert closure(name, result.solutions, target) < 1e-9
        assert ((result.solutions >= chain.lower) & (result.solutions <= chain.upper)).all()
        gaps = np.linalg.norm(result.solutions - q, axis=1)
        assert (np.diff(gaps) > -1e-12).all()


@pytest.mark.parametrize("name", NAMED)
def test_all_full_turns_within_limits_come(name: str, rng: np.random.Generator) -> None:
    """Counted by trying every shift of every branch by -1, 0 and 1 turns."""
    kinematics, chain = closed_form(name), arm_chain(name)
    shifts = 2.0 * np.pi * np.array(list(product((-1, 0, 1), repeat=6)))
    for _ in range(20):
        target = numeric(name).forward(rng.uniform(chain.lower, chain.upper))[-1]
        branches = kinematics.inverse(target, ANYWHERE).solutions
        turned = (branches[:, None] + shifts).reshape(-1, 6)
        expected = turned[((turned >= chain.lower) & (turned <= chain.upper)).all(axis=1)]
        result = kinematics.inverse(target)
        if result.reason:
            continue
        assert len(result.solutions) == len(expected)
        np.testing.assert_allclose(sorted(result.solutions.tolist()), sorted(expected.tolist()), atol=1e-9)


@pytest.mark.parametrize("name", NAMED)
def test_a_name_belongs_to_one_sign_of_each_factor_of_the_jacobian(name: str, rng: np.random.Generator) -> None:
    """So no branch changes its name where the arm is not singular, and no two have one name."""
    kinematics = closed_form(name)
    signs: dict[str, set[tuple[float, ...]]] = {}
    for _ in range(200):
        target = numeric(name).forward(rng.uniform(-np.pi, np.pi, 6))[-1]
        result = kinematics.inverse(target, ANYWHERE)
        if result.reason:
            continue
        assert len(set(result.configurations)) == len(result.solutions)
        for solution, configuration in zip(result.solutions, result.configurations, strict=True):
            branch = " ".join(configuration.split()[:3])
            signs.setdefault(branch, set()).add(tuple(np.sign(factors(name, solution))))
    assert set(signs) == set(kinematics.configurations)
    assert all(len(one) == 1 for one in signs.values())
    assert len(set.union(*signs.values())) == 8


def test_a_pose_out_of_reach_is_refused_with_a_reason() -> None:
    target = np.eye(4)
    target[:3, 3] = (3.0, 0.0, 0.5)
    result = closed_form("puma560").inverse(target)
    assert result.status is InverseStatus.UNREACHABLE
    assert "no posture reaches" in result.reason
