"""Curved surfaces against their equations, from outside and inside: to 1e-6 of how far a ray goes."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_sdk.embree import TopScene, Traced
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.rays import Primitive, Round, Shape, make_shape

RAYS = 4000
FAR = 20.0
"""How far away rays start at most (m)."""


def curved(primitive: Primitive) -> Shape:
    """Return a shape whose triangles are elsewhere: they are not to be met."""
    return make_shape([[50, 0, 0], [51, 0, 0], [50, 1, 0]], [[0, 1, 2]], primitive)


def some(kind: Round, rng: np.random.Generator) -> Primitive:
    return Primitive(kind, rng.uniform(0.1, 2.0), 0.0 if kind is Round.SPHERE else rng.uniform(0.1, 3.0))


def outside(primitive: Primitive, points: np.ndarray) -> np.ndarray:
    """Return (n,) how far points (n, 3) are outside a surface, negative inside: signed distances by I. Quilez.

    Of the cone it is the largest of the distances from base and mantle, which has the same sign and zeros.
    """
    x, y, z = points.T
    axis, half, radius = np.hypot(x, y), primitive.length / 2, primitive.radius
    match primitive.kind:
        case Round.SPHERE:
            return np.hypot(axis, z) - radius
        case Round.CYLINDER:
            return np.maximum(axis - radius, np.abs(z) - half)
        case Round.CONE:
            slant = np.hypot(radius, primitive.length)
            return np.maximum((primitive.length * axis - radius * (half - z)) / slant, -half - z)
        case Round.CAPSULE:
            return np.hypot(axis, np.maximum(np.abs(z) - half, 0.0)) - radius


def rays_at(primitive: Primitive, rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return rays in the frame of the surface: half from outside towards it, half from within it, none from on it."""
    size = primitive.radius + primitive.length / 2
    height = primitive.length / 2 if primitive.kind in (Round.CYLINDER, Round.CONE) else size
    aims = rng.uniform(-1.0, 1.0, (n, 3)) * (primitive.radius, primitive.radius, height)
    directions = rng.normal(size=(n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    is_far = (np.arange(n) % 2 == 0) | (np.abs(outside(primitive, aims)) < 1e-5)
    away = np.where(is_far, rng.uniform(2.0 * size, FAR, n), 0.0)
    return aims - away[:, None] * directions, directions


def traced(primitive: Primitive, pose: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> Traced:
    with TopScene() as scene:
        scene.place((curved(primitive),), pose[None])
        return scene.cast(origins, directions)


@pytest.mark.parametrize("kind", Round, ids=lambda kind: kind.value)
def test_occluded_agrees_with_cast(kind: Round, rng: np.random.Generator) -> None:
    primitive = some(kind, rng)
    origins, directions = rays_at(primitive, rng, RAYS)
    with TopScene() as scene:
        scene.place((curved(primitive),), np.eye(4)[None])
        distance = scene.cast(origins, directions).distance
        is_hit = np.isfinite(distance)
        np.testing.assert_array_equal(scene.occluded(origins, directions, np.full(RAYS, np.inf)), is_hit)
        np.testing.assert_array_equal(scene.occluded(origins, directions, distance + 1e-3), is_hit)
        assert not scene.occluded(origins, directions, np.maximum(distance - 1e-3, 0.0))[is_hit].any()


KNOWN = [
    # By hand: primitive, origin, direction, distance, normal.
    (Primitive(Round.SPHERE, 1.0), (-3, 0, 0), (1, 0, 0), 2.0, (-1, 0, 0)),
    (Primitive(Round.SPHERE, 1.0), (0, 0, 0), (0, 0, 1), 1.0, (0, 0, 1)),
    (Primitive(Round.CYLINDER, 1.0, 1.0), (0.5, 0, 3), (0, 0, -1), 2.5, (0, 0, 1)),
    (Primitive(Round.CYLINDER, 1.0, 1.0), (0.5, 0, -3), (0, 0, 1), 2.5, (0, 0, -1)),
    (Primitive(Round.CYLINDER, 1.0, 1.0), (0.5, 0, 0.25), (0, 0, 1), 0.25, (0, 0, 1)),
    (Primitive(Round.CYLINDER, 1.0, 1.0), (0, -4, 0.4), (0, 1, 0), 3.0, (0, -1, 0)),
    (Primitive(Round.CYLINDER, 1.0, 1.0), (0, -4, 0.6), (0, 1, 0), np.inf, (0, 0, 0)),
    (Primitive(Round.CYLINDER, 1.0, 1.0), (1.5, 0, 3), (0, 0, -1), np.inf, (0, 0, 0)),
    (Primitive(Round.CONE, 1.0, 2.0), (0, 0, 4), (0, 0, -1), 3.0, None),  # onto the tip
    (Primitive(Round.CONE, 1.0, 2.0), (0.5, 0, -4), (0, 0, 1), 3.0, (0, 0, -1)),
    (Primitive(Round.CONE, 1.0, 2.0), (-4, 0, 0), (1, 0, 0), 3.5, (-2 / 5**0.5, 0, 1 / 5**0.5)),
    (Primitive(Round.CONE, 1.0, 2.0), (0, 0, -0.5), (0, 0, 1), 1.5, None),  # from within
    (Primitive(Round.CONE, 1.0, 2.0), (0, 0, 0), (0, 0, -1), 1.0, (0, 0, -1)),
    (Primitive(Round.CONE, 1.0, 2.0), (-4, 0, 1.5), (1, 0, 0), np.inf, (0, 0, 0)),  # the cone's other half
    (Primitive(Round.CAPSULE, 1.0, 2.0), (0, 0, 5), (0, 0, -1), 3.0, (0, 0, 1)),
    (Primitive(Round.CAPSULE, 1.0, 2.0), (0, 0, 0), (0, 0, -1), 2.0, (0, 0, -1)),
    (Primitive(Round.CAPSULE, 1.0, 2.0), (5, 0, 0.9), (-1, 0, 0), 4.0, (1, 0, 0)),
    (Primitive(Round.CAPSULE, 1.0, 0.0), (5, 0, 0), (-1, 0, 0), 4.0, (1, 0, 0)),
]


@pytest.mark.parametrize(("primitive", "origin", "direction", "distance", "normal"), KNOWN)
def test_hits_known_by_hand(
    primitive: Primitive, origin: tuple, direction: tuple, distance: float, normal: tuple | None
) -> None:
    found = traced(primitive, np.eye(4), np.array([origin]), np.array([direction]))
    assert found.distance[0] == pytest.approx(distance, abs=1e-6)
    if normal is not None:
        np.testing.assert_allclose(found.normal[0], normal, atol=1e-6)


def test_rays_along_the_generators_of_a_cone(rng: np.random.Generator) -> None:
    """The quadratic equation has but one root there."""
    angles = rng.uniform(0.0, 2.0 * np.pi, 200)
    generator = np.column_stack([np.cos(angles), np.sin(angles), np.full(200, -2.0)]) / np.sqrt(5.0)
    # A parallel of it through a point of the axis below the tip leaves by the base, coming from outside by the mantle.
    origins = np.array([0.0, 0.0, 0.5]) - 5.0 * generator
    found = traced(Primitive(Round.CONE, 1.0, 2.0), np.eye(4), origins, generator)
    # It comes in on the other side, where x^2 = ((1 - z) / 2)^2 with x = s / sqrt 5, z = 1 / 2 - 2 s / sqrt 5.
    np.testing.assert_allclose(found.distance, 5.0 - np.sqrt(5.0) / 8.0, atol=5e-6)


def test_tiny_and_far_is_still_met(rng: np.random.Generator) -> None:
    """A bead of 5 mm at a kilometre; single precision has steps of 0.06 mm there."""
    pose = np.eye(4)
    pose[0, 3] = 1000.0
    found = traced(Primitive(Round.SPHERE, 0.005), pose, np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]]))
    assert found.distance[0] == pytest.approx(999.995, abs=1e-4)


