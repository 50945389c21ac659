"""Subproblems of closed forms, in NumPy: angles by which axes turn vectors to where they belong.

(B. Paden, Kinematics and Control Robot Manipulators, 1986; R. M. Murray, Z. Li, S. S. Sastry, A Mathematical
Introduction to Robotic Manipulation, 1994, chapter 3.2.)
"""

from __future__ import annotations

import numpy as np

from virtualrobot_sdk.kinematics import Floats, SerialChain
from virtualrobot_sdk.reference import chain_frames


def axes_of(chain: SerialChain) -> tuple[Floats, Floats, Floats]:
    """Return directions and points (k, 3) of an arm's axes at position 0, and the pose (4, 4) of its tip there."""
    frames = chain_frames(chain, np.zeros(len(chain.joint_names)))
    return np.einsum("nij,nj->ni", frames[:-1, :3, :3], chain.axis), frames[:-1, :3, 3], frames[-1]


def crossing(a: Floats, b: Floats, c: Floats | float, sense: Floats) -> Floats:
    """Return q with a cos q + b sin q = c, of two values the one of a sense; NaN where there is none."""
    part = c / np.hypot(a, b)
    near = np.where(np.abs(part) < 1.0 + 1e-12, np.clip(part, -1.0, 1.0), np.nan)
    return np.arctan2(b, a) + sense * np.arccos(near)


def turned(axis: Floats, angle: Floats, v: Floats) -> Floats:
    """Return vectors (..., 3) turned about a unit axis by angles (...) (Rodrigues' formula)."""
    sine, cosine = np.sin(angle)[..., None], np.cos(angle)[..., None]
    return v * cosine + np.cross(axis, v) * sine + axis * ((1.0 - cosine) * np.sum(axis * v, axis=-1)[..., None])


def angle_about(axis: Floats, a: Floats, b: Floats) -> Floats:
    """Return the angles (...) about an axis by which what is across it of a turns to that of b."""
    return np.arctan2(np.cross(a, b) @ axis, np.sum(a * b, axis=-1) - (a @ axis) * (b @ axis))
