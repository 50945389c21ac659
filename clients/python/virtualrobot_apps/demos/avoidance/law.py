"""The control law of avoidance: a tool follows its pose while an arm with joints to spare keeps away from obstacles.

Equations 1 to 4 of "A Robotics Framework for Planning the Offshore Robotizing Using Virtual Reality Techniques"
(SimUEP-Robotics, OTC Brasil 2013) as pure functions, with their symbols:

    u = J_w# [K_p E_p + x_d' + V_r; K_o E_o + w_d] + alpha (I - J_w# J) W^-1 grad H         (1)
    U = k_r/gamma (1/eta - 1/eta_0)^gamma  where eta <= eta_0, else 0                       (2)
    grad H = sum of grad U over points of the robot and obstacles                           (3)
    grad U = -k_r/eta^2 (1/eta - 1/eta_0)^(gamma - 1) grad eta                              (4)

The paper prints (4) without the minus, which is the force, not the gradient; since its alpha is negative, the arm would
go to the obstacles. All is in the world's frame: meters, radians, seconds; k is the count of joints.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot.geometry import quaternion_of

Floats = NDArray[np.float64]


def weighted_pseudo_inverse(jacobian: Floats, weights: Floats, damping: float = 0.0) -> Floats:
    """Return J_w# (k, m) of J (m, k): W^-1 J^T (J W^-1 J^T + damping I)^-1, with J J_w# = I where damping is 0.

    Of all joint velocities u with J u = v it gives the one with the least u^T W u (D. Whitney, Resolved motion rate
    control, 1969). weights: the diagonal of W (k,), above 0. A damping above 0 keeps it small near singularities.
    """
    spread = jacobian.T / np.asarray(weights)[:, None]
    return spread @ np.linalg.inv(jacobian @ spread + damping * np.eye(len(jacobian)))


def null_projector(jacobian: Floats, inverse: Floats) -> Floats:
    """Return I - J_w# J (k, k): what is left of joint velocities that does not move the tool."""
    return np.eye(jacobian.shape[1]) - inverse @ jacobian


def damping_of(jacobian: Floats, near: float = 0.05, most: float = 0.01) -> float:
    """Return the damping of a Jacobian (m, k): 0, but near singularities up to `most`.

    Y. Nakamura, H. Hanafusa, J. Dynamic Systems, Measurement, and Control 108(3), 1986, with the least singular value
    as the measure: it begins where that is `near`.
    """
    least = float(np.linalg.svd(jacobian, compute_uv=False)[-1])
    return most * max(0.0, 1.0 - least / near) ** 2


