"""Triangles against what they stand for: plane, box and torus; and that no ray slips through an edge."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_sdk.embree import TopScene, Traced
from virtualrobot_sdk.rays import Shape, make_shape
from virtualrobot_sdk.testing.ray_truth import box, plane, random_pose, sphere

RAYS = 4000


def traced(shape: Shape, pose: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> Traced:
    """Cast rays of the shape's own frame."""
    with TopScene() as scene:
        scene.place((shape,), pose[None])
        return scene.cast(origins @ pose[:3, :3].T + pose[:3, 3], directions @ pose[:3, :3].T)


def units(rng: np.random.Generator, n: int) -> np.ndarray:
    vectors = rng.normal(size=(n, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def test_plane(rng: np.random.Generator) -> None:
    pose, origins, directions = random_pose(rng, 2.0), rng.uniform(-3.0, 3.0, (RAYS, 3)), units(rng, RAYS)
    found = traced(plane(4.0), pose, origins, directions)
    along = -origins[:, 2] / directions[:, 2]
    beside = np.abs(origins + along[:, None] * directions)[:, :2].max(axis=1)
    sure = (np.abs(beside - 2.0) > 1e-3) & (np.abs(directions[:, 2]) > 1e-2) & (np.abs(origins[:, 2]) > 1e-5)
    expected = np.where((along > 0.0) & (beside < 2.0), along, np.inf)
    assert np.isfinite(expected).sum() > 200
    np.testing.assert_array_equal(np.isfinite(found.distance)[sure], np.isfinite(expected)[sure])
    both = sure & np.isfinite(expected)
    off = np.abs(found.distance[both] - expected[both]) * np.abs(directions[both, 2])
    assert off.max() < 5e-6
    np.testing.assert_allclose(found.normal[both] @ pose[:3, 2], 1.0, atol=1e-6)


def test_box_from_outside_and_inside(rng: np.random.Generator) -> None:
    """The ray is in the box between the last plane that it enters by and the first that it leaves by: slabs."""
    sides, pose, directions = rng.uniform(0.3, 3.0, 3), random_pose(rng, 2.0), units(rng, RAYS)
    is_inside = np.arange(RAYS) % 2 == 0
    aims = rng.uniform(-0.499, 0.499, (RAYS, 3)) * sides  # what starts on a face may start outside
    origins = aims - np.where(is_inside, 0.0, 6.0)[:, None] * directions
    one, other = (-sides / 2 - origins) / directions, (sides / 2 - origins) / directions
    enters, leaves = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
    expected = np.where(is_inside, leaves, enters)
    passes = np.where(is_inside[:, None], np.maximum(one, other), np.minimum(one, other))
    face = passes == expected[:, None]
    found = traced(box(sides), pose, origins, directions)
    assert (found.element == 0).all()
    slant = np.abs(directions[face])
    sure = (np.abs(passes - expected[:, None]) < 1e-3).sum(axis=1) == 1  # not at an edge
    assert sure.mean() > 0.9
    assert (np.abs(found.distance - expected) * slant)[sure].max() < 1e-5
    outwards = (found.normal @ pose[:3, :3])[face]
    np.testing.assert_allclose(np.abs(outwards)[sure], 1.0, atol=1e-5)
    assert (np.sign(outwards * directions[face]) == np.where(is_inside, 1, -1))[sure].all()


def torus(ring: float, tube: float, around: int, across: int) -> Shape:
    """Return a torus about z whose corners are on it."""
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    far = ring + tube * np.cos(v)
    corners = np.stack([far * np.cos(u), far * np.sin(u), tube * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(around), np.arange(across), indexing="ij"))
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    return make_shape(corners, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]))


def test_torus_within_the_error_of_its_facets(rng: np.random.Generator) -> None:
    """Triangles are within k R^2 / 2 of the torus, where k is its greatest curvature, R the radius around a triangle.

    S. Waldron, The error in linear interpolation at the vertices of a simplex, SIAM J. Numer. Anal. 35, 1998. R is at
    most L / sqrt 3 where L is the longest side and no angle is blunt.
    """
    ring, tube = 1.0, 0.3
    shape = torus(ring, tube, 96, 48)
    corners = shape.vertices[shape.triangles].astype(float)
    longest = np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).max()
    error = max(1 / tube, 1 / (ring - tube)) * longest**2 / 6 + 1e-5
    assert error < 6e-3
    directions = units(rng, RAYS)
    origins = rng.uniform(-1.2, 1.2, (RAYS, 3)) - 5.0 * directions
    found = traced(shape, random_pose(rng, 2.0), origins, directions)

    def outside(along: np.ndarray) -> np.ndarray:
        x, y, z = (origins + along[:, None] * directions).T
        return np.hypot(np.hypot(x, y) - ring, z) - tube

    is_hit = np.isfinite(found.distance)
    assert is_hit.sum() > 500
    assert np.abs(outside(np.where(is_hit, found.distance, 0.0)))[is_hit].max() < error
    for part in np.linspace(0.0, 1.0, 300):
        assert outside(part * np.where(is_hit, found.distance, 9.0)).min() > -error


@pytest.mark.parametrize("shuffled", [False, True], ids=["together", "alone"])
def test_no_ray_slips_through_an_edge(shuffled: bool, rng: np.random.Generator) -> None:
    """From inside a closed mesh all rays towards its very edges meet it; without the robust mode one in 60 does not.

    Towards a corner, where six triangles meet in a point, one in ten thousand slips through.
    """
    shape = sphere(1.0, 4)
    corners = shape.vertices.astype(float)
    first, second = corners[shape.triangles], corners[np.roll(shape.triangles, 1, axis=1)]
    part = rng.uniform(0.001, 0.999, first.shape[:2])[..., None]
    aims = (part * first + (1 - part) * second).reshape(-1, 3)
    aims = rng.permutation(aims) if shuffled else aims[np.lexsort(np.round(aims, 1).T)]
    inside, pose = rng.uniform(-0.3, 0.3, 3), random_pose(rng, 2.0)
    for goals, slipping in ((aims, 0), (corners, 0.01 * len(corners))):
        directions = (goals - inside) / np.linalg.norm(goals - inside, axis=1, keepdims=True)
        found = traced(shape, pose, np.repeat(inside[None], len(goals), axis=0), directions)
        away = ~(np.abs(found.distance - np.linalg.norm(goals - inside, axis=1)) < 1e-5)
        assert away.sum() <= slipping
