"""Branches of an arm at many poses at once: each posture once, whatever full turns its limits allow besides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.kinematics import REVOLUTE, SerialChain
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.planning.actuators import actuator_limits
from virtualrobot_kernel.planning.robots import Arm, tip_t_tcp
from virtualrobot_kernel.planning.solvers import Solver
from virtualrobot_kernel.world.actuators import LIMIT_TOLERANCE
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]

SAME = 1e-9
"""Greatest difference of two postures that count as one, but for full turns (rad or m)."""


@dataclass(frozen=True, slots=True, eq=False)
class Branches:
    """Postures of an arm at n poses, m together.

    Attributes:
        target: (m,) which pose each is for, ascending.
        positions: (m, k) rad or m, within limits.
    """

    target: NDArray[np.int64]
    positions: Floats


def without_turns(arm: Arm) -> Arm:
    """Return the arm with joints that turn at most once round, so that each branch has one posture.

    Where limits are more than a turn apart, the turn in their middle is left: whatever angle there is, is in it.
    """
    chain = arm.serial()
    turning, lower, upper = _turning(chain), chain.lower.copy(), chain.upper.copy()
    wide = turning & np.isfinite(lower) & np.isfinite(upper) & (upper - lower > 2.0 * np.pi)
    middle = 0.5 * (lower[wide] + upper[wide])
    lower[wide], upper[wide] = middle - np.pi, middle + np.pi
    return replace(arm, chain=chain._replace(lower=lower, upper=upper))


def branches(
    snapshot: Snapshot, arm: Arm, world_t_tcp: Floats, solver_of: Callable[[Snapshot, Arm], Solver]
) -> Branches:
    """Return all branches that the component of an arm, one of `without_turns`, knows at poses (n, 4, 4).

    A component that searches, as for seven joints, knows few of them. Raises as `solver_of` and the component do.
    """
    chain, solver = arm.serial(), solver_of(snapshot, arm)
    base_t_tip = inverse(snapshot.world_t(arm.base)) @ world_t_tcp @ inverse(tip_t_tcp(snapshot, arm))
    target, positions = solver.inverse_many(base_t_tip)
    for limit in actuator_limits(snapshot, arm.robot, chain.joint_names):
        at, actuator = positions @ limit.ratios + limit.rest, limit.actuator
        within = (at >= actuator.lower - LIMIT_TOLERANCE) & (at <= actuator.upper + LIMIT_TOLERANCE)
        target, positions = target[within], positions[within]
    kept = _first_of_each(chain, target, positions)
    return Branches(target[kept], positions[kept])


def _first_of_each(chain: SerialChain, target: NDArray[np.int64], positions: Floats) -> NDArray[np.bool_]:
    """Return (m,) which postures are not one before them, turned: what lies on both ends of a turn comes twice."""
    kept = np.ones(len(positions), np.bool_)
    turning = _turning(chain)
    ends = np.minimum(np.abs(positions - chain.lower), np.abs(positions - chain.upper))[:, turning] < SAME
    for row in np.flatnonzero(ends.any(axis=1)).tolist():
        others = np.flatnonzero((target == target[row]) & kept)
        apart = positions[others[others < row]] - positions[row]
        apart[:, turning] -= 2.0 * np.pi * np.round(apart[:, turning] / (2.0 * np.pi))
        kept[row] = not (np.abs(apart) < SAME).all(axis=1).any()
    return kept


def _turning(chain: SerialChain) -> NDArray[np.bool_]:
    """Return (k,) which coordinates turn one joint alone, as it is."""
    found = np.zeros(len(chain.joint_names), np.bool_)
    for coordinate in range(len(found)):
        joints = chain.q_index == coordinate
        found[coordinate] = (
            joints.sum() == 1 and (chain.joint_type[joints] == REVOLUTE).all() and (chain.multiplier[joints] == 1).all()
        )
    return found
