"""Projection of points of the world into a picture, through a lens, for what is drawn over the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.sensing.lenses import Lens, lens_of
from virtualrobot_kernel.world.sensing import CameraSensor, Intrinsics, Projection

PIECES = 32
"""Into so many a line is cut where the lens bends it."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Viewpoint:
    """A lens at a place: `world_t_camera` (4, 4), an optical frame (z forward, x right, y down)."""

    lens: Lens
    world_t_camera: Floats

    @property
    def bends(self) -> bool:
        """Return whether straight lines are curves in the picture."""
        return self.lens.projection is not Projection.PINHOLE or any(self.lens.distortion)

    def places(self, points: Floats) -> Floats:
        """Return column, row and inverse depth (n, 3) of points (n, 3) in the world; NaN where one is not in view."""
        return self._projected(self._seen(points))

    def lines(self, ends: Floats) -> tuple[Floats, NDArray[np.int64]]:
        """Return straight lines (m, 2, 3) in the picture, as `places` has them, and of which line (m,) each is a part.

        Args:
            ends: (n, 2, 3) in the world.
        """
        rows = np.arange(len(ends))
        seen = self._seen(ends.reshape(-1, 3)).reshape(-1, 2, 3)
        if self.bends:
            steps = np.linspace(0.0, 1.0, PIECES + 1)[None, :, None]
            along = seen[:, :1] + steps * (seen[:, 1:] - seen[:, :1])
            seen = np.stack([along[:, :-1], along[:, 1:]], axis=2).reshape(-1, 2, 3)
            rows = np.repeat(rows, PIECES)
        else:
            seen, kept = _in_front(seen, self.lens.near)
            rows = rows[kept]
        drawn = self._projected(seen.reshape(-1, 3)).reshape(-1, 2, 3)
        # Around the back of a spherical picture a line leaves at one side and comes in at the other.
        whole = np.isfinite(drawn).all(axis=(1, 2)) & (np.abs(drawn[:, 1, 0] - drawn[:, 0, 0]) < 0.5 * self._wrap)
        return drawn[whole], rows[whole]

    def ray(self, column: float, row: float) -> Floats:
        """Return where a place in the picture looks, a unit vector (3,) in the camera's frame; NaN where nowhere."""
        lens = self.lens
        eye = lens.intrinsics
        assert eye is not None  # `lens_of` fills it in
        alone = CameraSensor(
            width=1,
            height=1,
            projection=lens.projection,
            intrinsics=Intrinsics(eye.fx, eye.fy, eye.cx - column, eye.cy - row),
            distortion=lens.distortion,
        )
        return lens_of(alone).directions[0].astype(np.float64)

    def pixels_per_meter(self, inverse_depths: Floats) -> Floats:
        """Return how large a meter is in the picture, in the middle, at these inverse depths."""
        return inverse_depths / self.lens.pixel_angle

    @property
    def _wrap(self) -> float:
        return self.lens.width if self.lens.projection is Projection.SPHERICAL else math.inf

    def _seen(self, points: Floats) -> Floats:
        rotation, position = self.world_t_camera[:3, :3], self.world_t_camera[:3, 3]
        return (points - position) @ rotation

    def _projected(self, seen: Floats) -> Floats:
        """Return places of points (n, 3) in the camera's frame. The equations are OpenCV's, as in `lenses`."""
        lens = self.lens
        x, y, z = seen.T
        distance = np.linalg.norm(seen, axis=1)
        with np.errstate(all="ignore"):
            if lens.projection is Projection.SPHERICAL:
                u, v, depth, in_view = np.arctan2(x, z), np.arcsin(y / distance), distance, distance > lens.near
            else:
                k = np.zeros(8)
                k[: len(lens.distortion)] = lens.distortion
                u, v, depth, in_view = (
                    self._fisheye(x, y, z, distance, k)
                    if lens.projection is Projection.FISHEYE
                    else self._pinhole(x, y, z, k)
                )
            eye = lens.intrinsics
            assert eye is not None  # `lens_of` fills it in
            column, row = eye.fx * u + eye.cx, eye.fy * v + eye.cy
            places = np.stack([column, row, 1.0 / depth], axis=1)
        places[~in_view] = np.nan
        return places

    def _pinhole(self, x: Floats, y: Floats, z: Floats, k: Floats) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
        u, v = x / z, y / z
        in_view = z >= 0.999 * self.lens.near
        if not k.any():
            return u, v, z, in_view
        r2 = u * u + v * v
        factor = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))
        factor /= 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]))
        across = u * factor + 2.0 * k[2] * u * v + k[3] * (r2 + 2.0 * u * u)
        down = v * factor + k[2] * (r2 + 2.0 * v * v) + 2.0 * k[3] * u * v
        return across, down, z, in_view & (1.0 / np.sqrt(1.0 + r2) >= self._least_cosine)

    def _fisheye(
        self, x: Floats, y: Floats, z: Floats, distance: Floats, k: Floats
    ) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
        side = np.hypot(x, y)
        angle = np.arctan2(side, z)
        t2 = angle * angle
        bent = angle * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))))
        scale = np.where(side > 0.0, bent / np.maximum(side, 1e-300), 0.0)
        return x * scale, y * scale, distance, (distance > self.lens.near) & (np.cos(angle) >= self._least_cosine)

    @property
    def _least_cosine(self) -> float:
        """Return the cosine of the angle from the axis of what is seen farthest out; beyond, the formulas fold back."""
        return float(np.nanmin(self.lens.directions[:, 2]))


def look_at(position: tuple[float, float, float], target: tuple[float, float, float]) -> Floats:
    """Return world_t_camera (4, 4) of an optical frame at `position` that looks at `target`, the world's z upwards."""
    eye = np.array(position)
    forward = np.array(target) - eye
    forward /= np.linalg.norm(forward)
    # Straight up or down, which way is up in the picture is not defined; then +y is, as in the viewer.
    up = np.array([0.0, 0.0, 1.0]) if np.hypot(forward[0], forward[1]) > 1e-3 * abs(forward[2]) else np.eye(3)[1]
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2], pose[:3, 3] = right, np.cross(forward, right), forward, eye
    return pose


def _in_front(seen: Floats, near: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Return what of lines (n, 2, 3) in the camera's frame is `near` in front at least, and which (n,) that are."""
    z = seen[:, :, 2]
    kept: NDArray[np.bool_] = np.any(z > near, axis=1)
    seen, z = seen[kept].copy(), z[kept]
    with np.errstate(all="ignore"):
        for end, other in ((0, 1), (1, 0)):
            cut = z[:, end] < near
            part = (near - z[cut, end]) / (z[cut, other] - z[cut, end])
            seen[cut, end] += part[:, None] * (seen[cut, other] - seen[cut, end])
    return seen, kept