def test_mixed_with_triangles_the_nearest_counts() -> None:
    plate = make_shape([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    ball = curved(Primitive(Round.SPHERE, 0.5))
    poses = np.repeat(np.eye(4)[None], 3, axis=0)
    poses[:, 2, 3] = 0.0, 2.0, -1.0
    with TopScene() as scene:
        scene.place((plate, ball, ball), poses)
        above = scene.cast(np.array([[0.1, 0.2, 5.0]]), np.array([[0.0, 0.0, -1.0], [0.3, 0.0, -(0.91**0.5)]]))
        below = scene.cast(np.array([[0.1, 0.2, -5.0]]), np.array([[0.0, 0.0, 1.0]]))
        assert scene.cast(np.array([[0.9, 0.2, 5.0]]), np.array([[0.0, 0.0, -1.0]])).triangle.tolist() == [0]
    assert (above.element[0], below.element[0]) == (1, 2)
    assert (above.triangle[0], below.triangle[0]) == (-1, -1)


@pytest.mark.parametrize(
    "primitive",
    [
        Primitive(Round.SPHERE, 0.0),
        Primitive(Round.SPHERE, np.nan),
        Primitive(Round.CYLINDER, 1.0),
        Primitive(Round.CONE, 1.0, -1.0),
        Primitive(Round.CAPSULE, 1.0, np.inf),
    ],
)
def test_sizes_that_are_none_are_refused(primitive: Primitive) -> None:
    with TopScene() as scene, pytest.raises(ArgumentError, match="above 0"):
        scene.place((curved(primitive),), np.eye(4)[None])
