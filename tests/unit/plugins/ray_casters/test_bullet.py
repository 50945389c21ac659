"""The caster by PyBullet, beside the suite: many triangles, shapes that come and go, and where PyBullet is not."""

from __future__ import annotations

import sys

import numpy as np
import psutil
import pytest
from virtualrobot_plugins.ray_casters import bullet
from virtualrobot_plugins.ray_casters.bullet import BulletCaster
from virtualrobot_plugins.ray_casters.reference import ReferenceCaster
from virtualrobot_sdk.errors import PluginError
from virtualrobot_sdk.rays import RayScene, make_shape
from virtualrobot_sdk.testing.ray_truth import random_pose, random_rays, random_scene, sphere

from tests.pybullet_models import pybullet


@pytest.mark.long
def test_more_rays_and_triangles_than_it_takes_at_once(rng: np.random.Generator) -> None:
    shape = sphere(1.0, 7)
    assert len(shape.triangles) > 3 * bullet.TRIANGLES_AT_ONCE
    scene = RayScene((shape, shape), np.array([random_pose(rng, 2.0), random_pose(rng, 2.0)]))
    origins, directions = random_rays(rng, bullet.RAYS_AT_ONCE + 100, scene)
    found = BulletCaster().cast(scene, origins, directions, np.inf)
    some = np.r_[:20, -20:0]
    true = ReferenceCaster().cast(scene, origins[some], directions[some], np.inf)
    np.testing.assert_array_equal(found.element[some], true.element)
    # As near as the suite asks of it; the worst of 16,425 hits was 2e-8 m off.
    np.testing.assert_allclose(found.distance[some], true.distance, rtol=0.0, atol=1e-6)


@pytest.mark.long
def test_shapes_that_come_and_go_leave_little_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bullet, "MOST_UNUSED", 50_000)
    caster, process, base, sizes = BulletCaster(), psutil.Process(), sphere(1.0, 6), []
    for size in np.linspace(0.5, 1.5, 30):
        scene = RayScene((make_shape(base.vertices * size, base.triangles),), np.eye(4)[None])
        hits = caster.cast(scene, np.array([[0.0, 0.1, 3.0]]), np.array([[0.0, 0.0, -1.0]]), np.inf)
        assert hits.distance[0] == pytest.approx(3.0 - np.sqrt(size**2 - 0.01), abs=1e-3)
        sizes.append(process.memory_info().rss)
    # Bullet takes 5 to 8 MiB for each, and PyBullet keeps the 16386 empty lists: 1 MiB.
    assert sizes[-1] - sizes[9] < 20 * 3 << 20


def test_it_keeps_to_a_client_of_its_own(rng: np.random.Generator) -> None:
    others = pybullet.connect(pybullet.DIRECT)
    first, second = BulletCaster(), BulletCaster()
    scenes = [random_scene(rng, 5) for _ in range(2)]
    rays = random_rays(rng, 200, scenes[0])
    answers = [caster.cast(scene, *rays, np.inf) for caster, scene in zip((first, second), scenes, strict=True)]
    assert pybullet.getNumBodies(physicsClientId=others) == 0
    pybullet.disconnect(others)
    again = first.cast(scenes[0], *rays, np.inf)
    np.testing.assert_array_equal(answers[0].distance, again.distance)
    assert (answers[0].distance != answers[1].distance).any()


def test_where_pybullet_is_not_installed_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pybullet", None)
    with pytest.raises(PluginError, match=r"PyBullet cannot be imported \(it has packages for Python up to 3.11\)"):
        BulletCaster()
