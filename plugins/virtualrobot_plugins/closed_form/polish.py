"""Angles that almost reach a pose, made to reach it: by Newton steps, from poses close by where it is singular."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_plugins.closed_form.library import Angles

_CLOSE = 1e-4
"""How far the poses close by are away (m, rad)."""


def polished(
    chain: ChainKinematics,
    angles: Angles,
    target: Floats,
    seed: Floats,
    limits: Floats,
    close_by: bool,
) -> Floats:
    """Return EAIK's angles of the target (4, 4), each polished or left out: (n, branches).

    With `close_by` also those of poses close by, and what the seed (n,) leads to: at a singular pose EAIK may find
    none, and of the endlessly many postures those near the seed and within limits (2, n) are wanted.
    """
    starts = [*np.ascontiguousarray(angles(target).T)]
    if close_by:
        for pose in _poses_around(target):
            starts.extend(np.ascontiguousarray(angles(pose).T))
        starts.append(seed)
    # Whatever a descent ends at is a solution, far or near: next to a straight wrist joints 4 and 6 are far off.
    ends = [chain.refined(target, start) for start in starts if np.isfinite(start).all()]
    found = [q for q in ends if q is not None]
    if close_by:
        # Along the postures of a singular pose there may be some within limits where this one is not.
        inside = [chain.refined(target, np.clip(_turned(q, seed), *limits), within=True) for q in found]
        found.extend(q for q in inside if q is not None)
    return np.ascontiguousarray(np.array(found).reshape(-1, len(seed)).T)


def _turned(q: Floats, seed: Floats) -> Floats:
    return q + 2.0 * np.pi * np.round((seed - q) / (2.0 * np.pi))


def _poses_around(target: Floats) -> list[Floats]:
    """Return six poses around a pose: each a small shift along an axis of the base and a turn about another."""
    poses = []
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1.0, 1.0):
            turn = np.eye(4)
            turn[i, i] = turn[j, j] = np.cos(_CLOSE)
            turn[j, i] = sign * np.sin(_CLOSE)
            turn[i, j] = -turn[j, i]
            pose = target @ turn
            pose[i, 3] += sign * _CLOSE
            poses.append(pose)
    return poses
