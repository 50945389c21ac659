"""Rotations and transforms of VRML97."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import rotation_matrix

from virtualrobot_plugins.importers.vrml.fields import Bound


def rotation(axis_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrix (3, 3) for an axis of any length and an angle in radians."""
    length = float(np.linalg.norm(axis_angle[:3]))
    if length == 0.0:
        return np.eye(3)
    return rotation_matrix(axis_angle[3] / length * axis_angle[:3])


def transform_matrix(node: Bound) -> NDArray[np.float64]:
    """Return the matrix (4, 4) of a Transform: T C R SR S -SR -C (ISO/IEC 14772-1, 6.52)."""
    center = node.numbers("center", (0.0, 0.0, 0.0), 3)
    turn = rotation(node.numbers("rotation", (0.0, 0.0, 1.0, 0.0), 4))
    scale = node.numbers("scale", (1.0, 1.0, 1.0), 3)
    scale_turn = rotation(node.numbers("scaleOrientation", (0.0, 0.0, 1.0, 0.0), 4))
    linear = turn @ scale_turn @ np.diag(scale) @ scale_turn.T
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = node.numbers("translation", (0.0, 0.0, 0.0), 3) + center - linear @ center
    return matrix


def texture_matrix(node: Bound) -> NDArray[np.float64]:
    """Return the matrix (3, 3) of a TextureTransform: -C S R C T (ISO/IEC 14772-1, 6.49)."""
    center = node.numbers("center", (0.0, 0.0), 2)
    scale = node.numbers("scale", (1.0, 1.0), 2)
    angle = node.number("rotation", 0.0)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    linear = np.diag(scale) @ turn
    matrix = np.eye(3)
    matrix[:2, :2] = linear
    matrix[:2, 2] = linear @ (center + node.numbers("translation", (0.0, 0.0), 2)) - center
    return matrix
