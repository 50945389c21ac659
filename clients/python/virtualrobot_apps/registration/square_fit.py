"""Pose of a square by where its corners are in a picture, and by what is up, in weighted least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot.geometry import Matrix, rotation_from_vector

Floats = NDArray[np.float64]

_MOST_STEPS = 50
_MOST_HALVINGS = 10
_SETTLED = 1e-11
"""Length of a step (rad, m) from which a fit has come to its end."""


@dataclass(frozen=True, slots=True, eq=False)
class Gravity:
    """Direction of up: `marker_up` (3,) and `camera_up` (3,), of length 1, and the standard deviation `tilt`, rad."""

    marker_up: Floats
    camera_up: Floats
    tilt: float


@dataclass(frozen=True, slots=True, eq=False)
class SeenSquare:
    """Square as a camera without distortion sees it.

    Attributes:
        square: (4, 3) the corners in the marker's frame, m.
        corners: (4, 2) where they were seen, pixels.
        camera: (3, 3) the camera's matrix.
    """

    square: Floats
    corners: Floats
    camera: Floats

    def off(self, pose: Matrix) -> Floats:
        """Return how far the corners (4, 2) were seen from where they are for a pose (4, 4), pixels."""
        at = (self.square @ pose[:3, :3].T + pose[:3, 3]) @ self.camera.T
        return self.corners - at[:, :2] / at[:, 2:]

    def deviation(self, pose: Matrix) -> float:
        """Return the root of the mean square of how far the corners are off, pixels."""
        return float(np.sqrt(np.mean(np.sum(self.off(pose) ** 2, axis=1))))

    def slopes(self, pose: Matrix) -> Floats:
        """Return how the corners' places change, (8, 6), by a small turn about the camera and a shift.

        Of (u, v) = (fx x / z, fy y / z).
        """
        at = self.square @ pose[:3, :3].T + pose[:3, 3]
        x, y, z = at.T
        places = np.zeros((4, 2, 3))
        places[:, 0, 0], places[:, 0, 2] = self.camera[0, 0] / z, -self.camera[0, 0] * x / z**2
        places[:, 1, 1], places[:, 1, 2] = self.camera[1, 1] / z, -self.camera[1, 1] * y / z**2
        return np.concatenate([slope @ moved(point) for slope, point in zip(places, at, strict=True)])

    def fit(self, pose: Matrix, good: float, gravity: Gravity | None = None) -> tuple[Matrix, Floats]:
        """Return the pose near this one that fits best, and the covariance (6, 6) of its turn and shift.

        By Gauss and Newton, with shorter steps where a whole one leads away. `good` is the standard deviation of each
        coordinate of a corner, pixels.
        """
        off, equations = self._rows(pose, good, gravity)
        for _ in range(_MOST_STEPS):
            step = np.asarray(np.linalg.lstsq(equations, off, rcond=None)[0], dtype=float)
            for _ in range(_MOST_HALVINGS):
                there = _motion(step) @ pose
                off_there, equations_there = self._rows(there, good, gravity)
                if off_there @ off_there <= off @ off:
                    pose, off, equations = there, off_there, equations_there
                    break
                step = step / 2.0
            else:
                break
            if np.abs(step).max() < _SETTLED:
                break
        return pose, np.asarray(np.linalg.inv(equations.T @ equations), dtype=float)

    def _rows(self, pose: Matrix, good: float, gravity: Gravity | None) -> tuple[Floats, Floats]:
        """Return what is left over (m,) and how it changes (m, 6), in standard deviations."""
        off, equations = self.off(pose).ravel() / good, self.slopes(pose) / good
        if gravity is None:
            return off, equations
        is_up, level = pose[:3, :3] @ gravity.marker_up, np.linalg.svd(gravity.camera_up[None])[2][1:]
        turns = np.hstack([np.cross(is_up, level), np.zeros((2, 3))])
        leaning = level @ (gravity.camera_up - is_up)
        return (
            np.concatenate([off, leaning / gravity.tilt]),
            np.concatenate([equations, turns / gravity.tilt]),
        )


def moved(at: Floats) -> Floats:
    """Return how a point (3,) moves, (3, 6), by a small turn about the origin and a shift."""
    x, y, z = at
    return np.hstack([[[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]], np.eye(3)])


def _motion(step: Floats) -> Matrix:
    """Return the pose (4, 4) of a turn about an axis by its length (rad), and a shift."""
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = rotation_from_vector(step[:3]), step[3:]
    return motion
