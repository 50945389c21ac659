"""The control law of avoidance, formula by formula."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_apps.demos.avoidance import law

ARM, TASK = 7, 6


def manipulability(rng: np.random.Generator) -> np.ndarray:
    """Return a Jacobian (6, 7) whose singular values are those of no damping; of normal numbers 1 in 120 has others."""
    left, _, right = np.linalg.svd(rng.normal(size=(TASK, ARM)), full_matrices=False)
    return left @ np.diag(rng.uniform(0.2, 2.0, TASK)) @ right


def test_the_weighted_pseudo_inverse_is_a_right_inverse_of_least_norm(rng: np.random.Generator) -> None:
    """J J_w# = I, and of all u with J u = v it gives the least u^T W u: any part of the null space makes that more."""
    for _ in range(20):
        jacobian, weights, v = manipulability(rng), rng.uniform(0.5, 20.0, ARM), rng.normal(size=TASK)
        inverse = law.weighted_pseudo_inverse(jacobian, weights)
        np.testing.assert_allclose(jacobian @ inverse, np.eye(TASK), atol=1e-9)
        u = inverse @ v
        other = u + law.null_projector(jacobian, inverse) @ rng.normal(size=ARM)
        assert u @ (weights * u) <= other @ (weights * other)
        same = law.weighted_pseudo_inverse(jacobian, 3.0 * np.ones(ARM))
        np.testing.assert_allclose(same, np.linalg.pinv(jacobian), atol=1e-9)


def test_a_heavy_joint_moves_less(rng: np.random.Generator) -> None:
    """By 1 + (w - 1) n0^2, with n the unit vector that moves nothing: the least of w q0^2 + q1^2 + ... on q + s n."""
    jacobian, v = manipulability(rng), rng.normal(size=TASK)
    light, heavy = (law.weighted_pseudo_inverse(jacobian, np.array([w, *[1.0] * 6])) @ v for w in (1.0, 1e3))
    free = np.linalg.svd(jacobian)[2][-1]
    assert heavy[0] == pytest.approx(light[0] / (1.0 + (1e3 - 1.0) * free[0] ** 2), rel=1e-6, abs=1e-9)


def test_the_null_projector_annihilates_the_task(rng: np.random.Generator) -> None:
    """J (I - J_w# J) = 0, and the projector is idempotent, of rank 7 - 6."""
    jacobian, weights = manipulability(rng), rng.uniform(0.5, 20.0, ARM)
    projector = law.null_projector(jacobian, law.weighted_pseudo_inverse(jacobian, weights))
    np.testing.assert_allclose(jacobian @ projector, 0.0, atol=1e-9)
    np.testing.assert_allclose(projector @ projector, projector, atol=1e-9)
    assert np.trace(projector) == pytest.approx(1.0)


def test_damping_begins_near_singularities_and_bounds_velocities(rng: np.random.Generator) -> None:
    """Nakamura and Hanafusa: 0 from the threshold on, the most at a singularity; then |J#| <= 1 / (2 sqrt(damping))."""
    left, _, right = np.linalg.svd(rng.normal(size=(TASK, ARM)), full_matrices=False)
    for least, expected in ((0.05, 0.0), (0.2, 0.0), (0.025, 0.01 * 0.25), (0.0, 0.01)):
        jacobian = left @ np.diag([1.0, 0.9, 0.8, 0.7, 0.6, least]) @ right
        damping = law.damping_of(jacobian)
        assert damping == pytest.approx(expected, abs=1e-12)
        inverse = law.weighted_pseudo_inverse(jacobian, np.ones(ARM), damping) if damping else np.zeros((ARM, TASK))
        assert np.linalg.norm(inverse, 2) <= max(0.5 / np.sqrt(damping or 1.0), 1.0 / 0.6 + 1e-9)


def test_weights_grow_only_for_joints_that_go_to_a_limit() -> None:
    """Chan and Dubey: half the way from the middle to a limit of +-2 the slope of 16/(4 (4 - q^2)) is 8/9."""
    lower, upper = np.array([-2.0, -2.0, -2.0, -2.0, -np.inf]), np.array([2.0, 2.0, 2.0, 2.0, np.inf])
    q, going = np.array([1.0, 1.0, -1.0, 0.0, 50.0]), np.array([0.1, -0.1, -0.1, 0.1, 0.1])
    found = law.limit_weights(q, going, lower, upper)
    np.testing.assert_allclose(found, [1.0 + 8.0 / 9.0, 1.0, 1.0 + 8.0 / 9.0, 1.0, 1.0])
    near = [law.limit_weights(np.array([at]), np.ones(1), lower[:1], upper[:1])[0] for at in (1.5, 1.9, 1.99)]
    assert near == sorted(near) and near[-1] > 1e3


