"""Angles that almost reach a pose, made to reach it: by Newton steps, from poses close by where it is singular."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from virtualrobot_sdk.kinematics import REVOLUTE, Floats
from virtualrobot_sdk.reference import joint_motion

from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_plugins.closed_form.library import Angles
from virtualrobot_plugins.closed_form.model import FIXED, Model

_CLOSE = 1e-4
"""Distance and angle from the target to the poses close by (m, rad)."""
_BARELY = 1e-5
"""The sine of a wrist's bend below which EAIK may take it for straight, and more."""


def polished(
    chain: ChainKinematics,
    angles: Angles,
    target: Floats,
    seed: Floats,
    limits: Floats,
    close_by: Model | None = None,
) -> Floats:
    """Return EAIK's angles of the target (4, 4), each polished or left out: (n, branches).

    With `close_by`, the arm's model, also those of poses close by, and what the seed (n,) leads to: at a singular pose
    EAIK may find none, and of the endlessly many postures those near the seed and within limits (2, n) are wanted.
    """
    starts = [*np.ascontiguousarray(angles(target).T)]
    if close_by:
        for pose in _poses_around(target):
            starts.extend(np.ascontiguousarray(angles(pose).T))
        starts.extend(_bent(chain, angles, target, close_by))
        starts.append(seed)
    # Whatever a descent ends at is a solution, far or near: next to a straight wrist joints 4 and 6 are far off.
    ends = [chain.refined(target, start) for start in starts if np.isfinite(start).all()]
    found = [q for q in ends if q is not None]
    if close_by:
        # Along the postures of a singular pose there may be some within limits where this one is not.
        inside = [chain.refined(target, np.clip(_turned(q, seed), *limits), within=True) for q in found]
        found.extend(q for q in inside if q is not None)
    return np.ascontiguousarray(np.array(found).reshape(-1, len(seed)).T)


def _bent(chain: ChainKinematics, angles: Angles, target: Floats, model: Model) -> Iterator[Floats]:
    """Yield angles next to those of a target (4, 4) whose wrist is all but straight.

    EAIK takes such a wrist for straight and knows joints 4 and 6 only together; which of the endlessly many pairs it is
    the direction of the little bend tells. With the target turned about the wrist's centre the axes before it stay, so
    they are those of the target with its wrist bent by `_CLOSE` more in that direction, with joint 5 bent back.
    """
    if not model.kind & FIXED:
        return
    tip_t_centre, last_axis = model.numbers[7:10], target[:3, :3] @ model.numbers[10:13]

    def turned(axis: Floats) -> list[Floats]:
        """Return the angles of the target turned about the wrist's centre by `_CLOSE` about an axis (3,)."""
        turn = joint_motion(REVOLUTE, axis / np.linalg.norm(axis), np.array(_CLOSE))
        pose = target.copy()
        pose[:3, :3] = turn[:3, :3] @ target[:3, :3]
        pose[:3, 3] += (target[:3, :3] - pose[:3, :3]) @ tip_t_centre
        return [q for q in np.ascontiguousarray(angles(pose).T) if np.isfinite(q).all()]

    for rough in turned(np.eye(3)[np.abs(last_axis).argmin()]):
        axis = chain.jacobian(rough)[3:, 3]
        bend = np.cross(axis, last_axis) * np.sign(axis @ last_axis)
        if not 0.0 < np.linalg.norm(bend) < _BARELY:
            continue
        for q in turned(bend):
            if np.linalg.norm(np.cross(*chain.jacobian(q)[3:, 3::2].T)) < 2.0 * _CLOSE:
                for back in (-_CLOSE, _CLOSE):
                    yield np.array([*q[:4], q[4] + back, q[5]])


def _turned(q: Floats, seed: Floats) -> Floats:
    return q + 2.0 * np.pi * np.round((seed - q) / (2.0 * np.pi))


def _poses_around(target: Floats) -> list[Floats]:
    """Return six poses around a pose: each a small shift along an axis of the base and a turn about another."""
    poses = []
    for i, axis in enumerate(np.eye(3)):
        for sign in (-1.0, 1.0):
            pose = target @ joint_motion(REVOLUTE, axis, np.array(sign * _CLOSE))
            pose[(i + 1) % 3, 3] += sign * _CLOSE
            poses.append(pose)
    return poses
