"""The forward pass of a serial chain in plain NumPy, short enough to be checked by reading: the judge of components.

q may be a stack (..., k) of postures; the result is a stack of the same shape.
"""

from __future__ import annotations

import numpy as np

from virtualrobot_sdk.kinematics import PRISMATIC, Floats, SerialChain


def chain_frames(chain: SerialChain, q: Floats) -> Floats:
    """Return the poses (..., n + 1, 4, 4) of each joint's frame, moved by the joint, and of the tip, in the base."""
    values = chain.multiplier * q[..., chain.q_index] + chain.offset
    pose = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
    frames = []
    for i, pre in enumerate(chain.pre):
        pose = pose @ pre @ joint_motion(int(chain.joint_type[i]), chain.axis[i], values[..., i])
        frames.append(pose)
    return np.stack([*frames, pose @ chain.post], axis=-3)


def tip_pose(chain: SerialChain, q: Floats) -> Floats:
    """Return the pose (..., 4, 4) of the tip in the base."""
    return chain_frames(chain, q)[..., -1, :, :]


def joint_motion(joint_type: int, axis: Floats, value: Floats) -> Floats:
    """Return the motion (..., 4, 4) of a joint about or along its unit `axis` (3,) by `value` (...) in rad or m.

    The rotation is O. Rodrigues' formula: 1 + sin(value) K + (1 - cos(value)) K^2 with K v = axis x v.
    """
    motion = np.zeros((*np.shape(value), 4, 4)) + np.eye(4)
    value = np.asarray(value)[..., None]
    if joint_type == PRISMATIC:
        motion[..., :3, 3] = value * axis
        return motion
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    motion[..., :3, :3] += np.sin(value)[..., None] * cross + (1.0 - np.cos(value))[..., None] * (cross @ cross)
    return motion
