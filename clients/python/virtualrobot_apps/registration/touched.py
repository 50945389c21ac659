"""Registration by touched points: the pose of a measuring device, where gravity says which way is up for both.

Two frames that agree on what is up differ in a turn about it and in a shift: four unknowns in place of six. Of three
points touched alike that halves the error at a tool, since nothing can tilt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot._wire.arguments import ArrayLike
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix

from virtualrobot_apps.registration.lengths import length_of

Floats = NDArray[np.float64]

NEEDED = 3
"""Number of points from which one that was touched wrongly shows: two alone determine the pose."""

LEAST_APART = 0.6
"""Horizontal distance (m) that the two points farthest apart have at least."""

LEAST_OFF_LINE = 0.05
"""Least spread of points across the line that they are nearest to, as a share of that along it."""

NOISE = 0.002
"""Standard deviation (m) of each coordinate of a touch, where nobody says another."""

MOST_NOISE = 5.0
"""Factor of the noise from which what is left over is a mistake: of normal noise that is one in a million touches."""

MOST_TILT = 0.1
"""Tilt (rad) of a device beyond which it has no idea of what is up."""

MOST_METERS = 1e6
"""Distance (m) of a point from its origin beyond which it is a mistake."""

UP = {
    "z": np.eye(4),
    "y": np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]),
}
"""Pose of a device's frame in one with z up, by the axis that is up in it: y for WebXR and OpenXR."""


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """Pose of a device by touched points, and how good it is.

    Attributes:
        model_t_device: (4, 4), takes what the device measures to the frame of the points of the model (m).
        residuals: (n,) how far each touch is off then, m.
        noise: standard deviation of each coordinate of a touch, m: that expected, or that of what is left over if it
            is more.
        center: (3,) the middle of the points, in the model's frame, m.
        spread: sum of the squares of the points' horizontal distances from it, m^2.
        lean: (2,) sums of the points' x and y times their height, about their middle, over the spread.
        tilt: standard deviation of what the device takes for up, about each level axis, rad.
    """

    model_t_device: Matrix
    residuals: Floats
    noise: float
    center: Floats
    spread: float
    lean: Floats
    tilt: float

    def covariance(self, point: ArrayLike) -> Floats:
        """Return the covariance (3, 3), m^2, of where a point (3,) of the model's frame is thought to be.

        To first order: the middle of n touches shifts by the variance of one of them over n in each direction, and the
        turn about it has that variance over the spread. A device that leans turns all about the middle, and the best
        turn makes up for a part of it.
        """
        arm = np.asarray(point, dtype=float) - self.center
        turned = np.array([-arm[1], arm[0], 0.0])
        leaned = np.array([[0.0, -arm[2], arm[1]], [arm[2], 0.0, -arm[0]]]) + self.lean[:, None] * turned
        touches = np.eye(3) / len(self.residuals) + np.outer(turned, turned) / self.spread
        return self.noise**2 * touches + self.tilt**2 * leaned.T @ leaned

    def error(self, point: ArrayLike, share: float = 0.95) -> float:
        """Return the distance (m) that a point (3,) of the model's frame is off at most, in this share of cases."""
        return length_of(self.covariance(point), share)


