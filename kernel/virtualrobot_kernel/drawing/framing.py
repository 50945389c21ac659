"""Viewpoint from which everything is seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.view import DEFAULT_FIELD_OF_VIEW, Camera

DIRECTION = np.array([1.0, -1.25, 0.72]) / np.linalg.norm([1.0, -1.25, 0.72])
"""From the scene to the eye: in front, to the right and above, as cells are drawn in catalogues."""

ASPECT = 1.4
"""Width over height of a window that still shows everything; in a wider one there is room at the sides."""

FILLED = 0.94
"""Part of the window that the scene may take."""

EMPTY_CAMERA = Camera((3.0, -3.75, 2.2), (0.0, 0.0, 0.0))
"""Camera of an empty world."""

SMALLEST = 0.25
"""Half of the least edge of the box that is framed, in meters: the eye stays off a scene that is smaller."""


def framed(
    bounds: NDArray[np.float64],
    field_of_view: float = DEFAULT_FIELD_OF_VIEW,
    aspect: float = ASPECT,
    smallest: float = SMALLEST,
) -> Camera:
    """Return a camera that looks at the middle of a box (2, 3) and sees all of it; meters, in the world's frame.

    `aspect` is the width of the picture over its height, `smallest` half of the least edge of the box that is framed.

    A corner c, counted from the middle, has the depth d - c.forward when the eye is at distance d, so that it is in
    the picture when |c.up| and |c.right| are at most that depth times the tangents of half the opening angles.
    """
    center = bounds.mean(axis=0)
    half = np.maximum(0.5 * (bounds[1] - bounds[0]), smallest)
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = signs * half
    right = np.cross([0.0, 0.0, 1.0], DIRECTION)
    right /= np.linalg.norm(right)
    up = np.cross(DIRECTION, right)
    tangent = FILLED * np.tan(0.5 * field_of_view)
    needed = np.maximum(np.abs(corners @ up) / tangent, np.abs(corners @ right) / (aspect * tangent))
    eye = center + float((corners @ DIRECTION + needed).max()) * DIRECTION
    return Camera(_three(eye), _three(center), field_of_view)


def outgrown(framed_bounds: NDArray[np.float64] | None, bounds: NDArray[np.float64]) -> bool:
    """Return whether a scene of these bounds is worth a new frame: it grew by more than a tenth of its diagonal."""
    if framed_bounds is None:
        return True
    growth = np.maximum(framed_bounds[0] - bounds[0], bounds[1] - framed_bounds[1])
    return bool(growth.max() > 0.1 * np.linalg.norm(framed_bounds[1] - framed_bounds[0]))


class Framing:
    """Frames a world in one picture after the other, and anew when it outgrows the frame."""

    def __init__(self, smallest: float = SMALLEST) -> None:
        """Begin without a frame; `smallest` is as of `framed`."""
        self._smallest = smallest
        self._bounds: NDArray[np.float64] | None = None
        self._camera = EMPTY_CAMERA

    def camera(self, bounds: NDArray[np.float64] | None, aspect: float) -> Camera:
        """Return where to look from; `bounds` (2, 3) is the box around the world, None while it is empty."""
        if bounds is not None and outgrown(self._bounds, bounds):
            self._bounds, self._camera = bounds, framed(bounds, aspect=aspect, smallest=self._smallest)
        return self._camera


def _three(vector: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
