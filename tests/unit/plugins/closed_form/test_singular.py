"""At singular poses and next to them: what comes closes, the seed's posture is met, and the singularity is named."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.optimize import root_scalar
from virtualrobot_sdk.kinematics import InverseOptions, InverseStatus

from .arms import NAMED, closed_form, closure, distances, factors, numeric

SHOULDER, ELBOW, WRIST = 0, 1, 2
WORDS = {SHOULDER: "the shoulder", ELBOW: "the elbow", WRIST: "the wrist"}
TURNED = {SHOULDER: 1, ELBOW: 2, WRIST: 4}
"""The joint (from 0) that leads to the singularity."""
OFFSETS = (0.0, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5)
NEAR = (1e-4, 1e-3)


def singular_postures(name: str, which: int, count: int, rng: np.random.Generator) -> Iterator[np.ndarray]:
    """Yield postures at which one factor of the Jacobian is zero, found by bisection in one joint."""
    joint = TURNED[which]
    while count:
        q = rng.uniform(-np.pi, np.pi, 6)

        def factor(angle: float, q: np.ndarray = q) -> float:
            q[joint] = angle
            return float(factors(name, q)[which])

        grid = np.linspace(-np.pi, np.pi, 40)
        values = [factor(angle) for angle in grid]
        changes = [i for i in range(39) if values[i] * values[i + 1] < 0.0]
        if changes:
            i = rng.choice(changes)
            q[joint] = root_scalar(factor, bracket=(grid[i], grid[i + 1]), xtol=1e-15).root
            count -= 1
            yield q


@pytest.mark.long
@pytest.mark.parametrize("which", WORDS, ids=lambda which: WORDS[which].split()[-1])
@pytest.mark.parametrize("name", NAMED)
def test_a_singular_pose_is_solved_near_the_seed_and_its_singularity_named(
    name: str, which: int, rng: np.random.Generator
) -> None:
    for offset in (*OFFSETS, *NEAR):
        for q in singular_postures(name, which, 4, rng):
            q[TURNED[which]] += offset * rng.choice([-1.0, 1.0])
            target = numeric(name).forward(q)[-1]
            result = closed_form(name).inverse(target, InverseOptions(seed=q, respect_limits=False))
            assert result.status is InverseStatus.SOLVED, offset
            assert closure(name, result.solutions, target) < 1e-9
            assert np.abs(result.solutions[0] - q).max() < 1e-3, offset
            assert len(set(result.configurations)) == len(result.solutions)
            if offset in OFFSETS:
                assert WORDS[which] in result.reason


@pytest.mark.long
@pytest.mark.parametrize("which", WORDS, ids=lambda which: WORDS[which].split()[-1])
@pytest.mark.parametrize("name", NAMED)
def test_at_a_singular_pose_no_posture_that_is_not_singular_is_missed(
    name: str, which: int, rng: np.random.Generator
) -> None:
    for q in singular_postures(name, which, 10, rng):
        target = numeric(name).forward(q)[-1]
        solutions = closed_form(name).inverse(target, InverseOptions(respect_limits=False)).solutions
        for start in rng.uniform(-np.pi, np.pi, (20, 6)):
            other = numeric(name).refined(target, start)
            if other is not None and np.abs(factors(name, other)).min() > 1e-3:
                assert distances(solutions, other).min() < 1e-4


@pytest.mark.parametrize("name", NAMED)
def test_next_to_a_straight_wrist_a_posture_is_met_without_a_seed(name: str, rng: np.random.Generator) -> None:
    """It bends by less than rounding to six digits does; of each branch there is one posture, and it is this one."""
    for offset in (1e-7, 1e-6, 1e-5):
        for q in singular_postures(name, WRIST, 4, rng):
            q[TURNED[WRIST]] += offset * rng.choice([-1.0, 1.0])
            if np.abs(factors(name, q)[[SHOULDER, ELBOW]]).min() < 0.05:
                continue  # next to two singularities at once 1e-10 tells even less of the posture
            solutions = (
                closed_form(name).inverse(numeric(name).forward(q)[-1], InverseOptions(respect_limits=False)).solutions
            )
            assert distances(solutions, q).min() < 1e-2, (offset, q.tolist())


@pytest.mark.parametrize("name", ["ur5", "irb2400", "puma560"])
def test_all_joints_at_zero_are_met(name: str) -> None:
    """Zero is where models are drawn: often stretched and with a straight wrist at once."""
    target = numeric(name).forward(np.zeros(6))[-1]
    result = closed_form(name).inverse(target, InverseOptions(seed=np.zeros(6)))
    np.testing.assert_allclose(result.solutions[0], 0.0, atol=1e-3)
    assert closure(name, result.solutions, target) < 1e-9
    assert "singular" in result.reason