def turned(axis: np.ndarray, angle: float) -> np.ndarray:
    cross = np.cross(np.eye(3), axis)
    pose = np.eye(4)
    pose[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return pose


def test_errors_of_position_and_orientation(rng: np.random.Generator) -> None:
    """Rodrigues' formula makes the turns; the error is the axis times sin(angle / 2), up to a half turn."""
    for angle in (1e-9, 0.3, 1.5, 3.0, np.pi):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        start = turned(np.array([0.6, 0.0, 0.8]), 0.7)
        start[:3, 3] = rng.normal(size=3)
        wanted = turned(axis, angle) @ start
        found = law.orientation_error(start, wanted)
        if angle == np.pi:  # to either side
            found *= np.sign(found @ axis)
        np.testing.assert_allclose(found, np.sin(angle / 2.0) * axis, atol=1e-8)
        np.testing.assert_allclose(law.position_error(start, wanted), wanted[:3, 3] - start[:3, 3])


def test_the_repulsive_velocity_at_its_thresholds(rng: np.random.Generator) -> None:
    """Flacco: half the greatest at half the reach; 1 / (1 + e^-6) of it at contact, 1 / (1 + e^6) at the reach."""
    away = rng.normal(size=3)
    away /= np.linalg.norm(away)
    obstacle = rng.normal(size=(1, 3))
    for distance, size in ((0.1, 0.25), (1e-8, 0.5 / (1.0 + np.exp(-6.0))), (0.2, 0.5 / (1.0 + np.exp(6.0)))):
        found = law.repulsive_velocity(obstacle + (distance - 1e-12) * away, obstacle, 0.2, 0.5)
        np.testing.assert_allclose(found, size * away, rtol=1e-4)
    assert not law.repulsive_velocity(obstacle + 0.2001 * away, obstacle, 0.2, 0.5).any()
    assert not law.repulsive_velocity(np.zeros((0, 3)), np.zeros((0, 3)), 0.2, 0.5).any()


def test_the_repulsive_velocity_of_several_obstacles() -> None:
    """The size is that of the nearest, the direction that of the sum; obstacles on both sides cancel."""
    tool, side = np.zeros((2, 3)), np.array([[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]])
    np.testing.assert_allclose(law.repulsive_velocity(tool, side, 0.2, 0.5), -0.25 * np.array([1.0, 1.0, 0.0]) / 2**0.5)
    assert not law.repulsive_velocity(tool, np.array([[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0]]), 0.2, 0.5).any()


def test_the_potential_and_its_slope() -> None:
    """Equation 2 with gamma 2: k_r/2 (1/eta - 1/eta_0)^2; 0 from eta_0 on; the slope is its derivative."""
    eta = np.array([0.05, 0.1, 0.2, 0.29, 0.3, 0.31, 1.0])
    found = law.potential(eta, 0.3, 0.004)
    np.testing.assert_allclose(found[1], 0.002 * (10.0 - 1.0 / 0.3) ** 2)
    assert not found[4:].any() and (np.diff(found[:5]) < 0.0).all()
    for gamma in (2.0, 3.0):
        up, down = (law.potential(eta + step, 0.3, 0.004, gamma) for step in (1e-6, -1e-6))
        slope = law.potential_slope(eta, 0.3, 0.004, gamma)
        np.testing.assert_allclose(slope[:4], (up - down)[:4] / 2e-6, rtol=1e-4)
        assert not slope[4:].any() and (slope <= 0.0).all()


def test_the_gradient_is_that_of_the_sum_of_potentials(rng: np.random.Generator) -> None:
    """Points p = p_0 + J dq near fixed obstacles: the sum of potentials of |p - o| by central differences."""
    points, jacobians = rng.normal(size=(4, 3)), rng.normal(size=(4, 3, ARM))
    obstacles = points + rng.uniform(0.06, 0.14, (4, 1)) * rng.normal(size=(4, 3))

    def total(dq: np.ndarray) -> float:
        return float(law.potential(np.linalg.norm(points + jacobians @ dq - obstacles, axis=1), 0.3, 0.004).sum())

    eta = np.linalg.norm(points - obstacles, axis=1)
    gradients = law.distance_gradients(points, obstacles, jacobians)
    found = law.subtask_gradient(eta, gradients, 0.3, 0.004, least=1e-6)
    steps = 1e-6 * np.eye(ARM)
    np.testing.assert_allclose(found, [(total(step) - total(-step)) / 2e-6 for step in steps], rtol=1e-3, atol=1e-6)


def test_the_subtask_moves_links_away_and_leaves_the_tool_alone(rng: np.random.Generator) -> None:
    """With alpha below 0 distances grow by the subtask, and J u is the task's velocity whatever the subtask is."""
    for _ in range(20):
        jacobian, gradients = manipulability(rng), rng.normal(size=(1, ARM))
        weights, task = rng.uniform(1.0, 5.0, ARM), 0.1 * rng.normal(size=TASK)
        gradient = law.subtask_gradient(np.array([0.1]), gradients, 0.3, 0.001)
        limits = np.full(ARM, 100.0)
        off, on = (law.joint_velocities(jacobian, weights, task, gradient, alpha, limits) for alpha in (0.0, -1.0))
        np.testing.assert_allclose(jacobian @ on, task, atol=1e-8)
        assert gradients[0] @ (on - off) > 0.0


def test_what_is_too_fast_is_slower_in_its_direction(rng: np.random.Generator) -> None:
    """The null space gives way first; the task keeps its direction."""
    jacobian, weights = manipulability(rng), np.ones(ARM)
    task, gradient, limits = rng.normal(size=TASK), rng.normal(size=ARM), np.full(ARM, 0.05)
    slow = law.joint_velocities(jacobian, weights, task, 1e6 * gradient, -1.0, limits)
    assert (np.abs(slow) <= limits + 1e-12).all()
    moved = jacobian @ slow
    np.testing.assert_allclose(moved / np.linalg.norm(moved), task / np.linalg.norm(task), atol=1e-6)
    u = law.joint_velocities(jacobian, weights, 1e-3 * task, 1e6 * gradient, -1.0, limits)
    assert (np.abs(u) <= limits + 1e-12).all() and np.abs(u).max() == pytest.approx(0.05)
    np.testing.assert_allclose(jacobian @ u, 1e-3 * task, atol=1e-6)
