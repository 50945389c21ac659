"""Serial chains, compiled into the functions that call this: the poses of their frames and their geometric Jacobian.

The arrays are those of `virtualrobot_sdk.kinematics.SerialChain`; several joints may follow one coordinate (mimic).
"""

from __future__ import annotations

from virtualrobot_sdk.compiled.cache import inlined
from virtualrobot_sdk.compiled.rigid import copy, multiply, shift, turn
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, Codes, Floats, Integers


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
    """Write the poses of the n joint frames, each after its own joint, and of the tip to `base_t_frame` (n + 1, 4, 4).

    `post` is (1, 4, 4): the tip in the frame of the last joint; `q` holds the independent coordinates.
    """
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
    multiply(base_t_frame, n - 1, post, 0, base_t_frame, n)


@inlined
def fill_jacobian(
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    base_t_frame: Floats,
    weight: float,
    jacobian: Floats,
) -> None:
    """Write the geometric Jacobian (6, k) at the tip from the frames that `place_frames` made, base frame.

    Rows 0-2 are linear, times `weight`, rows 3-5 angular. Source: Siciliano et al., Robotics: Modelling, Planning and
    Control, 2009, equation 3.30.
    """
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
            jacobian[0, j] += factor * weight * zx
            jacobian[1, j] += factor * weight * zy
            jacobian[2, j] += factor * weight * zz
        else:
            px = base_t_frame[n, 0, 3] - base_t_frame[i, 0, 3]
            py = base_t_frame[n, 1, 3] - base_t_frame[i, 1, 3]
            pz = base_t_frame[n, 2, 3] - base_t_frame[i, 2, 3]
            jacobian[0, j] += factor * weight * (zy * pz - zz * py)
            jacobian[1, j] += factor * weight * (zz * px - zx * pz)
            jacobian[2, j] += factor * weight * (zx * py - zy * px)
            jacobian[3, j] += factor * zx
            jacobian[4, j] += factor * zy
            jacobian[5, j] += factor * zz
