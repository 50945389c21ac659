"""Pictures at the client: their rays against the kernel's lenses, points, masks, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot._wire.messages import array_message
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.sensors.cameras import (
    CameraReading,
    CameraSettings,
    camera,
    camera_reading_of,
    image_kinds,
    light,
    looking_at,
)
from virtualrobot.v1 import sensing_pb2, sensor_pb2
from virtualrobot_kernel.messages.sensing import SENSORS
from virtualrobot_kernel.sensing.lenses import Lens, lens_of


def lens_and_reading(settings: sensing_pb2.CameraSensor) -> tuple[Lens, CameraReading]:
    """The kernel's lens of a client's settings, and a reading whose depth is 2 everywhere."""
    lens = lens_of(SENSORS["camera_sensor"].read(settings, "camera"))
    k = lens.intrinsics
    depth = sensor_pb2.Image(
        kind=sensing_pb2.IMAGE_KIND_DEPTH, pixels=array_message(np.full((lens.height, lens.width), 2.0), "<f4")
    )
    message = sensor_pb2.CameraReading(
        images=[depth],
        width=lens.width,
        height=lens.height,
        intrinsics=sensing_pb2.CameraIntrinsics(fx=k.fx, fy=k.fy, cx=k.cx, cy=k.cy),
        distortion=lens.distortion,
        projection=settings.projection,
    )
    return lens, camera_reading_of(message)


@pytest.mark.parametrize(
    "settings",
    [
        camera(60, 40, horizontal_field=1.2),
        camera(60, 40, camera_matrix=[[50, 0, 28], [0, 55, 21], [0, 0, 1]], distortion=[-0.2, 0.05, 0.002, -0.001]),
        camera(60, 40, camera_matrix=[[60, 0, 30], [0, 60, 20], [0, 0, 1]], distortion=[0.1, 0, 0, 0, 0, 0.05, 0, 0]),
        camera(60, 60, projection="fisheye", horizontal_field=3.5, distortion=[0.02, -0.01, 0.002, 0.0]),
        camera(60, 40, projection="spherical"),
    ],
    ids=["plain", "distorted", "rational", "fisheye", "spherical"],
)
def test_the_rays_of_a_reading_are_those_of_the_kernels_lens(settings: CameraSettings) -> None:
    lens, reading = lens_and_reading(settings._message)
    rays = np.empty((lens.width * lens.height, 3), np.float32)
    rays[lens.pixels] = lens.directions
    np.testing.assert_allclose(reading.directions(), rays.reshape(lens.height, lens.width, 3), atol=1e-5)
    points = reading.points()
    if lens.depth_is_z:
        np.testing.assert_allclose(points[..., 2], 2.0)
    else:
        seen = np.isfinite(rays[:, 0]).reshape(points.shape[:2])
        np.testing.assert_allclose(np.linalg.norm(points[seen], axis=1), 2.0, atol=1e-6)
    pose = looking_at([1, 2, 3], [0, 0, 0])
    there = reading.points(pose).reshape(-1, 3)
    np.testing.assert_allclose(there, points.reshape(-1, 3) @ pose[:3, :3].T + [1, 2, 3], atol=1e-9)


def test_looking_at_goes_to_the_target_upright(rng: np.random.Generator) -> None:
    eye, target = rng.uniform(-3, 3, 3), rng.uniform(-3, 3, 3)
    pose = looking_at(eye, target)
    np.testing.assert_allclose(np.linalg.det(pose[:3, :3]), 1.0)
    np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose[:3, 3] + np.linalg.norm(target - eye) * pose[:3, 2], target)
    assert abs(pose[2, 0]) < 1e-12 and pose[2, 1] <= 0.0  # x is level, y goes down
    np.testing.assert_allclose(looking_at([0, 0, 3], [0, 0, 0])[:3, :3], np.diag([1.0, -1.0, -1.0]))


def test_right_eyes_masks_and_missing_pictures() -> None:
    places = np.array([[0, 1], [-1, 1]])
    kind = sensing_pb2.IMAGE_KIND_SEGMENTATION
    message = sensor_pb2.CameraReading(
        images=[
            sensor_pb2.Image(kind=kind, pixels=array_message(places, "<i4")),
            sensor_pb2.Image(kind=kind, right=True, pixels=array_message(places + 1, "<i4")),
        ],
        width=2,
        height=2,
        projection=sensing_pb2.CAMERA_PROJECTION_PINHOLE,
        element_names=["table", "wheel"],
        stereo_baseline_meters=0.1,
    )
    reading = camera_reading_of(message)
    assert reading.mask("wheel").tolist() == [[False, True], [False, True]]
    assert not reading.mask("door").any()
    assert reading.right is not None and reading.right.right is None
    assert reading.right.mask("wheel").tolist() == [[True, False], [False, False]]
    assert reading.color is None
    with pytest.raises(InvalidArgumentError, match=r"no depth: ask the camera for it by images=\['depth'\]"):
        reading.points()


def test_what_is_unknown_is_refused_with_what_is_known() -> None:
    with pytest.raises(InvalidArgumentError, match="'wide' is no projection: use pinhole, fisheye, spherical"):
        camera(projection="wide")
    with pytest.raises(InvalidArgumentError, match="'colour' is no kind of picture: use color, depth"):
        image_kinds(["colour"])
    with pytest.raises(InvalidArgumentError, match="'sun' is no kind of light: use point, spot, directional"):
        light("sun")
    with pytest.raises(InvalidArgumentError, match=r"shape \(3, 3\), not \(2, 2\)"):
        camera(camera_matrix=np.eye(2))
    with pytest.raises(InvalidArgumentError, match=r"without skew, not \[\[9.0, 0.1, 5.0\]"):
        camera(camera_matrix=[[9, 0.1, 5], [0, 9, 5], [0, 0, 1]])
    with pytest.raises(InvalidArgumentError, match="width is -5; it must be a whole number from 0 on"):
        camera(-5, 5)
    with pytest.raises(InvalidArgumentError, match="seed is -1; it must be a whole number"):
        camera(seed=-1)
    with pytest.raises(InvalidArgumentError, match="nowhere to look"):
        looking_at([1, 1, 1], [1, 1, 1])
    with pytest.raises(InvalidArgumentError, match=r"the eye has 3 finite numbers, not \[0.0, nan, 0.0\]"):
        looking_at([0, np.nan, 0], [1, 1, 1])
    with pytest.raises(InvalidArgumentError, match="it needs a direction"):
        looking_at([0, 0, 1], [1, 1, 1], up=[0, 0, 0])
