"""Off-axis frusta: what a wall shows is what one would see through it, were it a window.

By R. Kooima, Generalized Perspective Projection, 2009: a wall is given by three corners, and the frustum goes from the
eye through its edges, however it stands. All is in one frame, m.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix

Floats = NDArray[np.float64]

SQUARE = 1e-3
"""Cosine of the angle between a wall's edges up to which it is a rectangle."""


@dataclass(frozen=True, slots=True, eq=False)
class Wall:
    """Flat rectangle on which a picture is shown, by three corners (3,), m, as those see it who stand before it."""

    name: str
    lower_left: Floats
    lower_right: Floats
    upper_left: Floats

    def __post_init__(self) -> None:
        """Refuse a wall that is no rectangle."""
        across, upwards = self.lower_right - self.lower_left, self.upper_left - self.lower_left
        lengths = np.linalg.norm(across), np.linalg.norm(upwards)
        if not np.isfinite([*across, *upwards]).all() or min(lengths) < 1e-6:
            raise InvalidArgumentError(f"the wall {self.name!r} has no width or no height; its corners are three")
        cosine = float(across @ upwards / (lengths[0] * lengths[1]))
        if abs(cosine) > SQUARE:
            raise InvalidArgumentError(
                f"the wall {self.name!r} is no rectangle: its edges at the lower left make an angle of "
                f"{math.degrees(math.acos(cosine)):.2f} degrees"
            )

    @property
    def corners(self) -> Floats:
        """All corners (4, 3), m: lower left, lower right, upper left, upper right."""
        opposite = self.lower_right + self.upper_left - self.lower_left
        return np.stack([self.lower_left, self.lower_right, self.upper_left, opposite])

    @property
    def axes(self) -> Floats:
        """Rotation (3, 3), columns: to the right, upwards, and out of the wall to those who look at it."""
        right, up = self.lower_right - self.lower_left, self.upper_left - self.lower_left
        right = right / np.linalg.norm(right)
        out = np.cross(right, up)
        out /= np.linalg.norm(out)
        return np.stack([right, np.cross(out, right), out], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Frustum:
    """Pyramid that an eye sees through a wall.

    Attributes:
        edges: left, right, bottom, top on the near plane, m.
        near: distance of the near plane, m.
        far: distance of the far plane, m.
        projection: (4, 4) as OpenGL has it: from the eye's frame to clip coordinates, all from -1 to 1.
        view: (4, 4) eye_t_room: the eye's frame has x to the right, y up the wall and z out of it.
    """

    edges: tuple[float, float, float, float]
    near: float
    far: float
    projection: Matrix
    view: Matrix

    def camera_matrix(self, width: int, height: int) -> Floats:
        """Return the matrix (3, 3) of the pinhole camera, of so many pixels, that takes this picture.

        As OpenCV and the contract's `CameraIntrinsics` have it: the middle of the upper left pixel is (0, 0).
        """
        left, right, bottom, top = self.edges
        across, down = width * self.near / (right - left), height * self.near / (top - bottom)
        return np.array(
            [
                [across, 0.0, -0.5 - across * left / self.near],
                [0.0, down, -0.5 + down * top / self.near],
                [0.0, 0.0, 1.0],
            ]
        )

    @property
    def room_t_camera(self) -> Matrix:
        """Pose (4, 4) of that camera: z ahead, x to the right of the picture, y down."""
        return np.asarray(np.linalg.inv(self.view) @ np.diag([1.0, -1.0, -1.0, 1.0]), dtype=float)


def frustum(wall: Wall, eye: Sequence[float] | Floats, near: float, far: float) -> Frustum:
    """Return what an eye at (3,) sees through a wall.

    Args:
        wall: the wall.
        eye: where the eye is, in the wall's frame of reference, m.
        near: distance from the eye of the plane before which nothing is seen, m.
        far: that of the one behind which nothing is, m.

    Raises:
        InvalidArgumentError: for an eye on the wall or behind it, and for planes that aren't one behind the other.
    """
    if not (0.0 < near < far and math.isfinite(far)):
        raise InvalidArgumentError(f"near is {near:g} m and far {far:g} m; near is above 0 and far behind it")
    place, axes = np.asarray(eye, dtype=float), wall.axes
    if place.shape != (3,) or not np.isfinite(place).all():
        raise InvalidArgumentError(f"an eye is at three finite numbers (m), not {place}")
    (left, bottom, away), (right, _, _), (_, top, _) = (
        (corner - place) @ axes for corner in (wall.lower_left, wall.lower_right, wall.upper_left)
    )
    distance = -float(away)
    if distance <= 0.0:
        raise InvalidArgumentError(
            f"the eye is {-distance:.3f} m behind the wall {wall.name!r}; it looks at it from its front, where "
            "the corners are as the file says: lower left, lower right, upper left"
        )
    left, right, bottom, top = (float(one) * near / distance for one in (left, right, bottom, top))
    edges = left, right, bottom, top
    view = np.eye(4)
    view[:3, :3], view[:3, 3] = axes.T, -axes.T @ place
    return Frustum(edges, near, far, _projection(edges, near, far), view)


def _projection(edges: tuple[float, float, float, float], near: float, far: float) -> Matrix:
    """Return the matrix (4, 4) of `glFrustum`."""
    left, right, bottom, top = edges
    return np.array(
        [
            [2.0 * near / (right - left), 0.0, (right + left) / (right - left), 0.0],
            [0.0, 2.0 * near / (top - bottom), (top + bottom) / (top - bottom), 0.0],
            [0.0, 0.0, -(far + near) / (far - near), -2.0 * far * near / (far - near)],
            [0.0, 0.0, -1.0, 0.0],
        ]
    )
