"""What is shown of sensors: places by formula, colours by the published table of Turbo."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from virtualrobot_kernel.sensing.overlays import (
    MISS_COLOR,
    MISS_LENGTH,
    PointColor,
    colored,
    frustum_of,
    scan_points,
    scan_rays,
    shrunk,
    turbo,
)
from virtualrobot_kernel.world.sensing import CameraSensor, ImageKind, Intrinsics, Projection


@dataclass
class Beams:
    origins: np.ndarray
    directions: np.ndarray


@dataclass
class Scan:
    distances: np.ndarray
    valid: np.ndarray
    intensities: np.ndarray
    beams: Beams


def fan(distances: list[float], valid: list[int], origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Scan:
    """Return a scan (1, n) over a quarter turn, whose echoes grow in strength."""
    angles = np.linspace(0.0, math.pi / 2, len(distances))
    directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=1)
    strengths = np.linspace(0.0, 1.0, len(distances))
    return Scan(
        np.array([distances], np.float32),
        np.array([valid], np.uint8),
        np.array([strengths], np.float32),
        Beams(np.array([origin]), directions),
    )


def test_turbo_is_turbo() -> None:
    """Some of the 256 colours of Mikhailov's table; the polynomials are within 32 of it."""
    published = {0: (48, 18, 59), 64: (40, 188, 235), 128: (164, 252, 60), 192: (251, 126, 33), 255: (122, 4, 3)}
    colors = turbo(np.array(list(published)) / 255.0).astype(int)
    assert np.abs(colors - np.array(list(published.values()))).max() <= 32
    assert (turbo(np.array([-1.0, 2.0])) == turbo(np.array([0.0, 1.0]))).all()


def test_points_stand_where_the_echoes_are() -> None:
    points, colors = scan_points(fan([1.0, 9.0, 3.0], [1, 0, 1], (0.5, 0.0, 0.0)), PointColor.DISTANCE)
    np.testing.assert_allclose(points, [[1.5, 0.0, 0.0], [0.5, 3.0, 0.0]], atol=1e-6)
    assert (colors == turbo(np.array([0.0, 1.0]))).all()
    _, colors = scan_points(fan([1.0, 9.0, 3.0], [1, 1, 0]), PointColor.INTENSITY)
    assert (colors == turbo(np.array([0.0, 0.5]))).all()


def test_rays_end_at_echoes_and_soon_without_one() -> None:
    segments, colors = scan_rays(fan([2.0, math.inf], [1, 0]), PointColor.DISTANCE)
    np.testing.assert_allclose(segments[0], [[0, 0, 0], [2, 0, 0]], atol=1e-6)
    np.testing.assert_allclose(segments[1], [[0, 0, 0], [0, MISS_LENGTH, 0]], atol=1e-6)
    assert tuple(colors[1]) == MISS_COLOR and tuple(colors[0]) == tuple(turbo(np.zeros(1))[0])


@pytest.mark.parametrize("count", [0, 1, 99, 100, 101, 1000])
def test_many_are_thinned_evenly(count: int) -> None:
    scan = fan([1.0] * count, [1] * count)
    points, colors = scan_points(scan, PointColor.DISTANCE, most=100)
    segments, _ = scan_rays(scan, PointColor.DISTANCE, most=100)
    assert len(points) == len(colors) == len(segments) <= 100
    assert len(points) >= min(count, 50)


def test_a_pinhole_sees_what_its_field_says() -> None:
    frustum = frustum_of(CameraSensor(width=800, height=400, horizontal_field_radians=1.2))
    assert frustum is not None and frustum.aspect == pytest.approx(2.0)
    assert frustum.right == pytest.approx(math.tan(0.6)) and frustum.left == pytest.approx(-math.tan(0.6))
    assert frustum.vertical_field == pytest.approx(2.0 * math.atan(0.5 * math.tan(0.6)))
    lines = frustum.lines(2.0)
    np.testing.assert_allclose(lines[:4, 0], 0.0)
    np.testing.assert_allclose(np.abs(lines[:4, 1, 0]), 2.0 * math.tan(0.6), rtol=1e-6)
    assert (lines[:8].reshape(-1, 3)[1::2, 2] == 2.0).all()


def test_intrinsics_may_be_beside_the_middle() -> None:
    """(0, 0) is the middle of the upper left pixel, so the picture begins half a pixel before it."""
    frustum = frustum_of(CameraSensor(width=100, height=50, intrinsics=Intrinsics(100.0, 50.0, 9.5, 24.5)))
    assert frustum is not None
    assert (frustum.left, frustum.right) == pytest.approx((-0.1, 0.9))
    assert (frustum.top, frustum.bottom) == pytest.approx((-0.5, 0.5))


def test_what_sees_all_around_has_no_pyramid() -> None:
    assert frustum_of(CameraSensor(projection=Projection.SPHERICAL)) is None
    assert frustum_of(CameraSensor(projection=Projection.FISHEYE, horizontal_field_radians=3.5)) is None
    assert frustum_of(CameraSensor(projection=Projection.FISHEYE, horizontal_field_radians=1.0)) is not None


def test_pictures_of_every_kind_can_be_seen(rng: np.random.Generator) -> None:
    color = rng.integers(0, 256, (4, 6, 3)).astype(np.uint8)
    assert (colored(ImageKind.COLOR, color) == color).all()
    depth = colored(ImageKind.DEPTH, np.array([[1.0, np.inf], [2.0, 3.0]], np.float32))
    assert tuple(depth[0, 1]) == MISS_COLOR and (depth[1, 1] == turbo(np.ones(1))[0]).all()
    parts = colored(ImageKind.SEGMENTATION, np.array([[-1, 0], [1, 1]], np.int32))
    assert tuple(parts[0, 0]) == MISS_COLOR and (parts[1, 0] == parts[1, 1]).all()
    assert (parts[0, 1] != parts[1, 0]).any()
    assert tuple(colored(ImageKind.NORMALS, np.array([[[1.0, -1.0, 0.0]]], np.float32))[0, 0]) == (255, 0, 128)
    assert shrunk(np.zeros((480, 640, 3), np.uint8), 320).shape == (240, 320, 3)
    assert shrunk(np.zeros((30, 20, 3), np.uint8), 320).shape == (30, 20, 3)
