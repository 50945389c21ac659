"""Reference of the null-space motion along a path, by objectives with a gradient too rough or dear for each step.

The joints go along the path once in long steps, and the objective is asked after each. What it does in the null space,
with its edges rounded off, is a smooth function of the place on the path, which the exact path then follows.
"""

from __future__ import annotations

from collections.abc import Callable
from math import ceil

import numpy as np

from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.nullspace import SecondaryObjective, projected
from virtualrobot_kernel.motion.path import smooth_path
from virtualrobot_kernel.motion.polynomial import Array

STEP = (0.02, 0.08)
"""Step along the path: m of its length, rad of its turn; longer where that would be too many steps."""
GAIN = 2.0
"""Greatest motion in the null space, as a multiple of the motion that the path itself needs."""
_FEWEST, _MOST = 8, 200
_ROUNDS = 4
"""Number of times that each motion is averaged with those beside it."""
_CLOSED = 1e-6

Pose = Callable[[Array], Array]
Jacobian = Callable[[Array], Array]


def nullspace_reference(
    pose: Pose,
    jacobian: Jacobian,
    weights: Array,
    tcp_path: CartesianPath,
    q_start: Array,
    objective: SecondaryObjective,
) -> Callable[[float], Array]:
    """Return the function of the joints' motion (k,) per path that an objective asks for at u in [0, 1].

    It is smooth in u, and is to be projected into the null space. Where the arm cannot follow the path any more it is
    0; whoever follows it exactly says why.

    Args:
        pose: gives base_t_tcp (4, 4) at joints (k,).
        jacobian: gives the Jacobian (6, k) of the tool centre point.
        weights: (6,) that make its rows comparable.
        tcp_path: the path.
        q_start: where the joints are at its beginning (k,).
        objective: what leads them.
    """
    count = min(max(_FEWEST, ceil(tcp_path.length / STEP[0]), ceil(tcp_path.angle / STEP[1])), _MOST)
    places, q = np.linspace(0.0, 1.0, count + 1), q_start
    motions: list[Array] = []
    for u in places:
        if motions:
            onto = _onto(pose, jacobian, weights, tcp_path, u, q)
            if onto is None:
                break
            q = onto
        weighted = jacobian(q) * weights[:, None]
        rate = np.linalg.lstsq(weighted, tcp_path.twist(u) * weights, rcond=1e-9)[0]
        # Of the gradient itself a small part may be left in the null space: how long that part is, is what counts.
        way = projected(weighted, -objective(q)[1])
        motions.append(GAIN * float(np.linalg.norm(rate)) / np.sqrt(1.0 + way @ way) * way)
        q = q + (rate + motions[-1]) / count
    if len(motions) < 2:
        return lambda u: np.zeros_like(q_start)
    rounded = np.array(motions)
    for _ in range(_ROUNDS):
        beside = np.concatenate([rounded[:1], rounded, rounded[-1:]])
        rounded = 0.25 * beside[:-2] + 0.5 * rounded + 0.25 * beside[2:]
    end = float(places[len(motions) - 1])
    curve = smooth_path(places[: len(motions)], rounded, None)
    return lambda u: curve.evaluate(u) if 0.0 <= u <= end else np.zeros_like(q_start)


def _onto(pose: Pose, jacobian: Jacobian, weights: Array, tcp_path: CartesianPath, u: float, q: Array) -> Array | None:
    """Return joints on the path at `u`, by Newton steps from `q`; None where these lead nowhere near."""
    for _ in range(8):
        off = tcp_path.deviation(u, pose(q))
        if np.abs(off).max() < _CLOSED:
            return q
        q = q + np.linalg.lstsq(jacobian(q) * weights[:, None], off * weights, rcond=1e-9)[0]
        if not np.isfinite(q).all():
            return None
    return None
