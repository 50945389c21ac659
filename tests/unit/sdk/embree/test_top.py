"""Scenes of instances: placed, moved, exchanged, freed; hits against planes and against every ray on every triangle."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from virtualrobot_sdk.embree import EmbreeError, TopScene, unavailable
from virtualrobot_sdk.embree.leaves import leaves_in_use
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.rays import RayScene, Shape, make_shape
from virtualrobot_sdk.testing.ray_truth import box, plane, random_rays, random_scene, sphere

DOWN = np.array([[0.0, 0.0, -1.0]])


def at(*heights: float) -> np.ndarray:
    """Return poses (e, 4, 4) at these heights above the origin."""
    poses = np.repeat(np.eye(4)[None], len(heights), axis=0)
    poses[:, 2, 3] = heights
    return poses


def test_embree_is_there() -> None:
    assert unavailable() == ""


def test_hits_are_what_cast_finds_with_normals_to_the_origin(rng: np.random.Generator) -> None:
    others = random_scene(rng, 12)
    given = RayScene((*others.shapes, sphere(0.5, 2)), np.concatenate([others.world_t_element, np.eye(4)[None]]))
    origins, directions = random_rays(rng, 1000, given)
    origins[::10] = rng.uniform(-0.1, 0.1, (100, 3))  # in the ball: what is met from inside turns its normal
    with TopScene() as scene:
        scene.place(given.shapes, given.world_t_element)
        traced, hits = scene.cast(origins, directions, 4.0), scene.hits(origins, directions, 4.0)
    np.testing.assert_array_equal(hits.element, traced.element)
    np.testing.assert_array_equal(hits.triangle, traced.triangle)
    np.testing.assert_array_equal(hits.distance, traced.distance)
    slope = (traced.normal * directions).sum(axis=1, keepdims=True)
    assert 0 < (slope > 0.0).sum() < (slope != 0.0).sum() < 1000
    np.testing.assert_array_equal(hits.normal, np.where(slope > 0.0, -traced.normal, traced.normal))


def test_one_origin_serves_all_rays(rng: np.random.Generator) -> None:
    given = random_scene(rng, 8)
    origin, directions = rng.uniform(-1, 1, (1, 3)), random_rays(rng, 333, given)[1]
    with TopScene() as scene:
        scene.place(given.shapes, given.world_t_element)
        one, many = scene.cast(origin, directions), scene.cast(np.repeat(origin, 333, axis=0), directions)
        for name in ("distance", "element", "triangle", "uv", "normal"):
            np.testing.assert_array_equal(getattr(one, name), getattr(many, name))


def test_the_way_of_tracing_makes_no_difference(rng: np.random.Generator) -> None:
    """Rays that go along with each other are traced together, the same rays shuffled each alone."""
    given = random_scene(rng, 40)
    angles, rise = np.linspace(0.0, 8.0 * np.pi, 2000, endpoint=False), np.repeat([-0.6, -0.2, 0.2, 0.6], 500)
    directions = np.column_stack([np.cos(angles) * np.cos(rise), np.sin(angles) * np.cos(rise), np.sin(rise)])
    order = rng.permutation(2000)
    with TopScene() as scene:
        scene.place(given.shapes, given.world_t_element)
        together, alone = scene.cast(np.zeros((1, 3)), directions), scene.cast(np.zeros((1, 3)), directions[order])
    assert np.isfinite(together.distance).sum() > 100
    # An edge may be decided either way.
    same = together.element[order] == alone.element
    assert same.mean() > 0.99
    np.testing.assert_allclose(together.distance[order][same], alone.distance[same], rtol=1e-3)


@pytest.mark.parametrize("n", [0, 1, 15, 16, 17, 33])
def test_any_number_of_rays(n: int, rng: np.random.Generator) -> None:
    heights = rng.uniform(1.0, 5.0, n)
    origins = np.column_stack([rng.uniform(-0.9, 0.9, (n, 2)), heights])
    with TopScene() as scene:
        scene.place((plane(2.0),), at(0.0))
        found = scene.cast(origins, np.repeat(DOWN, n, axis=0))
        blocked = scene.occluded(origins, np.repeat(DOWN, n, axis=0), heights + 0.01)
    np.testing.assert_allclose(found.distance, heights, rtol=1e-6)
    assert found.normal.tolist() == [[0.0, 0.0, 1.0]] * n
    assert blocked.tolist() == [True] * n


def test_occluded_agrees_with_cast(rng: np.random.Generator) -> None:
    given = random_scene(rng, 12)
    origins, directions = random_rays(rng, 1000, given)
    with TopScene() as scene:
        scene.place(given.shapes, given.world_t_element)
        found = scene.cast(origins, directions)
        is_hit = np.isfinite(found.distance)
        assert 100 < is_hit.sum() < 1000
        np.testing.assert_array_equal(scene.occluded(origins, directions, np.full(1000, np.inf)), is_hit)
        np.testing.assert_array_equal(scene.occluded(origins, directions, found.distance * 1.001), is_hit)
        assert not scene.occluded(origins, directions, np.where(is_hit, found.distance * 0.999, 50.0)).any()


def test_thousands_of_elements() -> None:
    with TopScene() as scene:
        poses = at(*np.zeros(4000))
        poses[:, 0, 3] = 3.0 * np.arange(4000)
        scene.place((plane(2.0),) * 4000, poses)
        origins = poses[:, :3, 3] + (0.3, 0.2, 1.0)
        assert scene.cast(origins, np.repeat(DOWN, 4000, axis=0)).element.tolist() == list(range(4000))


@pytest.mark.parametrize(
    ("shape", "said"),
    [
        (make_shape([[0, 0, 0], [1, 0, 0], [0, 1, np.nan]], [[0, 1, 2]]), r"vertex 2 .* nan"),
        (make_shape([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]]), r"triangle 1 .* \[0, 1, 3\].* 0 to 2"),
        (make_shape([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[-1, 1, 2]]), r"triangle 0"),
        (make_shape([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]]), r"vertices .* \(3, 2\)"),
    ],
)
def test_what_is_no_shape_is_refused_and_nothing_changes(shape: Shape, said: str) -> None:
    with TopScene() as scene:
        scene.place((plane(2.0),), at(1.0))
        with pytest.raises(ArgumentError, match=said):
            scene.place((plane(2.0), shape), at(0.0, 0.0))
        assert scene.cast(np.array([[0.1, 0.2, 3.0]]), DOWN).distance[0] == pytest.approx(2.0)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_poses_must_be_finite(value: float) -> None:
    with TopScene() as scene, pytest.raises(ArgumentError, match=r"pose of element 1 .* finite"):
        scene.place((plane(2.0), plane(2.0)), at(0.0, value))


def test_arrays_of_other_shapes_are_refused() -> None:
    with TopScene() as scene:
        for origins, directions in ((np.zeros((3, 3)), np.zeros((2, 3))), (np.zeros((2, 2)), np.zeros((2, 2)))):
            with pytest.raises(ArgumentError, match="must be"):
                scene.cast(origins, directions)
        with pytest.raises(ArgumentError, match=r"distances of shape \(3,\)"):
            scene.occluded(np.zeros((2, 3)), np.repeat(DOWN, 2, axis=0), np.zeros(3))
        with pytest.raises(ArgumentError, match=r"poses of 1 elements"):
            scene.place((plane(1.0),), np.eye(4))


def test_rays_that_are_not_finite_meet_nothing() -> None:
    directions = np.repeat(DOWN, 20, axis=0)
    origins = np.repeat([[0.1, 0.2, 1.0]], 20, axis=0)
    directions[3, 1], origins[7, 0] = np.nan, np.inf
    with TopScene() as scene:
        scene.place((plane(2.0),), at(0.0))
        found = scene.cast(origins, directions)
    assert np.flatnonzero(found.element == -1).tolist() == [3, 7]


def test_shapes_are_kept_once_and_freed_with_the_last_scene(rng: np.random.Generator) -> None:
    gc.collect()
    before = leaves_in_use()
    shapes = tuple(box(rng.uniform(0.2, 1.5, 3)) for _ in range(3))
    first, second = TopScene(), TopScene()
    first.place((*shapes, shapes[0]), at(0, 1, 2, 3))
    second.place(shapes, at(0, 1, 2))
    assert leaves_in_use() == before + 3
    first.close()
    assert leaves_in_use() == before + 3
    second.place(shapes[:1], at(0))
    assert leaves_in_use() == before + 1
    second.close()
    second.close()
    assert leaves_in_use() == before
    with pytest.raises(EmbreeError, match="closed"):
        second.cast(np.zeros((1, 3)), DOWN)
