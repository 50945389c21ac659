"""Kinematic errors of chains: ranks by counting, errors that are planted are found, and the noise is told."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.planning.kinematic_errors import KinematicErrors
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, SerialChain

OFF_AXIS = np.array([[1.0, 0, 0, 0.05], [0, 1, 0, 0.02], [0, 0, 1, 0.1], [0, 0, 0, 1]])
"""A target that is off the last joint's axis, m."""
FLANGE = np.array([[1.0, 0, 0, 0], [0, 1, 0, -0.0996], [0, 0, 1, 0], [0, 0, 0, 1]])
"""The middle of a UR5e's flange, which is on it."""


def chain_of(*joints: tuple[str, str, tuple[float, float, float]]) -> SerialChain:
    """Return a chain of joints: R or P, the axis' name, and where each is from the one before, m."""
    count = len(joints)
    pre = np.tile(np.eye(4), (count, 1, 1))
    pre[:, :3, 3] = [place for _, _, place in joints]
    return SerialChain(
        pre,
        np.array([np.eye(3)["xyz".index(axis)] for _, axis, _ in joints]),
        np.array([REVOLUTE if kind == "R" else PRISMATIC for kind, _, _ in joints], np.int8),
        np.arange(count, dtype=np.int32),
        np.ones(count),
        np.zeros(count),
        np.eye(4),
        np.full(count, -np.inf),
        np.full(count, np.inf),
        tuple(f"joint {number}" for number in range(count)),
    )


# "DH Parameters for calculations of kinematics and dynamics", Universal Robots: UR5e; and a SCARA with a turning tool.
UR5E = chain_of(
    *[("R", "z", (0.0, 0.0, 0.0)), ("R", "y", (0.0, 0.0, 0.1625)), ("R", "y", (-0.425, 0.0, 0.0))],
    *[("R", "y", (-0.3922, 0.0, 0.0)), ("R", "z", (0.0, -0.1333, 0.0)), ("R", "y", (0.0, 0.0, -0.0997))],
)
SCARA = chain_of(
    *[("R", "z", (0.0, 0.0, 0.3)), ("R", "z", (0.35, 0.0, 0.0)), ("P", "z", (0.25, 0.0, 0.0))],
    ("R", "z", (0.0, 0.0, 0.0)),
)


@pytest.mark.parametrize(
    ("chain", "target", "poses", "points"),
    [(UR5E, OFF_AXIS, 30, 27), (UR5E, FLANGE, 30, 25), (SCARA, OFF_AXIS, 20, 17), (SCARA, np.eye(4), 20, 15)],
)
def test_so_many_errors_are_told_apart(
    rng: np.random.Generator, chain: SerialChain, target: np.ndarray, poses: int, points: int
) -> None:
    """4 R + 2 P + 6 by poses (Everett and Hsu 1988): 30 and 20.

    Of points, how the target is turned is not told: 3 less; and on the last axis neither that joint's zero nor where
    along a turn the target is: 2 less still.
    """
    errors = KinematicErrors(chain, target)
    postures = rng.uniform(-1.5, 1.5, (60, len(chain.axis)))
    assert errors.count == 6 * (len(chain.axis) + 1)
    assert errors.ranks(postures) == (poses, points)
    assert errors.fit(postures, errors.poses(np.zeros(errors.count), postures)[:, :3, 3]).rank == points


def test_slopes_are_finite_differences(rng: np.random.Generator) -> None:
    errors = KinematicErrors(SCARA, OFF_AXIS)
    at, postures, step = 0.1 * rng.normal(size=errors.count), rng.uniform(-1.0, 1.0, (3, 4)), 1e-6
    slopes = errors.slopes(at, postures)
    for number, change in enumerate(step * np.eye(errors.count)):
        first, last = errors.poses(at - change, postures), errors.poses(at + change, postures)
        assert slopes[:, :3, number] == pytest.approx((last - first)[:, :3, 3] / (2.0 * step), abs=1e-8)
        turned = (last - first)[:, :3, :3] / (2.0 * step) @ errors.poses(at, postures)[:, :3, :3].transpose(0, 2, 1)
        axes = np.stack([turned[:, 2, 1], turned[:, 0, 2], turned[:, 1, 0]], axis=1)
        assert slopes[:, 3:, number] == pytest.approx(axes, abs=1e-8)


def test_planted_errors_are_found(rng: np.random.Generator) -> None:
    """Errors of 0.5 mm and 2 mrad: without noise to nothing, with it to its size, in postures that nobody measured."""
    errors = KinematicErrors(UR5E, OFF_AXIS)
    planted = (rng.normal(size=(7, 6)) * np.repeat([0.5e-3, 2e-3], 3)).ravel()
    postures, unused = rng.uniform(-np.pi, np.pi, (100, 6)), rng.uniform(-np.pi, np.pi, (300, 6))
    points = errors.poses(planted, postures)[:, :3, 3]
    wanted = errors.poses(planted, unused)[:, :3, 3]

    def off(found: np.ndarray) -> np.ndarray:
        return np.linalg.norm(errors.poses(found, unused)[:, :3, 3] - wanted, axis=1)

    assert off(np.zeros(42)).mean() > 1e-3
    exact = errors.fit(postures, points)
    assert off(exact.parameters).max() < 1e-10 and exact.residuals.max() < 1e-12
    noise = 5e-5
    found = errors.fit(postures, points + noise * rng.normal(size=points.shape))
    # SSR / (3 n - rank) follows chi^2 / (3 n - rank): within four of its deviations.
    spare = 300 - found.rank
    assert abs((found.deviation / noise) ** 2 - 1.0) < 4.0 * np.sqrt(2.0 / spare)
    # The mean square of what is left is noise^2 rank / n for the postures that were used, and about that for others.
    assert off(found.parameters).mean() < 2.0 * noise * np.sqrt(found.rank / 100)
    assert found.covariance.shape == (42, 42) and found.condition < 100.0
