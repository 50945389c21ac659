"""Inverse kinematics of positions alone: joints for many points, however the tool centre point is turned there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.kinematics import PRISMATIC, InverseStatus, SerialChain
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.numeric.points import REACHED, follow_points
from virtualrobot_kernel.planning.robots import arm_of, joint_vector, tip_t_tcp
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node

RESTARTS = 40
"""Number of postures, drawn within limits, that a point is tried from where its neighbour's and the seed fail."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PointPostures:
    """Joints of an arm (m, k) for the first m of its points: all of them where it is SOLVED."""

    status: InverseStatus
    joint_names: tuple[str, ...]
    positions: Floats
    position_error: float
    """Distance (m) of the best attempt from the first point that is not reached; 0 where all are."""
    reason: str
    """The point that is not reached, and why; empty where all are."""


def solve_points(
    snapshot: Snapshot,
    robot: Node,
    points: Floats,
    reference: int,
    seed: Mapping[str, float],
    group: Group = WHOLE,
) -> PointPostures:
    """Return joints within limits that bring the tool centre point of a group to `points` (n, 3), one after the other.

    Points are in m in the frame of the node `reference` (uid), where it stands now. The first is solved from `seed`,
    joints that it does not name as they are now, each other one from the one before. Equal questions give equal
    answers.

    Raises:
        UnknownNameError: for a joint that the robot has not.
        LimitError: for a seed outside limits.
        KernelError: when no joint moves the end of the group.
    """
    arm = arm_of(snapshot, robot, group)
    chain = arm.serial()
    chain = chain._replace(post=np.ascontiguousarray(chain.post @ tip_t_tcp(snapshot, arm)))
    base_t_reference = inverse(snapshot.world_t(arm.base)) @ snapshot.world_t(reference)
    places = np.ascontiguousarray(points @ base_t_reference[:3, :3].T + base_t_reference[:3, 3])
    start = joint_vector(snapshot, arm, seed)
    positions, error = _followed(chain, places, start, respect_limits=True)
    missed = np.flatnonzero(~(error < REACHED))
    if not len(missed):
        return PointPostures(InverseStatus.SOLVED, arm.joint_names, positions, 0.0, "")
    row = int(missed[0])
    before = positions[row - 1] if row else start
    free, free_error = _followed(chain, places[row : row + 1], before, respect_limits=False)
    off = float(error[row])
    reason = f"the point {row} is not reached: the best posture within limits is off by {1e3 * off:.3g} mm"
    status = InverseStatus.UNREACHABLE
    if free_error[0] < REACHED:
        status = InverseStatus.OUTSIDE_LIMITS
        outside = np.flatnonzero((free[0] < chain.lower) | (free[0] > chain.upper))
        reason += "; outside limits it is reached, for instance with " + ", ".join(
            f"{chain.joint_names[i]!r} at {free[0, i]:.4f} ({chain.lower[i]:.4f} to {chain.upper[i]:.4f})"
            for i in outside
        )
    return PointPostures(status, arm.joint_names, positions[:row], off, reason)


def _followed(chain: SerialChain, places: Floats, start: Floats, respect_limits: bool) -> tuple[Floats, Floats]:
    """Return the postures (m, k) for places (m, 3) in the chain's base, and how far each is off (m,), in m."""
    sliding = np.zeros(len(start), np.bool_)
    sliding[chain.q_index[chain.joint_type == PRISMATIC]] = True
    # The stroke of a sliding joint always counts.
    counts = respect_limits | sliding
    lower, upper = np.where(counts, chain.lower, -np.inf), np.where(counts, chain.upper, np.inf)
    half = np.where(sliding, 1.0, np.pi)
    # Where there is no limit, around where the joint is.
    first, last = np.maximum(lower, start - half), np.minimum(upper, start + half)
    bounded = np.isfinite(lower) & np.isfinite(upper)
    first, last = np.where(bounded, lower, first), np.where(bounded, upper, last)
    drawn = np.random.default_rng(0).uniform(size=(RESTARTS, len(start)))
    starts = np.vstack([start, first + (last - first) * drawn])
    lengths = np.linalg.norm(chain.pre[1:, :3, 3], axis=1).sum() + np.linalg.norm(chain.post[:3, 3])
    positions, error = np.empty((len(places), len(start))), np.empty(len(places))
    post, weight = chain.post[None], 1.0 / max(float(lengths), 1e-3)
    follow_points(*chain[:6], post, weight, lower, upper, places, starts, positions, error)
    return positions, error
