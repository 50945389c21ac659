"""Cameras and lights of a scene, and the pictures that cameras take."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, PoseLike, checked
from virtualrobot._wire.messages import (
    Wrapped,
    array_of,
    color_message,
    count_or_default,
    seed_of,
    value_or_default,
    vector_message,
)
from virtualrobot._wire.showing import png, shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix
from virtualrobot.v1 import sensing_pb2, sensor_pb2

PROJECTIONS = {
    "pinhole": sensing_pb2.CAMERA_PROJECTION_PINHOLE,
    "fisheye": sensing_pb2.CAMERA_PROJECTION_FISHEYE,
    "spherical": sensing_pb2.CAMERA_PROJECTION_SPHERICAL,
}
IMAGES = {
    "color": sensing_pb2.IMAGE_KIND_COLOR,
    "depth": sensing_pb2.IMAGE_KIND_DEPTH,
    "segmentation": sensing_pb2.IMAGE_KIND_SEGMENTATION,
    "normals": sensing_pb2.IMAGE_KIND_NORMALS,
}
LIGHTS = {
    "point": sensing_pb2.LIGHT_KIND_POINT,
    "spot": sensing_pb2.LIGHT_KIND_SPOT,
    "directional": sensing_pb2.LIGHT_KIND_DIRECTIONAL,
}


class CameraSettings(Wrapped[sensing_pb2.CameraSensor]):
    """Settings of a camera; `camera` makes them."""

    __slots__ = ()
    _called = "what virtualrobot.camera makes"


class LightSettings(Wrapped[sensing_pb2.Light]):
    """Kind, colour and strength of a light; `light` makes them."""

    __slots__ = ()
    _called = "what virtualrobot.light makes"


@checked
def camera(
    width: int | None = None,
    height: int | None = None,
    *,
    projection: str = "pinhole",
    horizontal_field: float | None = None,
    camera_matrix: ArrayLike | None = None,
    distortion: Iterable[float] = (),
    near: float | None = None,
    far: float | None = None,
    rate: float | None = None,
    images: str | Iterable[str] = (),
    color_noise: float = 0.0,
    depth_noise: float = 0.0,
    seed: int = 0,
    stereo_baseline: float | None = None,
    water_attenuation: ArrayLike | None = None,
    water_color: str | ArrayLike | None = None,
    running: bool = False,
) -> CameraSettings:
    """Return the settings of a camera for `scene.add_camera`.

    Args:
        width: of the picture in pixels, 640 by default.
        height: of the picture, 480 by default, of a spherical one half the width.
        projection: pinhole, fisheye or spherical.
        horizontal_field: between the left and the right edge, in radians, 1.0 by default.
        camera_matrix: (3, 3) as OpenCV has it, instead of the field.
        distortion: OpenCV's coefficients: 4, 5 or 8 of a pinhole, 4 of a fisheye.
        near: least distance (m) of surfaces that are seen, 0.01 by default.
        far: greatest distance (m) of surfaces that are seen, 100 by default.
        rate: pictures a second of simulation time while it runs, 10 by default.
        images: the kinds of images of a running camera: color, depth, segmentation, normals; none means color.
        color_noise: the standard deviation of colours, in parts of white.
        depth_noise: the standard deviation of depth at 1 m, in meters; it grows with the square of the depth.
        seed: the seed of the noise.
        stereo_baseline: to a second eye along x, in meters; by default there is one eye.
        water_attenuation: how much of red, green and blue light water takes, (3,) in 1/m; by default there is none.
        water_color: the color of water in which nothing is, black by default.
        running: whether it takes pictures from the start.

    Example:
        >>> pose = virtualrobot.looking_at([2, 0, 1], [0, 0, 0])
        >>> scene.add_camera("eye", virtualrobot.camera(images=["color", "depth"]), pose=pose)
    """
    settings = sensing_pb2.CameraSensor(
        width=count_or_default(width, "a camera's width"),
        height=count_or_default(height, "a camera's height"),
        projection=_one_of(PROJECTIONS, projection, "projection"),
        horizontal_field_radians=value_or_default(horizontal_field, "horizontal_field"),
        distortion=[float(one) for one in distortion],
        near_meters=value_or_default(near, "near"),
        far_meters=value_or_default(far, "far"),
        rate_hertz=value_or_default(rate, "rate"),
        images=image_kinds(images),
        color_noise=color_noise,
        depth_noise_meters=depth_noise,
        seed=seed_of(seed),
        stereo_baseline_meters=value_or_default(stereo_baseline, "stereo_baseline"),
        water_attenuation_per_meter=(
            None if water_attenuation is None else vector_message(water_attenuation, "water_attenuation")
        ),
        water_color=None if water_color is None else color_message(water_color),
        running=running,
    )
    if camera_matrix is not None:
        matrix = np.asarray(camera_matrix, float)
        if matrix.shape != (3, 3):
            raise InvalidArgumentError(f"a camera matrix has the shape (3, 3), not {matrix.shape}")
        if matrix[0, 1] or matrix[1, 0] or matrix[2].tolist() != [0.0, 0.0, 1.0]:
            raise InvalidArgumentError(
                f"a camera matrix is [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], without skew, not {matrix.tolist()}"
            )
        settings.intrinsics.CopyFrom(
            sensing_pb2.CameraIntrinsics(fx=matrix[0, 0], fy=matrix[1, 1], cx=matrix[0, 2], cy=matrix[1, 2])
        )
    return CameraSettings(settings)


@checked
def light(
    kind: str = "point",
    *,
    color: str | ArrayLike | None = None,
    intensity: float | None = None,
    cone_angle: float | None = None,
    shadows: bool = True,
) -> LightSettings:
    """Return a light for `scene.add_light`.

    Args:
        kind: point (to all sides), spot (a cone about z) or directional (along z, from far away).
        color: none means white.
        intensity: at 1 a white surface that faces it, 1 m away, shows white; 1 by default.
        cone_angle: of a spot, between axis and edge in radians, 0.5 by default.
        shadows: whether things in its way cast them.
    """
    message = sensing_pb2.Light(
        kind=_one_of(LIGHTS, kind, "kind of light"),
        color=None if color is None else color_message(color),
        intensity=value_or_default(intensity, "intensity"),
        cone_angle_radians=value_or_default(cone_angle, "cone_angle"),
        shadowless=not shadows,
    )
    return LightSettings(message)


@checked
def looking_at(eye: ArrayLike, target: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)) -> Matrix:
    """Return the pose (4, 4) of a camera or a spot at `eye` that looks at `target`, upright in the picture.

    z goes from `eye` to `target`, x to the right, y down. Where it looks along `up`, x is that of the frame.
    """
    named = {"the eye": eye, "its target": target, "up": up}
    for what, one in named.items():
        vector_message(one, what)
    place, goal, above = (np.asarray(one, float) for one in named.values())
    z = goal - place
    length = np.linalg.norm(z)
    if not length > 1e-9:
        raise InvalidArgumentError(f"eye and target are the same point {place.tolist()}: there is nowhere to look")
    if not above.any():
        raise InvalidArgumentError("up is [0, 0, 0]; it needs a direction, such as [0, 0, 1]")
    z /= length
    x = np.cross(z, above)
    if np.linalg.norm(x) < 1e-6 * np.linalg.norm(above):
        x = np.array([1.0, 0.0, 0.0]) - z[0] * z
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    pose[:3, 3] = place
    return pose


def image_kinds(names: str | Iterable[str]) -> list[sensing_pb2.ImageKind]:
    """Return kinds of pictures by name as the contract has them."""
    if isinstance(names, str):
        names = (names,)
    return [_one_of(IMAGES, name, "kind of picture") for name in names]


@shown
@checked
@dataclass(frozen=True, eq=False)
class CameraReading:
    """Images of a camera; arrays are read-only, and None where a kind was not asked for.

    Attributes:
        color: (h, w, 3) uint8: red, green, blue, as screens show them (OpenCV wants `color[..., ::-1]`).
        depth: (h, w) float32: meters along z, of fisheye and spherical ones along the ray; inf where there is nothing.
        segmentation: (h, w) int32: places in `element_names`; -1 where there is nothing.
        normals: (h, w, 3) float32: unit normals in the camera's frame; 0 where there is nothing.
        width: in pixels.
        height: in pixels.
        projection: pinhole, fisheye or spherical.
        camera_matrix: (3, 3) as OpenCV has it; of a spherical one fx and fy are pixels per radian.
        distortion: OpenCV's coefficients; (0,) where there are none.
        element_names: the nodes that segmentation tells of.
        stereo_baseline: between the eyes, in meters; 0 where there is one.
        right: the images of the right one of two eyes; None where there is one.
    """

    color: NDArray[np.uint8] | None
    depth: NDArray[np.float32] | None
    segmentation: NDArray[np.int32] | None
    normals: NDArray[np.float32] | None
    width: int
    height: int
    projection: str
    camera_matrix: NDArray[np.float64]
    distortion: NDArray[np.float64]
    element_names: tuple[str, ...]
    stereo_baseline: float = 0.0
    right: CameraReading | None = None

    def _repr_png_(self) -> bytes | None:
        """Return the picture in colour for notebooks; None where it was not asked for."""
        return None if self.color is None else png(self.color)

    def mask(self, name: str) -> NDArray[np.bool_]:
        """Return (h, w) where the node `name` is seen; nowhere where it is not in the picture at all."""
        places = self._had(self.segmentation, "segmentation")
        if name not in self.element_names:
            return np.zeros(places.shape, np.bool_)
        return places == self.element_names.index(name)

    def directions(self) -> NDArray[np.float64]:
        """Return (h, w, 3) unit vectors along which the pixels look, in the camera's frame; NaN where nowhere."""
        row, column = np.indices((self.height, self.width))
        k = self.camera_matrix
        x, y = (column - k[0, 2]) / k[0, 0], (row - k[1, 2]) / k[1, 1]
        if self.projection == "spherical":
            rays = np.stack([np.cos(y) * np.sin(x), np.sin(y), np.cos(y) * np.cos(x)], axis=-1)
            return np.where((np.abs(y) <= 0.5 * np.pi)[..., None], rays, np.nan)
        if self.projection == "fisheye":
            return _fisheye(x, y, self.distortion)
        x, y = _undistorted(x, y, self.distortion)
        rays = np.stack([x, y, np.ones_like(x)], axis=-1)
        return rays / np.linalg.norm(rays, axis=-1, keepdims=True)

    def points(self, frame_t_camera: PoseLike | None = None) -> NDArray[np.float64]:
        """Return (h, w, 3) what depth shows as points in meters; NaN where there is nothing.

        They are in the camera's frame, or with `frame_t_camera` (4, 4), such as `world_t_sensor` of the reading, in
        another.
        """
        depth = self._had(self.depth, "depth").astype(float)
        depth = np.where(np.isfinite(depth), depth, np.nan)
        rays = self.directions()
        if self.projection == "pinhole":
            rays /= rays[..., 2:]
        points = rays * depth[..., None]
        if frame_t_camera is None:
            return points
        pose = np.asarray(frame_t_camera, float)
        return points @ pose[:3, :3].T + pose[:3, 3]

    def _had(self, image: NDArray[Any] | None, kind: str) -> NDArray[Any]:
        if image is None:
            raise InvalidArgumentError(f"this reading has no {kind}: ask the camera for it by images=[{kind!r}]")
        return image


