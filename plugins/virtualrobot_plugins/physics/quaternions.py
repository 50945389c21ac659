"""Motion of poses x, y, z and a quaternion x, y, z, w by their velocities."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.kinematics import Floats


def backwards(poses: Floats, twists: Floats, seconds: float) -> Floats:
    """Return where poses (k, 7) were some seconds ago, their velocities (k, 6) constant.

    The linear one is in the axes of the world, the angular one in those of the body.
    """
    before = poses.copy()
    before[:, :3] -= twists[:, :3] * seconds
    half = -0.5 * seconds * twists[:, 3:]
    angle = np.linalg.norm(half, axis=1, keepdims=True)
    turn = half * np.sinc(angle / np.pi)
    # q * exp(turn): what is turned about its own axes is multiplied from the right.
    w, vector = poses[:, 6:], poses[:, 3:6]
    before[:, 3:6] = w * turn + np.cos(angle) * vector + np.cross(vector, turn)
    before[:, 6] = w[:, 0] * np.cos(angle)[:, 0] - np.einsum("ki,ki->k", vector, turn)
    return before
