"""Null-space motion of an arm's redundant joints: secondary objectives, and the motion that follows them.

An objective is a function from joints to a cost, the less the better, and its gradient. Where the tool centre point
stands or goes, joints move by (I - J^+ J) z with z against the gradient (A. Liegeois, Automatic supervisory control of
the configuration and behavior of multibody mechanisms, IEEE Trans. Systems, Man and Cybernetics 7(12), 1977).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from virtualrobot_kernel.motion.polynomial import Array

SecondaryObjective = Callable[[Array], tuple[float, Array]]
"""Cost (without unit) of joints (k,) and its gradient (k,), both smooth inside the joints' limits."""

Near = Callable[[Array], tuple[Array, Array]]
"""Distances (n,) in m of an arm at joints (k,) from obstacles near it, and their gradients (n, k)."""

DISTANCE_RANGE = 0.3
"""Distance (m) below which obstacles count."""
_DISTANCE_SIZE = 0.005
_LEAST_DISTANCE = 0.05
_LIMITS_SHARE = 0.02

GAIN = 1.0
"""Greatest motion in the null space on a path, as a multiple of the motion that the path itself needs."""
_NEAREST = 0.999
"""Share of the way from the middle (0) to a limit (1) on which the cost of limits grows; beyond, its gradient stays."""
_DIFFERENCE = 1e-5
_STEPS = 200
_LONGEST_STEP = 0.2
_SHORTEST_STEP = 1e-6
_CLOSED = 1e-10


def joint_limit_clearance(lower: Array, upper: Array) -> SecondaryObjective:
    """Return the objective of joints amid their ranges (k,): the sum of -log(1 - x^2), x from -1 to 1 in each.

    Joints that lack a limit do not count.
    """
    counted = np.isfinite(lower) & np.isfinite(upper) & (upper > lower)
    middle = np.where(counted, (np.where(counted, lower, 0.0) + np.where(counted, upper, 0.0)) / 2.0, 0.0)
    half = np.where(counted, (np.where(counted, upper, 2.0) - np.where(counted, lower, 0.0)) / 2.0, 1.0)

    def objective(q: Array) -> tuple[float, Array]:
        x = np.where(counted, np.clip((q - middle) / half, -_NEAREST, _NEAREST), 0.0)
        return float(-np.log(1.0 - x * x).sum()), 2.0 * x / (1.0 - x * x) / half

    return objective


def manipulability(jacobian: Callable[[Array], Array]) -> SecondaryObjective:
    """Return the objective of manipulability w, the product of the Jacobian's singular values: the cost is -log(w).

    T. Yoshikawa, Manipulability of robotic mechanisms, Int. J. Robotics Research 4(2), 1985. `jacobian` gives (6, k) at
    joints (k,), its linear rows in lengths that compare with radians; the gradient is by central differences.
    """

    def cost(q: Array) -> float:
        return -float(np.log(np.maximum(np.linalg.svd(jacobian(q), compute_uv=False), 1e-9)).sum())

    def objective(q: Array) -> tuple[float, Array]:
        steps = _DIFFERENCE * np.eye(len(q))
        return cost(q), np.array([(cost(q + step) - cost(q - step)) / (2.0 * _DIFFERENCE) for step in steps])

    return objective


def posture_distance(posture: Array) -> SecondaryObjective:
    """Return the objective of a posture (k,), NaN where a joint has none: half the sum of squared offsets (rad, m)."""
    wanted = np.isfinite(posture)

    def objective(q: Array) -> tuple[float, Array]:
        off = np.where(wanted, q - np.where(wanted, posture, 0.0), 0.0)
        return float(off @ off) / 2.0, off

    return objective


@dataclass(frozen=True, slots=True, eq=False)
class NonsmoothObjective:
    """Objective whose gradient has edges or takes long: a path asks it at few places (`nullspace_reference`)."""

    objective: SecondaryObjective

    def __call__(self, q: Array) -> tuple[float, Array]:
        """Return cost and gradient (k,) at joints (k,)."""
        return self.objective(q)


def obstacle_clearance(near: Near, lower: Array, upper: Array) -> NonsmoothObjective:
    """Return the objective of distance from obstacles, and a little from joints' limits (k,), so as to stay off both.

    The cost is the sum of size/2 (1/d - 1/range)^2 over distances d within the range (O. Khatib, Real-time obstacle
    avoidance for manipulators and mobile robots, Int. J. Robotics Research 5(1), 1986). Nearest points jump from one
    part of a shape to another, hence the edges.
    """
    limits = joint_limit_clearance(lower, upper)

    def objective(q: Array) -> tuple[float, Array]:
        cost, gradient = limits(q)
        distances, gradients = near(q)
        d = np.clip(distances, _LEAST_DISTANCE, DISTANCE_RANGE)
        rest = 1.0 / d - 1.0 / DISTANCE_RANGE
        total = _LIMITS_SHARE * cost + _DISTANCE_SIZE * float(rest @ rest) / 2.0
        return total, _LIMITS_SHARE * gradient - _DISTANCE_SIZE * (rest / d**2) @ gradients

    return NonsmoothObjective(objective)


def free_motion(jacobian: Array, rate: Array, objective: SecondaryObjective, q: Array) -> Array:
    """Return the motion of joints (k,) in the null space of a Jacobian (m, k) while the task moves them by `rate` (k,).

    It is along the path as `rate` is, never faster than GAIN times it, and smooth where that is smooth and not 0.
    """
    gradient = objective(q)[1]
    speed = GAIN * np.linalg.norm(rate) / np.sqrt(1.0 + gradient @ gradient)
    return projected(jacobian, -speed * gradient)


def improved(
    jacobian: Callable[[Array], Array],
    deviation: Callable[[Array], Array],
    q: Array,
    objective: SecondaryObjective,
    lower: Array,
    upper: Array,
) -> Array:
    """Return the joints (k,) that an objective leads to from `q` (k,), which solves a pose, while the pose stays.

    Steps against the gradient in the null space, each put back onto the pose by Newton steps and kept within limits
    (k,), until the cost does not fall any more: a local best. `jacobian` gives (6, k), `deviation` the twist (6,) from
    joints to the pose; the pose is met to 1e-10.
    """
    cost, gradient = objective(q)
    step = _LONGEST_STEP
    for _ in range(_STEPS):
        way = projected(jacobian(q), -gradient)
        length = float(np.linalg.norm(way))
        if length < 1e-9:
            break
        while step > _SHORTEST_STEP:
            tried = _put_back(jacobian, deviation, q + way * min(1.0, step / length))
            if tried is not None and ((tried >= lower) & (tried <= upper)).all():
                after, downhill = objective(tried)
                if after < cost - 1e-12:
                    break
            step *= 0.5
        else:
            break
        q, cost, gradient = tried, after, downhill
        step = min(_LONGEST_STEP, 2.0 * step)
    return q


def _put_back(jacobian: Callable[[Array], Array], deviation: Callable[[Array], Array], q: Array) -> Array | None:
    """Return joints that Newton steps lead to from `q`, on the pose; None where they lead nowhere near."""
    start = q
    for _ in range(8):
        off = deviation(q)
        if np.abs(off).max() < _CLOSED:
            return q
        q = q + np.linalg.lstsq(jacobian(q), off, rcond=1e-9)[0]
        if not np.abs(q - start).max() < _LONGEST_STEP:
            return None
    return None


def projected(jacobian: Array, vector: Array) -> Array:
    """Return (I - J^+ J) times a vector (k,)."""
    return vector - np.linalg.lstsq(jacobian, jacobian @ vector, rcond=1e-9)[0]
