"""Serial chains: the poses of their frames and their geometric Jacobian, compiled.

A chain is what lies between a base and a tip in the forest, with fixed joints folded into their neighbours. Its
independent coordinates are numbered 0 .. k-1; several joints may follow one coordinate (mimic).
"""

from __future__ import annotations

import numpy as np
from numba import float64, int8, int32
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.compiled.rigid import copy, multiply, shift, turn
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, Codes, Floats, Integers, SerialChain

JOINT_TYPES = (
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(int8, 1),
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 2),
)
"""numba types of the first seven fields of `SerialChain`, `pre` to `post`."""


@inlined
def place_frames(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    q: Floats,
    base_t_frame: Floats,
) -> None:
    """Do what `chain_frames` does, inside compiled code."""
    n = pre.shape[0]
    for i in range(n):
        if i == 0:
            copy(pre, 0, base_t_frame, 0)
        else:
            multiply(base_t_frame, i - 1, pre, i, base_t_frame, i)
        value = multiplier[i] * q[q_index[i]] + offset[i]
        if joint_type[i] == REVOLUTE:
            turn(base_t_frame, i, axis[i, 0], axis[i, 1], axis[i, 2], value)
        else:
            shift(base_t_frame, i, axis[i, 0] * value, axis[i, 1] * value, axis[i, 2] * value)
    multiply(base_t_frame, n - 1, post.reshape((1, 4, 4)), 0, base_t_frame, n)


@inlined
def fill_jacobian(
    axis: Floats, joint_type: Codes, q_index: Integers, multiplier: Floats, base_t_frame: Floats, jacobian: Floats
) -> None:
    """Write the geometric Jacobian (6, k) at the tip from the frames that `place_frames` made."""
    n = axis.shape[0]
    jacobian[:, :] = 0.0
    for i in range(n):
        ax = axis[i, 0]
        ay = axis[i, 1]
        az = axis[i, 2]
        zx = base_t_frame[i, 0, 0] * ax + base_t_frame[i, 0, 1] * ay + base_t_frame[i, 0, 2] * az
        zy = base_t_frame[i, 1, 0] * ax + base_t_frame[i, 1, 1] * ay + base_t_frame[i, 1, 2] * az
        zz = base_t_frame[i, 2, 0] * ax + base_t_frame[i, 2, 1] * ay + base_t_frame[i, 2, 2] * az
        j: int = q_index[i]
        factor = multiplier[i]
        if joint_type[i] == PRISMATIC:
            jacobian[0, j] += factor * zx
            jacobian[1, j] += factor * zy
            jacobian[2, j] += factor * zz
        else:
            px = base_t_frame[n, 0, 3] - base_t_frame[i, 0, 3]
            py = base_t_frame[n, 1, 3] - base_t_frame[i, 1, 3]
            pz = base_t_frame[n, 2, 3] - base_t_frame[i, 2, 3]
            jacobian[0, j] += factor * (zy * pz - zz * py)
            jacobian[1, j] += factor * (zz * px - zx * pz)
            jacobian[2, j] += factor * (zx * py - zy * px)
            jacobian[3, j] += factor * zx
            jacobian[4, j] += factor * zy
            jacobian[5, j] += factor * zz


@compiled(
    *JOINT_TYPES,
    array_of(float64, 1),
    output_of(float64, 3),
)
def _chain_frames(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    q: Floats,
    base_t_frame: Floats,
) -> None:
    place_frames(pre, axis, joint_type, q_index, multiplier, offset, post, q, base_t_frame)


@compiled(
    array_of(float64, 2),
    array_of(int8, 1),
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 3),
    output_of(float64, 2),
)
def _chain_jacobian(
    axis: Floats, joint_type: Codes, q_index: Integers, multiplier: Floats, base_t_frame: Floats, jacobian: Floats
) -> None:
    fill_jacobian(axis, joint_type, q_index, multiplier, base_t_frame, jacobian)


def chain_frames(chain: SerialChain, q: Floats) -> Floats:
    """Return the poses of the n joint frames, each after its own joint, and of the tip, in the base: (n + 1, 4, 4).

    `q` is (k,) float64; its length is trusted.
    """
    frames = np.empty((len(chain.pre) + 1, 4, 4))
    _chain_frames(*chain[:7], q, frames)
    return frames


def chain_jacobian(chain: SerialChain, q: Floats) -> Floats:
    """Return the geometric Jacobian (6, k) at the tip: rows 0-2 linear (m), rows 3-5 angular (rad), in the base frame.

    Source: Siciliano et al., Robotics: Modelling, Planning and Control, 2009, equation 3.30.
    """
    jacobian = np.empty((6, len(chain.lower)))
    _chain_jacobian(chain.axis, chain.joint_type, chain.q_index, chain.multiplier, chain_frames(chain, q), jacobian)
    return jacobian


def reach_bound(chain: SerialChain) -> tuple[Floats, float]:
    """Return a centre (3,) in the base frame and a radius (m) around it that the tip never leaves.

    The centre is the first joint's origin; the radius is the sum of all offsets after it and of the largest strokes,
    so it holds for any joint values within limits but is reached only by a straight arm.
    """
    strokes = 0.0
    for i in np.flatnonzero(chain.joint_type == PRISMATIC):
        ends = chain.multiplier[i] * np.array([chain.lower[chain.q_index[i]], chain.upper[chain.q_index[i]]])
        strokes += float(np.max(np.abs(ends + chain.offset[i])))
    offsets = np.linalg.norm(chain.pre[1:, :3, 3], axis=1).sum() + np.linalg.norm(chain.post[:3, 3])
    return chain.pre[0, :3, 3].copy(), float(offsets) + strokes
