"""Lenses: from a camera's settings to the ray of each of its pixels, made once and kept."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from virtualrobot_kernel.numeric.projection import look
from virtualrobot_kernel.world.sensing import CameraSensor, Intrinsics, Projection

WIDTH, HEIGHT = 640, 480
"""Of a picture whose size is not said, in pixels."""
FIELD = 1.0
"""Between the left and the right edge where it is not said, in radians; a spherical picture shows all around."""
NEAR, FAR = 0.01, 100.0
"""Nearest and farthest distance (m) that is seen where none is said."""


@dataclass(frozen=True, slots=True, eq=False)
class Lens:
    """The rays of a camera with n = width * height pixels, in its optical frame: z forward, x right, y down.

    Attributes:
        width: of the picture in pixels.
        height: of the picture in pixels.
        projection: how it comes about.
        intrinsics: focal lengths and middle in pixels; spherical: pixels per radian.
        distortion: OpenCV's coefficients, as they were given.
        near: what is nearer is not seen, in meters: along z for a pinhole, along the ray for others.
        far: what is farther is not seen, measured in the same way.
        pixel_angle: the angle of one pixel near the middle, in radians.
        directions: (n, 3) unit vectors, tile by tile of 4 x 4 pixels; NaN where a pixel looks nowhere.
        pixels: (n,) the pixel of each direction, counted row by row from the upper left.
        slants: (n,) how much of `near`, `far` and depth a meter along each direction is.
        reach: how far rays must go to see all up to `far`, in meters.
    """

    width: int
    height: int
    projection: Projection
    intrinsics: Intrinsics
    distortion: tuple[float, ...]
    near: float
    far: float
    pixel_angle: float
    directions: NDArray[np.float32]
    pixels: NDArray[np.int32]
    slants: NDArray[np.float32]
    reach: float

    @property
    def depth_is_z(self) -> bool:
        """Return whether depth is measured along z, not along the ray."""
        return self.projection is Projection.PINHOLE

    def narrowed(self, directions: ArrayLike) -> Lens:
        """Return a lens with these unit vectors (n, 3) as the pixels of one row, and all else as it is here."""
        along = np.ascontiguousarray(directions, np.float32)
        count = len(along)
        slants = np.ascontiguousarray(along[:, 2]) if self.depth_is_z else np.ones(count, np.float32)
        return replace(
            self,
            width=count,
            height=1,
            directions=along,
            pixels=np.arange(count, dtype=np.int32),
            slants=slants,
            reach=(self.far - self.near) / float(np.nanmin(slants, initial=1.0)),
        )


def size_of(camera: CameraSensor) -> tuple[int, int]:
    """Return width and height of a camera's pictures in pixels."""
    width = camera.width or WIDTH
    half = camera.projection is Projection.SPHERICAL
    return width, camera.height or (max(1, width // 2) if half else HEIGHT)


def lens_of(camera: CameraSensor) -> Lens:
    """Return the lens of a camera, what its settings leave open filled in."""
    spherical = camera.projection is Projection.SPHERICAL
    width, height = size_of(camera)
    field = camera.horizontal_field_radians or (2.0 * math.pi if spherical else FIELD)
    intrinsics = camera.intrinsics
    if intrinsics is None:
        half = math.tan(0.5 * field) if camera.projection is Projection.PINHOLE else 0.5 * field
        focal = 0.5 * width / half
        intrinsics = Intrinsics(focal, focal, 0.5 * (width - 1), 0.5 * (height - 1))
    count = width * height
    directions, pixels = np.empty((count, 3), np.float32), np.empty(count, np.int32)
    coefficients = np.zeros(8)
    coefficients[: len(camera.distortion)] = camera.distortion
    limit = _fisheye_limit(coefficients) if camera.projection is Projection.FISHEYE else _pinhole_limit(coefficients)
    values = np.array([intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy], np.float64)
    look(camera.projection.value, width, height, values, coefficients, limit, directions, pixels)
    near, far = camera.near_meters or NEAR, camera.far_meters or FAR
    along_z = camera.projection is Projection.PINHOLE
    slants = np.ascontiguousarray(directions[:, 2]) if along_z else np.ones(count, np.float32)
    return Lens(
        width=width,
        height=height,
        projection=camera.projection,
        intrinsics=intrinsics,
        distortion=camera.distortion,
        near=near,
        far=far,
        pixel_angle=1.0 / max(intrinsics.fx, intrinsics.fy),
        directions=directions,
        pixels=pixels,
        slants=slants,
        reach=(far - near) / float(np.nanmin(slants, initial=1.0)),
    )


def pinhole(width: int, height: int, vertical_field: float, near: float = NEAR, far: float = 1000.0) -> Lens:
    """Return a lens without distortion, `vertical_field` radians between its upper and lower edge: as a view has it."""
    horizontal = 2.0 * math.atan(math.tan(0.5 * vertical_field) * width / height)
    return lens_of(CameraSensor(width, height, horizontal_field_radians=horizontal, near_meters=near, far_meters=far))


def _pinhole_limit(k: NDArray[np.float64]) -> float:
    """Return up to which radius on the plane z = 1 the radial distortion grows with the radius."""
    radius = np.linspace(0.0, 20.0, 20001)[1:]
    r2 = radius * radius
    below = 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]))
    placed = radius * (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / below
    return _first_turn(radius, np.where(below > 0.0, placed, -1.0))


def _fisheye_limit(k: NDArray[np.float64]) -> float:
    """Return up to which angle from the axis the distance from the middle grows with it."""
    angle = np.linspace(0.0, math.pi, 4001)[1:]
    t2 = angle * angle
    placed = angle * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))))
    turn = _first_turn(angle, placed)
    return math.pi if math.isinf(turn) else turn


def _first_turn(values: NDArray[np.float64], placed: NDArray[np.float64]) -> float:
    """Return the last of `values` before `placed` no longer grows; inf where it always does."""
    falls = np.flatnonzero(np.diff(placed, prepend=0.0) <= 0.0)
    if not len(falls):
        return math.inf
    return float(values[falls[0] - 1]) if falls[0] else 0.0
