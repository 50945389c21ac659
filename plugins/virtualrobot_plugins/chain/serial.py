"""Serial chains: the poses of their frames and their geometric Jacobian, compiled.

A chain is what lies between a base and a tip in the forest, with fixed joints folded into their neighbours. Its
independent coordinates are numbered 0 .. k-1; several joints may follow one coordinate (mimic).
"""

from __future__ import annotations

import numpy as np
from numba import float64, int8, int32
from virtualrobot_sdk.compiled.cache import array_of, compiled, output_of
from virtualrobot_sdk.compiled.serial import fill_jacobian, place_frames
from virtualrobot_sdk.kinematics import PRISMATIC, Codes, Floats, Integers, SerialChain

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
    place_frames(pre, axis, joint_type, q_index, multiplier, offset, post.reshape((1, 4, 4)), q, base_t_frame)


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
    fill_jacobian(axis, joint_type, q_index, multiplier, base_t_frame, 1.0, jacobian)


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
