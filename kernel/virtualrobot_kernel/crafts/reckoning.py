"""Odometry: the way of a craft reckoned from where its drives were, one after the other, and how sure that is.

The covariance grows as R. Siegwart and I. Nourbakhsh have it (Introduction to Autonomous Mobile Robots, equations 5.7
to 5.11): the errors of drives are independent, and the variance of each goes with how far it has turned.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.crafts.craft import CraftAtWork

Floats = NDArray[np.float64]

SHIFT = 1e-5
"""Shift (rad, m) of a drive by which it is asked how far the base goes with it."""


def reckoned(
    craft: CraftAtWork, begin: Floats, positions: Floats, covariance: Floats, variance_per_radian: float
) -> tuple[Floats, Floats]:
    """Return the poses (n, 3) of a base and their covariances (n, 3, 3): x, y (m) and heading (rad), unwrapped.

    Args:
        craft: whose component it is reckoned by.
        begin: (3,) the first pose.
        positions: (n, m) of the drives' joints (rad or m), one row after the other; between two of them drives go
            evenly, and the base on an arc.
        covariance: (3, 3) of the first pose.
        variance_per_radian: variance of what a drive is thought to have turned for each radian that it turns (rad).

    Raises KernelError with what the component does wrong.
    """
    states = positions / craft.drives.ratio
    poses, covariances = [begin], [covariance]
    for before, after in pairwise(states):
        pose, spread = poses[-1], covariances[-1]
        change = after - before
        if not change.any():
            poses.append(pose)
            covariances.append(spread)
            continue
        gone = _gone(craft, before, change)
        cosine, sine = math.cos(pose[2]), math.sin(pose[2])
        turned = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        step = turned @ gone
        poses.append(pose + step)
        by_pose = np.array([[1.0, 0.0, -step[1]], [0.0, 1.0, step[0]], [0.0, 0.0, 1.0]])
        spread = by_pose @ spread @ by_pose.T
        if variance_per_radian:
            columns = [
                (_gone(craft, before, change + shift) - _gone(craft, before, change - shift)) / (2.0 * SHIFT)
                for shift in np.eye(len(change)) * SHIFT
            ]
            by_drives = turned @ np.column_stack(columns)
            spread = spread + by_drives @ np.diag(variance_per_radian * np.abs(change)) @ by_drives.T
        covariances.append(spread)
    return np.array(poses), np.array(covariances)


def _gone(craft: CraftAtWork, states: Floats, change: Floats) -> Floats:
    """Return how far a base goes forward and to the left (m), and turns (rad), seen from where it was."""
    pose, _ = craft.stepped(craft.base_t_center, states, change, 1.0)
    base = pose @ craft.center_t_base
    return np.array([base[0, 3], base[1, 3], math.atan2(base[1, 0], base[0, 0])])
