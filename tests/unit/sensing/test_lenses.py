"""Lenses against OpenCV's own projections, and against what a field of view means."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from virtualrobot_kernel.sensing.lenses import lens_of, pinhole
from virtualrobot_kernel.world.sensing import CameraSensor, Intrinsics, Projection


def matrix(intrinsics: Intrinsics) -> np.ndarray:
    return np.array([[intrinsics.fx, 0.0, intrinsics.cx], [0.0, intrinsics.fy, intrinsics.cy], [0.0, 0.0, 1.0]])


def places(pixels: np.ndarray, width: int) -> np.ndarray:
    return np.stack([pixels % width, pixels // width], axis=1)


@pytest.mark.parametrize("count", [0, 4, 5, 8])
def test_a_pinholes_rays_are_projected_to_their_pixels_by_opencv(count: int, rng: np.random.Generator) -> None:
    width, height = 160, 120
    shares = []
    for _ in range(10):
        scale = np.array([0.3, 0.15, 0.01, 0.01, 0.05, 0.2, 0.05, 0.02])[:count]
        distortion = rng.uniform(-scale, scale)
        focal = rng.uniform(100.0, 300.0, 2)
        middle = rng.uniform([60.0, 40.0], [100.0, 80.0])
        lens = lens_of(
            CameraSensor(width, height, intrinsics=Intrinsics(*focal, *middle), distortion=tuple(distortion.tolist()))
        )
        seen = np.isfinite(lens.directions).all(axis=1)
        shares.append(seen.mean())
        np.testing.assert_allclose(np.linalg.norm(lens.directions[seen], axis=1), 1.0, atol=1e-6)
        points = lens.directions[seen].astype(np.float64)[:, None]
        none = np.zeros(3)
        projected, _ = cv2.projectPoints(points, none, none, matrix(lens.intrinsics), distortion if count else None)
        # A direction of single precision is within 1e-7 rad; at most 300 pixels a radian, distorted a few times.
        np.testing.assert_allclose(projected[:, 0], places(lens.pixels, width)[seen], atol=1e-3)
    assert np.median(shares) > 0.9, "a strong distortion folds the corners of some pictures, not of most"


def test_a_fisheyes_rays_are_projected_to_their_pixels_by_opencv(rng: np.random.Generator) -> None:
    for _ in range(10):
        distortion = tuple(rng.uniform(-1, 1, 4) * [0.05, 0.02, 0.005, 0.001])
        lens = lens_of(CameraSensor(160, 120, Projection.FISHEYE, horizontal_field_radians=2.5, distortion=distortion))
        # OpenCV's model takes points before the camera only.
        seen = lens.directions[:, 2] > 0.05
        assert seen.mean() > 0.5
        points = lens.directions[seen].astype(np.float64)[:, None]
        none = np.zeros(3)
        projected, _ = cv2.fisheye.projectPoints(points, none, none, matrix(lens.intrinsics), np.array(distortion))
        np.testing.assert_allclose(projected[:, 0], places(lens.pixels, 160)[seen], atol=1e-3)


def test_a_barrel_is_not_looked_into_beyond_where_it_turns_back() -> None:
    # r - r^3 / 3 is greatest at r = 1, where it is 2/3: what lies farther out in the picture has no direction.
    lens = lens_of(CameraSensor(201, 201, intrinsics=Intrinsics(100, 100, 100, 100), distortion=(-1 / 3, 0, 0, 0)))
    radius = np.hypot(*(places(lens.pixels, 201) - 100.0).T) / 100.0
    seen = np.isfinite(lens.directions[:, 0])
    assert seen[radius < 0.66].all()
    assert not seen[radius > 2 / 3].any()
    inner = lens.directions[seen]
    assert (np.hypot(inner[:, 0], inner[:, 1]) / inner[:, 2]).max() <= 1.0


def test_the_field_of_view_is_between_the_edges_of_the_picture(rng: np.random.Generator) -> None:
    field = rng.uniform(0.3, 2.5)
    lens = lens_of(CameraSensor(100, 60, horizontal_field_radians=field))
    left = (-0.5 - lens.intrinsics.cx) / lens.intrinsics.fx
    right = (99.5 - lens.intrinsics.cx) / lens.intrinsics.fx
    assert math.atan(right) - math.atan(left) == pytest.approx(field)
    view = pinhole(100, 60, field)
    assert 2.0 * math.atan(30.0 / view.intrinsics.fy) == pytest.approx(field)
    assert view.intrinsics.fx == pytest.approx(view.intrinsics.fy)


def test_a_fisheye_is_equidistant() -> None:
    lens = lens_of(CameraSensor(101, 101, Projection.FISHEYE, horizontal_field_radians=math.pi))
    angle = np.arccos(np.clip(lens.directions[:, 2].astype(float), -1.0, 1.0))
    radius = np.linalg.norm(places(lens.pixels, 101) - [50.0, 50.0], axis=1)
    np.testing.assert_allclose(angle, radius * math.pi / 101.0, atol=1e-3)


def test_a_spherical_picture_has_longitudes_and_latitudes() -> None:
    lens = lens_of(CameraSensor(64, projection=Projection.SPHERICAL))
    assert (lens.width, lens.height) == (64, 32)
    assert lens.intrinsics.fx == pytest.approx(64 / (2.0 * math.pi))
    place = places(lens.pixels, 64)
    longitude = (place[:, 0] + 0.5) / 64 * 2.0 * math.pi - math.pi
    latitude = (place[:, 1] + 0.5) / 32 * math.pi - math.pi / 2.0  # downwards, as y is
    along = np.stack(
        [np.cos(latitude) * np.sin(longitude), np.sin(latitude), np.cos(latitude) * np.cos(longitude)], axis=1
    )
    np.testing.assert_allclose(lens.directions, along, atol=1e-6)
    # Beyond the poles there is nowhere to look.
    high = lens_of(CameraSensor(64, 48, Projection.SPHERICAL))
    assert np.isnan(high.directions).any(axis=1).mean() == pytest.approx(1.0 / 3.0)


def test_each_pixel_has_one_ray_and_packets_are_tiles() -> None:
    lens = lens_of(CameraSensor(13, 10))
    assert sorted(lens.pixels.tolist()) == list(range(130))
    tile = places(lens.pixels[:16], 13)
    assert np.ptp(tile, axis=0).tolist() == [3, 3]


def test_a_pinhole_finds_what_tangential_distortion_moves_near_the_fold(rng: np.random.Generator) -> None:
    """Forward through OpenCV and back: the picture is one to one from the middle to each of these places."""
    distortion = np.array([1.24515378, 0.02305934, 0.0013981, 0.00266724, -0.03075826])
    angles = rng.uniform(0.0, 2.0 * math.pi, 200)
    points = np.stack([1.22 * np.cos(angles), 1.22 * np.sin(angles), np.ones(200)], axis=1)
    projected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), distortion)
    for (x, y, _), (u, v) in zip(points.tolist(), projected[:, 0].tolist(), strict=True):
        lens = lens_of(CameraSensor(1, 1, intrinsics=Intrinsics(1.0, 1.0, -u, -v), distortion=tuple(distortion)))
        direction = lens.directions[0].astype(np.float64)
        np.testing.assert_allclose(direction[:2] / direction[2], [x, y], atol=1e-5)


@pytest.mark.parametrize("focal", [1e-300, 1e-150, 1e-40, 1e-20])
def test_what_is_across_a_pinhole_is_not_seen(focal: float) -> None:
    lens = lens_of(CameraSensor(9, 9, intrinsics=Intrinsics(focal, focal, 4.0, 4.0)))
    seen = np.isfinite(lens.directions).all(axis=1)
    assert lens.pixels[seen].tolist() == [40], "its middle"
    assert np.isfinite(lens.reach)
