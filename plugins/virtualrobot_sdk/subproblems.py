"""Subproblems of closed forms, in NumPy: angles by which axes turn vectors to where they belong.

(B. Paden, Kinematics and Control Robot Manipulators, 1986; R. M. Murray, Z. Li, S. S. Sastry, A Mathematical
Introduction to Robotic Manipulation, 1994, chapter 3.2.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from virtualrobot_sdk.kinematics import Floats, SerialChain
from virtualrobot_sdk.reference import chain_frames


def axes_of(chain: SerialChain) -> tuple[Floats, Floats, Floats]:
    """Return directions and points (k, 3) of an arm's axes at position 0, and the pose (4, 4) of its tip there."""
    frames = chain_frames(chain, np.zeros(len(chain.joint_names)))
    return np.einsum("nij,nj->ni", frames[:-1, :3, :3], chain.axis), frames[:-1, :3, 3], frames[-1]


def meeting(h: Floats, p: Floats) -> tuple[Floats, float]:
    """Return where on the first of some axes (n, 3) through points (n, 3) the second is nearest, the two not parallel.

    And by how much (m) any of them passes that place.
    """
    normal = np.cross(h[0], h[1])
    place = p[0] + h[0] * float(np.cross(p[1] - p[0], h[1]) @ normal) / float(normal @ normal)
    return place, max(float(np.linalg.norm(np.cross(place - point, axis))) for point, axis in zip(p, h, strict=True))


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


def last_three(h: Floats, rotated: Callable[[Floats], Floats], senses: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the angles by which three axes (3, 3), one after the other, make a rotation, of two values each.

    Args:
        h: directions of the axes at position 0.
        rotated: returns what the rotation makes of a vector (3,).
        senses: (2,) of the two values, as of `crossing`.

    Returns:
        The three angles, and how far the axes are from one plane then, with the sense of the second angle; 0 where they
        are in one.
    """
    first, second, third = h
    axis = rotated(third)
    along = float(first @ second) * float(second @ third)
    even, odd = float(first @ third) - along, float(first @ np.cross(second, third))
    middle = crossing(np.array(even), np.array(odd), axis @ first - along, senses)
    begin = angle_about(first, turned(second, middle, third), axis)
    mark = second - float(second @ third) * third
    end = angle_about(third, mark, turned(second, -middle, turned(first, -begin, rotated(mark))))
    return begin, middle, end, odd * np.cos(middle) - even * np.sin(middle)


def eight_postures(joints: Sequence[Floats], clear: Floats) -> tuple[Floats, Floats]:
    """Return postures (m, 8, 6) in -pi to pi of six joints, each by poses and three choices of two, as (m, 2, 2, 2).

    They are NaN where one of the joints is. And (m, 8) what is `clear` there, 0 where there is no posture.
    """
    *each, spread = np.broadcast_arrays(*joints, clear)
    found = np.stack(each, axis=-1).reshape(len(spread), 8, 6)
    found = np.where(np.isfinite(found).all(axis=2, keepdims=True), found, np.nan)
    found = found - 2.0 * np.pi * np.round(found / (2.0 * np.pi))
    return found, np.where(np.isfinite(found[..., 0]), spread.reshape(-1, 8), 0.0)