def limit_weights(q: Floats, going: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return the diagonal of W (k,): 1, for joints that go to a limit ever more, without end at the limit.

    T. Chan, R. Dubey, A weighted least-norm solution based scheme for avoiding joint limits, IEEE Trans. Robotics and
    Automation 11(2), 1995: 1 + |dH/dq| of H = (upper - lower)^2 / (4 (upper - q) (q - lower)).

    Args:
        q: (k,) positions of the joints.
        going: (k,) their velocities.
        lower: (k,) limits; joints without one (-inf) always have 1.
        upper: (k,) likewise.
    """
    limited = np.isfinite(lower) & np.isfinite(upper)
    low, high = np.where(limited, lower, -1.0), np.where(limited, upper, 1.0)
    margin = 1e-3 * (high - low)
    place = np.where(limited, np.clip(q, low + margin, high - margin), 0.0)
    slope = (high - low) ** 2 * (2.0 * place - high - low) / (4.0 * (high - place) ** 2 * (place - low) ** 2)
    return 1.0 + np.where(limited & (slope * going > 0.0), np.abs(slope), 0.0)


def position_error(world_t_tcp: Floats, world_t_desired: Floats) -> Floats:
    """Return E_p (3,): from where the tool is to where it shall be, both (4, 4)."""
    return world_t_desired[:3, 3] - world_t_tcp[:3, 3]


def orientation_error(world_t_tcp: Floats, world_t_desired: Floats) -> Floats:
    """Return E_o (3,): axis times sine of half the angle from the tool's orientation to the wanted one, both (4, 4).

    The vector part of the unit quaternion (B. Siciliano et al., Robotics, 2009, 3.7.3); right up to a full half turn.
    """
    return quaternion_of(world_t_desired[:3, :3] @ world_t_tcp[:3, :3].T)[:3]


def repulsive_velocity(
    points: Floats, obstacles: Floats, reach: float, greatest: float, steepness: float = 6.0
) -> Floats:
    """Return V_r (3,): the velocity with which a tool gives way to obstacles.

    F. Flacco, T. Kröger, A. De Luca, O. Khatib, A depth space approach to human-robot collision avoidance, ICRA 2012:
    its size is `greatest` / (1 + exp((2 d / reach - 1) steepness)) for the least distance d, its direction that of the
    sum of such vectors from all obstacles.

    Args:
        points: (n, 3) on the tool, each the nearest to an obstacle.
        obstacles: (n, 3) the nearest points of the obstacles.
        reach: distance (m) below which obstacles count.
        greatest: the size near contact (m/s).
        steepness: slope of its growth about half the reach, without unit.
    """
    away = points - obstacles
    distances = np.linalg.norm(away, axis=1)
    counted = (distances <= reach) & (distances > 1e-9)
    if not counted.any():
        return np.zeros(3)
    away, distances = away[counted], distances[counted]
    sizes = greatest / (1.0 + np.exp((2.0 * distances / reach - 1.0) * steepness))
    total = (sizes / distances) @ away
    length = float(np.linalg.norm(total))
    return sizes.max() * total / length if length > 1e-9 else np.zeros(3)


def potential(eta: Floats, eta_0: float, k_r: float, gamma: float = 2.0) -> Floats:
    """Return U (n,) of equation 2 for distances eta (n,): 0 from the range of influence eta_0 on."""
    eta = np.asarray(eta, float)
    near = np.minimum(eta, eta_0)
    return k_r / gamma * (1.0 / near - 1.0 / eta_0) ** gamma


def potential_slope(eta: Floats, eta_0: float, k_r: float, gamma: float = 2.0) -> Floats:
    """Return dU/d eta (n,), at most 0: the factor of grad eta in equation 4."""
    near = np.minimum(np.asarray(eta, float), eta_0)
    return -k_r / near**2 * (1.0 / near - 1.0 / eta_0) ** (gamma - 1.0)


def distance_gradients(points: Floats, obstacles: Floats, jacobians: Floats) -> Floats:
    """Return grad eta (n, k): how distances grow with joints.

    Args:
        points: (n, 3) on the robot, each the nearest to an obstacle.
        obstacles: (n, 3) the nearest points of the obstacles, which joints do not move.
        jacobians: (n, 3, k) linear rows of the points' Jacobians.
    """
    away = points - obstacles
    distances = np.linalg.norm(away, axis=1, keepdims=True)
    normals = away / np.where(distances > 1e-9, distances, 1.0)
    return np.einsum("ni,nik->nk", normals, jacobians)


def subtask_gradient(
    eta: Floats, eta_gradients: Floats, eta_0: float, k_r: float, gamma: float = 2.0, least: float = 0.05
) -> Floats:
    """Return grad H (k,) of equation 3 for n distances (n,) and their gradients (n, k).

    Distances below `least` (m) count as that: there is no end to the potential's slope.
    """
    return potential_slope(np.maximum(eta, least), eta_0, k_r, gamma) @ eta_gradients


def joint_velocities(
    jacobian: Floats, weights: Floats, task: Floats, gradient: Floats, alpha: float, limits: Floats
) -> Floats:
    """Return u (k,) of equation 1, kept within limits (k,).

    Velocities that are too great are scaled down: first the part in the null space, so that the tool goes its way as
    long as it can; then all of it, so that it goes in its direction.

    Args:
        jacobian: J (6, k) of the tool.
        weights: the diagonal of W (k,).
        task: (6,) the tool's wanted velocity, K_p E_p + x_d' + V_r above K_o E_o + w_d.
        gradient: grad H (k,).
        alpha: below 0.
        limits: the greatest velocities (k,).
    """
    inverse = weighted_pseudo_inverse(jacobian, weights, damping_of(jacobian))
    tool = inverse @ task
    tool /= max(1.0, float((np.abs(tool) / limits).max()))
    free = alpha * null_projector(jacobian, inverse) @ (gradient / weights)
    room = np.where(free > 0.0, limits - tool, limits + tool)
    moving = np.abs(free) > 1e-12
    return tool + free * min(1.0, float((room[moving] / np.abs(free[moving])).min(initial=1.0)))