def camera_reading_of(message: sensor_pb2.CameraReading) -> CameraReading:
    """Return what a camera saw from a message."""
    right = [image for image in message.images if image.right]
    left = [image for image in message.images if not image.right]
    return _eye(message, left, _eye(message, right, None) if right else None)


def _eye(
    message: sensor_pb2.CameraReading, images: list[sensor_pb2.Image], right: CameraReading | None
) -> CameraReading:
    by_kind = {image.kind: array_of(image.pixels) for image in images}
    k = message.intrinsics
    names = {number: name for name, number in PROJECTIONS.items()}
    return CameraReading(
        **{name: by_kind.get(number) for name, number in IMAGES.items()},  # pyright: ignore[reportArgumentType] by name
        width=message.width,
        height=message.height,
        projection=names[message.projection],
        camera_matrix=np.array([[k.fx, 0.0, k.cx], [0.0, k.fy, k.cy], [0.0, 0.0, 1.0]]),
        distortion=np.array(message.distortion, np.float64),
        element_names=tuple(message.element_names),
        stereo_baseline=message.stereo_baseline_meters,
        right=right,
    )


def _undistorted(
    u: NDArray[np.float64], v: NDArray[np.float64], coefficients: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places on the plane z = 1 before distortion, NaN where there are none.

    Newton's method from the middle outwards, in steps that each bring a place nearer: as the kernel's cameras look.
    """
    k = np.zeros(8)
    k[: len(coefficients)] = coefficients
    if not k.any():
        return u, v
    x, y, step_x, step_y, miss = np.zeros_like(u), np.zeros_like(v), u, v, u * u + v * v
    with np.errstate(all="ignore"):  # what overflows brings nothing nearer
        radius = np.linspace(0.0, 20.0, 20001)[1:]
        below = np.polyval([k[7], k[6], k[5], 1.0], radius**2)
        placed = np.where(below > 0.0, radius * np.polyval([k[4], k[1], k[0], 1.0], radius**2) / below, -1.0)
        farthest = _last_growing(radius, placed, np.inf)
        for _ in range(50):
            to_x, to_y = x + step_x, y + step_y
            r2 = to_x * to_x + to_y * to_y
            below = 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]))
            factor = (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / below
            slope = (k[0] + r2 * (2.0 * k[1] + 3.0 * r2 * k[4])) / below
            slope -= factor * (k[5] + r2 * (2.0 * k[6] + 3.0 * r2 * k[7])) / below
            a = to_x * factor + 2.0 * k[2] * to_x * to_y + k[3] * (r2 + 2.0 * to_x * to_x) - u
            b = to_y * factor + k[2] * (r2 + 2.0 * to_y * to_y) + 2.0 * k[3] * to_x * to_y - v
            xx = factor + 2.0 * to_x * to_x * slope + 2.0 * k[2] * to_y + 6.0 * k[3] * to_x
            xy = 2.0 * to_x * to_y * slope + 2.0 * k[2] * to_x + 2.0 * k[3] * to_y
            yy = factor + 2.0 * to_y * to_y * slope + 6.0 * k[2] * to_y + 2.0 * k[3] * to_x
            determinant = xx * yy - xy * xy
            nearer = (r2 <= farthest**2) & (determinant > 0.0) & (a * a + b * b <= miss)
            x, y, miss = np.where(nearer, to_x, x), np.where(nearer, to_y, y), np.where(nearer, a * a + b * b, miss)
            step_x = np.where(nearer, (xy * b - yy * a) / determinant, 0.5 * step_x)
            step_y = np.where(nearer, (xy * a - xx * b) / determinant, 0.5 * step_y)
    found = miss < 1e-16
    return np.where(found, x, np.nan), np.where(found, y, np.nan)


def _fisheye(x: NDArray[np.float64], y: NDArray[np.float64], coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return directions of a fisheye; NaN behind half a turn from the axis, and where the lens folds."""
    k = np.zeros(4)
    k[: len(coefficients)] = coefficients

    def placed(angle: NDArray[np.float64]) -> NDArray[np.float64]:
        return angle * np.polyval([*k[::-1], 1.0], angle * angle)

    angles = np.linspace(0.0, np.pi, 4001)[1:]
    farthest = _last_growing(angles, placed(angles), np.pi)
    radius = np.hypot(x, y)
    low, high = np.zeros_like(radius), np.full_like(radius, farthest)
    for _ in range(55):  # to the last bit
        angle = 0.5 * (low + high)
        is_below = placed(angle) < radius
        low, high = np.where(is_below, angle, low), np.where(is_below, high, angle)
    angle = np.where(radius <= placed(np.array(farthest)) + 1e-9, high, np.nan)
    side = np.where(radius > 0.0, np.sin(angle) / np.maximum(radius, 1e-300), 1.0)
    return np.stack([x * side, y * side, np.cos(angle)], axis=-1)


def _last_growing(values: NDArray[np.float64], placed: NDArray[np.float64], always: float) -> float:
    """Return the last of `values` before `placed` no longer grows; `always` where it always does."""
    falls = np.flatnonzero(np.diff(placed, prepend=0.0) <= 0.0)
    if not len(falls):
        return always
    return float(values[falls[0] - 1]) if falls[0] else 0.0


def _one_of(table: dict[str, Any], name: str, what: str) -> Any:  # noqa: ANN401 an enum's number
    if name not in table:
        raise InvalidArgumentError(f"{name!r} is no {what}: use {', '.join(table)}")
    return table[name]
