"""Fits: poses that are planted are found, what measurements can't tell is named, errors are as large as they say.

What is planted is drawn; the rigid fit is also compared with scipy's `Rotation.align_vectors`.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.fitting import fit, pivot_fit, rigid_fit


def drawn_pose(rng: np.random.Generator) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    pose[:3, 3] = rng.uniform(-2.0, 2.0, 3)
    return pose


def test_a_planted_pose_is_found(rng: np.random.Generator) -> None:
    pose, points = drawn_pose(rng), rng.normal(size=(6, 3))
    found = rigid_fit(points, points @ pose[:3, :3].T + pose[:3, 3])
    np.testing.assert_allclose(found, pose, atol=1e-12)


def test_noise_and_mirrored_points_give_the_rotation_of_scipy(rng: np.random.Generator) -> None:
    for targets in (rng.normal(size=(5, 3)), np.diag([1.0, 1.0, -1.0])):
        points = rng.normal(size=(len(targets), 3)) if len(targets) > 3 else np.eye(3)
        expected = Rotation.align_vectors(targets - targets.mean(axis=0), points - points.mean(axis=0))[0]
        found = rigid_fit(points, targets)
        np.testing.assert_allclose(found[:3, :3], expected.as_matrix(), atol=1e-9)
        assert np.linalg.det(found[:3, :3]) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("points", "said"),
    [(np.eye(3)[:2], "2 points don't determine"), (np.outer(range(5), [1.0, 2.0, 3.0]), "on a line")],
)
def test_too_few_points_and_those_on_a_line_are_refused(points: np.ndarray, said: str) -> None:
    with pytest.raises(KernelError, match=said):
        rigid_fit(points, points)


def test_a_tip_that_is_planted_is_found_and_one_axis_is_too_few(rng: np.random.Generator) -> None:
    tip, point = rng.uniform(-0.2, 0.2, 3), rng.uniform(-1.0, 1.0, 3)
    flanges = np.array([drawn_pose(rng) for _ in range(5)])
    flanges[:, :3, 3] = point - flanges[:, :3, :3] @ tip
    found = pivot_fit(flanges)
    np.testing.assert_allclose(found.parameters, [*tip, *point], atol=1e-10)
    assert found.residuals.max() < 1e-10
    flanges[:, :3, :3] = Rotation.from_euler("z", rng.uniform(-3.0, 3.0, (5, 1))).as_matrix()
    with pytest.raises(KernelError, match="doesn't determine tip z, point z"):
        pivot_fit(flanges)


def test_standard_errors_are_as_large_as_the_spread_of_repeated_fits(rng: np.random.Generator) -> None:
    """Of 400 fits of one tip, each with noise of 0.1 mm, the spread is the error that the fits tell, to 20%."""
    tip = np.array([0.02, -0.03, 0.15])
    flanges = np.array([drawn_pose(rng) for _ in range(8)])
    exact = -flanges[:, :3, :3] @ tip
    tips, errors = [], []
    for _ in range(400):
        flanges[:, :3, 3] = exact + rng.normal(scale=1e-4, size=(8, 3))
        found = pivot_fit(flanges)
        tips.append(found.parameters[:3])
        errors.append(found.errors[:3])
    np.testing.assert_allclose(np.std(tips, axis=0), np.sqrt(np.mean(np.square(errors), axis=0)), rtol=0.2)


def test_a_fit_that_is_not_linear_comes_to_what_is_planted(rng: np.random.Generator) -> None:
    """A point on a circle of unknown radius, phase and height."""
    at = rng.uniform(0.0, 6.0, 12)
    planted = np.array([1.3, 0.4, -0.2])

    def circle(parameters: np.ndarray) -> np.ndarray:
        radius, phase, height = parameters
        return np.stack([radius * np.cos(at + phase), radius * np.sin(at + phase), np.full(12, height)], axis=1)

    def residuals(parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        steps = [(circle(parameters + step) - circle(parameters - step)) / 2e-6 for step in 1e-6 * np.eye(3)]
        return circle(parameters) - circle(planted), np.stack(steps, axis=2)

    found = fit(residuals, np.array([1.0, 0.0, 0.0]), ("radius", "phase", "height"))
    np.testing.assert_allclose(found.parameters, planted, atol=1e-9)
