"""Checks of the poses that motions are given."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.polynomial import Array


def check_pose(pose: Array, what: str) -> None:
    """Raise KernelError unless `pose` is a finite rigid transform (4, 4), to 1e-6."""
    if pose.shape != (4, 4) or not np.all(np.isfinite(pose)):
        raise KernelError(f"{what} must be a finite pose (4, 4), not {pose.tolist()}")
    rotation = pose[:3, :3]
    skewness = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if skewness > 1e-6 or np.linalg.det(rotation) < 0.0 or np.abs(pose[3] - (0.0, 0.0, 0.0, 1.0)).max() > 1e-9:
        raise KernelError(f"{what} must be a rigid transform; its rotation is off by {skewness:.3g}")


def check_poses(poses: Sequence[Array] | Array, what: str) -> None:
    """Raise KernelError, as `check_pose` does, that names the first one that is none by `what`, with its number."""
    if all(pose.shape == (4, 4) for pose in poses):
        found = np.array(poses)
        turns = found[:, :3, :3]
        skewness = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max()
        below = np.abs(found[:, 3] - (0.0, 0.0, 0.0, 1.0)).max()
        if np.isfinite(found).all() and skewness <= 1e-6 and below <= 1e-9 and np.linalg.det(turns).min() > 0.0:
            return
    for number, pose in enumerate(poses):
        check_pose(pose, what.format(number))