def register(
    points: ArrayLike,
    touched: ArrayLike,
    *,
    up: str = "z",
    noise: float = NOISE,
    tilt: float = 0.0,
    least_apart: float = LEAST_APART,
) -> Registration:
    """Return where a device is that has touched points of a model.

    The turn is the one that makes the sum of squares of what is left over least, in closed form: the horizontal part
    of Arun, Huang and Blostein's fit (Least-Squares Fitting of Two 3-D Point Sets, 1987).

    Args:
        points: (n, 3) where they are in the model, m, z up.
        touched: (n, 3) where the device says that they are, m.
        up: the axis of the device's frame that is up: `z` or `y`.
        noise: the standard deviation of each coordinate of a touch, m.
        tilt: that of what the device takes for up, about each level axis, rad.
        least_apart: the horizontal distance (m) that two of the points have at least.

    Raises:
        InvalidArgumentError: for fewer than three points, for those that lie on a line or too near one another, for an
            axis that isn't known, and where the touches don't fit the points, with the one that fits least.
    """
    if up not in UP:
        raise InvalidArgumentError(f"the axis that is up is {' or '.join(UP)}, not {up!r}")
    if not (math.isfinite(noise) and noise > 0.0):
        raise InvalidArgumentError(f"the noise of a touch is {noise:g} m; it is above 0")
    if not 0.0 <= tilt <= MOST_TILT:
        raise InvalidArgumentError(f"the tilt of a device is {tilt:g} rad; it lies between 0 and {MOST_TILT:g}")
    wanted, measured = _rows(points, "points"), _rows(touched, "touched points")
    if len(wanted) != len(measured):
        raise InvalidArgumentError(f"{len(measured)} points were touched of {len(wanted)}; give one for each")
    _refuse_poor(wanted, least_apart)
    measured = measured @ UP[up][:3, :3].T
    center, middle = wanted.mean(axis=0), measured.mean(axis=0)
    (x, y, _), (u, v, _) = (wanted - center).T, (measured - middle).T
    turn = math.atan2(float(u @ y - v @ x), float(u @ x + v @ y))
    cosine, sine = math.cos(turn), math.sin(turn)
    upright = np.eye(4)
    upright[:2, :2] = [[cosine, -sine], [sine, cosine]]
    upright[:3, 3] = center - upright[:3, :3] @ middle
    residuals = np.linalg.norm(measured @ upright[:3, :3].T + upright[:3, 3] - wanted, axis=1)
    left = math.sqrt(float(residuals @ residuals) / (3 * len(wanted) - 4))
    expected = math.hypot(noise, tilt * math.sqrt(float(np.mean((wanted - center) ** 2))))
    if left > MOST_NOISE * expected:
        worst = int(np.argmax(residuals))
        raise InvalidArgumentError(
            f"the touches don't fit the points: they are {1e3 * left:.1f} mm off where {1e3 * expected:.1f} mm is "
            f"expected, point {worst + 1} most, by {1e3 * residuals[worst]:.1f} mm; look whether each was touched "
            f"where the model has it, in this order, and whether {up} is up for the device",
            metadata={"point": str(worst + 1)},
        )
    arms = wanted - center
    spread = float(np.sum(arms[:, :2] ** 2))
    lean = arms[:, 2] @ arms[:, :2] / spread
    found = noise if left <= expected else left
    return Registration(upright @ UP[up], residuals, found, center, spread, lean, tilt)


def _rows(given: ArrayLike, name: str) -> Floats:
    try:
        rows = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise InvalidArgumentError(f"the {name} are rows of three numbers (m), not {given!r}") from None
    if rows.ndim != 2 or rows.shape[1] != 3 or not np.isfinite(rows).all():
        raise InvalidArgumentError(
            f"the {name} are rows of three finite numbers (m), not an array of shape {rows.shape}"
            if rows.ndim != 2 or rows.shape[1] != 3
            else f"the {name} have a number that is not finite"
        )
    if np.abs(rows).max(initial=0.0) > MOST_METERS:
        raise InvalidArgumentError(f"the {name} have {np.abs(rows).max():g} m; they are in m, {MOST_METERS:g} at most")
    return rows


def _refuse_poor(points: Floats, least_apart: float) -> None:
    """Raise InvalidArgumentError for points (n, 3) that don't tell where a device is, or not well enough."""
    if len(points) < NEEDED:
        raise InvalidArgumentError(
            f"{len(points)} points were touched; touch {NEEDED} at least, so that a wrong one among them shows"
        )
    along, across, _ = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if across <= LEAST_OFF_LINE * along:
        raise InvalidArgumentError(
            "the points lie on a line, along which nothing shows whether the device has the right axis up; touch one "
            "that is well off it"
        )
    level = points[:, :2]
    apart = float(np.linalg.norm(level[:, None] - level[None], axis=2).max())
    if apart < least_apart:
        raise InvalidArgumentError(
            f"the points are {apart:.2f} m apart at most, seen from above; touch more, of which two are "
            f"{least_apart:g} m apart or farther, since a turn is told by them"
        )
