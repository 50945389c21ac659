"""Pictures against what formulas say of planes, spheres and boxes, and against single rays."""

from __future__ import annotations

import math

import numpy as np
import pytest
from virtualrobot_kernel.sensing.lenses import lens_of
from virtualrobot_kernel.sensing.picture import Picture, render
from virtualrobot_kernel.world.figures import Box, Sphere
from virtualrobot_kernel.world.sensing import CameraSensor, ImageKind, Projection

from tests.unit.sensing.studio import at, looking, studio

MEASURED = (ImageKind.DEPTH, ImageKind.SEGMENTATION, ImageKind.NORMALS)
GREEN = (0.2, 0.8, 0.3, 1.0)


def measured(picture: Picture) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    assert picture.depth is not None and picture.segmentation is not None and picture.normals is not None
    return picture.depth, picture.segmentation, picture.normals


def test_only_what_is_asked_for_is_taken() -> None:
    with studio([(Box((1, 1, 1)), at(0, 0, 0), None)]) as (scene, subject):
        lens = lens_of(CameraSensor(16, 12))
        picture = render(scene, subject, lens, at(0, 0, -3), [ImageKind.DEPTH])
        assert picture.color is None and picture.segmentation is None and picture.normals is None
        assert picture.depth is not None and picture.depth.shape == (12, 16)


def test_depth_of_a_plane_is_its_distance_along_z(rng: np.random.Generator) -> None:
    # A plane n . x = d is met by the ray t r at t = d / (n . r); depth is t r_z.
    lens = lens_of(CameraSensor(64, 48, distortion=(-0.2, 0.05, 0.001, 0.002)))
    camera = looking(rng.uniform([-2, -2, 3], [2, 2, 7]), rng.uniform(-1, 1, 3))
    with studio([(Box((100, 100, 1)), at(0, 0, -0.5), None)]) as (scene, subject):
        depth, segmentation, normals = measured(render(scene, subject, lens, camera, MEASURED))
    upward = camera[:3, :3].T @ [0, 0, 1]
    rays = np.empty((64 * 48, 3))
    rays[lens.pixels] = lens.directions
    expected = -camera[2, 3] / (rays @ upward) * rays[:, 2]
    met = segmentation.ravel() == 0
    assert met.all()
    np.testing.assert_allclose(depth.ravel(), expected, rtol=1e-5)
    np.testing.assert_allclose(normals.reshape(-1, 3), np.tile(upward, (len(rays), 1)), atol=1e-6)


def test_depth_and_normals_of_a_sphere(rng: np.random.Generator) -> None:
    # |t r - c| = R: t = r . c - sqrt((r . c)^2 - c . c + R^2)
    lens = lens_of(CameraSensor(80, 60))
    center, radius = np.array([0.1, -0.2, 3.0]), 0.8
    camera = looking(rng.uniform(-5, 5, 3), rng.uniform(-1, 1, 3))
    with studio([(Sphere(radius), at(*(camera[:3, :3] @ center + camera[:3, 3])), None)]) as (scene, subject):
        depth, segmentation, normals = measured(render(scene, subject, lens, camera, MEASURED))
    rays = np.empty((80 * 60, 3))
    rays[lens.pixels] = lens.directions
    along = rays @ center
    root = along**2 - center @ center + radius**2
    clear = np.abs(root) > 1e-4  # the rim is for neither to decide
    assert ((segmentation.ravel() == 0) == (root > 0))[clear].all()
    met = clear & (root > 0)
    way = along[met] - np.sqrt(root[met])
    # Near the rim the way depends on the root of a small difference: 1e-6 of 10 within a root of 1e-4.
    np.testing.assert_allclose(depth.ravel()[met], way * rays[met, 2], atol=1e-3)
    np.testing.assert_allclose(np.median(np.abs(depth.ravel()[met] - way * rays[met, 2])), 0.0, atol=5e-6)
    np.testing.assert_allclose(normals.reshape(-1, 3)[met], (way[:, None] * rays[met] - center) / radius, atol=2e-3)
    nothing = segmentation == -1
    assert np.isinf(depth[nothing]).all() and (normals[nothing] == 0).all()


