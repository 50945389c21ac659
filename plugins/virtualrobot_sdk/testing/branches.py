"""All solutions of a pose, found by brute force: Newton's method on the reference from many random starts at once.

It knows nothing of the arm's geometry, so it finds what a closed form may have forgotten. Solutions that differ by full
turns are one.
"""

from __future__ import annotations

import numpy as np

from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, Floats, SerialChain
from virtualrobot_sdk.reference import chain_frames

STARTS = 256
"""Number of random starts; each solution of an arm with 8 is met about 20 times or more."""
SAME = 1e-4
"""Postures closer than this (rad, m) are the same."""
_STEPS = 60
_LONGEST_STEP = 0.5
_CLOSED = 1e-9
_DAMPING = 1e-10
_SLACK = 1e-9


def all_solutions(chain: SerialChain, target: Floats, rng: np.random.Generator) -> Floats:
    """Return the postures (m, k) that put the tip at `target` (4, 4), within limits, each once.

    Each start takes Newton steps (J^T J + d 1) s = J^T e of at most 0.5 rad or m; J is the geometric Jacobian, e the
    distance and the rotation vector to the target.
    """
    lower, upper = _range(chain)
    q = rng.uniform(lower, upper, (STARTS, len(lower)))
    for _ in range(_STEPS):
        frames = chain_frames(chain, q)
        error = pose_errors(frames[:, -1], target)
        jacobian = geometric_jacobian(chain, frames)
        turned = jacobian.transpose(0, 2, 1)
        normal = turned @ jacobian + _DAMPING * np.eye(q.shape[1])
        step = np.linalg.solve(normal, turned @ error[..., None])[..., 0]
        longest = np.maximum(_LONGEST_STEP, np.abs(step).max(axis=1, keepdims=True))
        q = q + step * (_LONGEST_STEP / longest)
    errors = np.abs(pose_errors(chain_frames(chain, q)[:, -1], target)).max(axis=1)
    found: list[Floats] = []
    for posture in q[errors < _CLOSED]:
        inside = turned_within(chain, posture)
        if inside is not None and not any(same(chain, inside, other) for other in found):
            found.append(inside)
    return np.array(found).reshape(-1, len(lower))


def is_redundant(chain: SerialChain, q: Floats) -> bool:
    """Return whether the tip can rest at q while joints move, so that its pose has endlessly many solutions."""
    jacobian = geometric_jacobian(chain, chain_frames(chain, q[None]))[0]
    return bool(np.linalg.matrix_rank(jacobian, tol=1e-6) < len(q))


def same(chain: SerialChain, a: Floats, b: Floats) -> bool:
    """Return whether two postures (k,) are the same but for full turns."""
    difference = a - b
    turns = full_turns(chain)
    difference[turns] = (difference[turns] + np.pi) % (2.0 * np.pi) - np.pi
    return bool((np.abs(difference) < SAME).all())


def turned_within(chain: SerialChain, q: Floats) -> Floats | None:
    """Return q with full turns added that bring it within limits; None where none do."""
    turns = full_turns(chain)
    lower = np.where(np.isfinite(chain.lower), chain.lower, -np.inf)
    needed = np.where(q < lower - _SLACK, np.ceil((lower - _SLACK - q) / (2.0 * np.pi)), 0.0)
    needed = np.where(q > chain.upper + _SLACK, -np.ceil((q - chain.upper - _SLACK) / (2.0 * np.pi)), needed)
    turned = np.where(turns, q + 2.0 * np.pi * np.where(turns, needed, 0.0), q)
    inside = (turned >= lower - _SLACK) & (turned <= chain.upper + _SLACK)
    return np.clip(turned, chain.lower, chain.upper) if inside.all() else None


def full_turns(chain: SerialChain) -> np.ndarray:
    """Return for each coordinate (k,) whether a full turn of it changes no pose."""
    k = len(chain.joint_names)
    whole = (chain.joint_type == REVOLUTE) & (chain.multiplier == np.round(chain.multiplier))
    return np.array([whole[chain.q_index == i].all() for i in range(k)])


def pose_errors(poses: Floats, target: Floats) -> Floats:
    """Return what leads from poses (m, 4, 4) to the target: (m, 6), distance (m) and rotation vector (rad)."""
    turn = target[:3, :3] @ poses[:, :3, :3].transpose(0, 2, 1)
    skew = np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], -1)
    sine = np.linalg.norm(skew, axis=1)
    angle = np.arctan2(sine, np.trace(turn, axis1=1, axis2=2) - 1.0)
    scale = np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 0.5)
    return np.hstack([target[:3, 3] - poses[:, :3, 3], skew * scale[:, None]])


def geometric_jacobian(chain: SerialChain, frames: Floats) -> Floats:
    """Return the Jacobians (m, 6, k) of the tip, linear rows first, from the frames (m, n + 1, 4, 4) of m postures."""
    tip = frames[:, -1, :3, 3]
    jacobian = np.zeros((len(frames), 6, len(chain.joint_names)))
    for i, kind in enumerate(chain.joint_type):
        axis = frames[:, i, :3, :3] @ chain.axis[i] * chain.multiplier[i]
        column = jacobian[:, :, chain.q_index[i]]
        if kind == PRISMATIC:
            column[:, :3] += axis
        else:
            column[:, :3] += np.cross(axis, tip - frames[:, i, :3, 3])
            column[:, 3:] += axis
    return jacobian


def _range(chain: SerialChain) -> tuple[Floats, Floats]:
    """Return where starts are drawn from: a full turn for what turns, limits or 1 m to both sides for what slides."""
    turns = full_turns(chain)
    reach = np.where(turns, np.pi, 1.0)
    lower = np.where(turns | ~np.isfinite(chain.lower), -reach, chain.lower)
    upper = np.where(turns | ~np.isfinite(chain.upper), reach, chain.upper)
    return lower, np.maximum(lower, upper)