def test_a_picture_tells_what_single_rays_tell(rng: np.random.Generator) -> None:
    things = [
        (Box(tuple(rng.uniform(0.2, 0.6, 3))), looking(rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3)), None)
        for _ in range(20)
    ]
    camera = looking([0, -4, 1], [0, 0, 0])
    lens = lens_of(CameraSensor(64, 48))
    beside = np.array([[0, 0, 0], [1e-5, 0, 0], [-1e-5, 0, 0], [0, 1e-5, 0], [0, -1e-5, 0]])
    with studio(things) as (scene, subject):
        depth, segmentation, _ = measured(render(scene, subject, lens, camera, MEASURED))
        compared = 0
        for pixel in rng.integers(0, 64 * 48, 200):
            rays = lens.directions[lens.pixels == pixel].astype(float) + beside
            traced = scene.cast(np.tile(camera[:3, 3], (len(rays), 1)), rays @ camera[:3, :3].T, 100.0)
            if len(set(traced.element.tolist())) > 1:
                continue  # at an edge rounding decides
            far = traced.distance * rays[:, 2]
            assert segmentation.ravel()[pixel] == traced.element[0]
            assert far.min() * (1 - 1e-5) <= depth.ravel()[pixel] <= far.max() * (1 + 1e-5)
            compared += 1
    assert compared > 180


def test_spherical_and_fisheye_depth_is_along_the_ray() -> None:
    for projection in (Projection.SPHERICAL, Projection.FISHEYE):
        lens = lens_of(CameraSensor(64, 64, projection, horizontal_field_radians=2.0 * math.pi))
        with studio([(Sphere(2.0), at(0, 0, 0), None)]) as (scene, subject):
            picture = render(scene, subject, lens, at(0, 0, 0), [ImageKind.DEPTH, ImageKind.NORMALS])
        assert picture.depth is not None and picture.normals is not None
        seen = np.isfinite(picture.depth)
        np.testing.assert_allclose(picture.depth[seen], 2.0, rtol=1e-5)
        rays = np.empty((64 * 64, 3))
        rays[lens.pixels] = lens.directions
        # From within, the normal that is turned to the camera is the ray's opposite.
        np.testing.assert_allclose(picture.normals[seen], -rays.reshape(64, 64, 3)[seen], atol=1e-5)
        assert seen.mean() == pytest.approx(np.isfinite(lens.directions).all(axis=1).mean())


@pytest.mark.parametrize("projection", [Projection.PINHOLE, Projection.FISHEYE])
def test_near_and_far_cut(projection: Projection) -> None:
    walls = [(Box((50, 50, 0.2)), at(0, 0, z), None) for z in (1.0, 2.0, 4.0)]
    lens = lens_of(CameraSensor(32, 32, projection, 0.4, near_meters=1.5, far_meters=3.0))
    with studio(walls) as (scene, subject):
        depth, segmentation, _ = measured(render(scene, subject, lens, at(0, 0, 0), MEASURED))
        assert (segmentation == 1).all()
        assert depth.min() == pytest.approx(1.9, abs=0.01)
        short = lens_of(CameraSensor(32, 32, projection, 0.4, near_meters=1.5, far_meters=1.8))
        depth, segmentation, _ = measured(render(scene, subject, short, at(0, 0, 0), MEASURED))
        assert (segmentation == -1).all() and np.isinf(depth).all()


def test_an_empty_scene_shows_the_background_and_a_lens_that_looks_nowhere_black() -> None:
    lens = lens_of(CameraSensor(64, 48, Projection.SPHERICAL))
    with studio([], background=(0.9, 0.5, 0.1)) as (scene, subject):
        picture = render(scene, subject, lens, np.eye(4), list(ImageKind))
    assert picture.color is not None and picture.segmentation is not None
    assert (picture.segmentation == -1).all()
    assert (picture.color[:8] == 0).all() and (picture.color[40:] == 0).all()
    np.testing.assert_allclose(picture.color[8:40].reshape(-1, 3), np.tile([229.5, 127.5, 25.5], (32 * 64, 1)), atol=1)
