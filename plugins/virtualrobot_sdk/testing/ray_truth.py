"""Reference for ray casters: shapes, random scenes and rays, and every ray tried on every triangle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Booleans, Hits, RayScene, Shape, make_shape

_NEAR_EDGE = 1e-4
"""Barycentric coordinates closer to 0 than this are too close to an edge to tell on which side a ray passes."""
_RAYS_AT_ONCE = 200


def box(sides: Floats) -> Shape:
    """Return a box (12 triangles) about the origin with sides (3,) in meters."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * sides
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return make_shape(corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]))


def tetrahedron(size: float) -> Shape:
    """Return a regular tetrahedron about the origin, its corners at `size` (m) from it along the diagonals."""
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * size / np.sqrt(3.0)
    return make_shape(corners, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]))


def sphere(radius: float, divisions: int) -> Shape:
    """Return a sphere about the origin: an octahedron, each triangle divided into four some times over."""
    corners = [np.array(v, float) for v in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))]
    triangles = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(divisions):
        middles: dict[tuple[int, int], int] = {}
        finer = []
        for a, b, c in triangles:
            made = []
            for edge in ((a, b), (b, c), (c, a)):
                key = min(edge), max(edge)
                if key not in middles:
                    middles[key] = len(corners)
                    middle = corners[key[0]] + corners[key[1]]
                    corners.append(middle / np.linalg.norm(middle))
                made.append(middles[key])
            ab, bc, ca = made
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    return make_shape(np.array(corners) * radius, np.array(triangles))


def plane(side: float) -> Shape:
    """Return a square with this side (m) in the plane z = 0 about the origin, its outside towards z."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * side / 2.0
    return make_shape(corners, np.array([[0, 1, 2], [0, 2, 3]]))


def random_pose(rng: np.random.Generator, reach: float) -> Floats:
    """Return a pose (4, 4), turned in any way (Shoemake's random quaternion), at most `reach` (m) away on each axis."""
    x, y, z, w = (lambda q: q / np.linalg.norm(q))(rng.normal(size=4))
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = rng.uniform(-reach, reach, 3)
    return pose


def random_scene(rng: np.random.Generator, elements: int) -> RayScene:
    """Return a scene within about 3 m of the origin, in which several elements share a shape."""
    pool = (
        *(box(rng.uniform(0.2, 1.5, 3)), tetrahedron(rng.uniform(0.3, 1.0))),
        *(sphere(rng.uniform(0.2, 0.8), 2), plane(rng.uniform(0.5, 3.0))),
    )
    shapes = tuple(pool[i] for i in rng.integers(len(pool), size=elements))
    return RayScene(shapes, np.array([random_pose(rng, 2.0) for _ in range(elements)]).reshape(-1, 4, 4))


def random_rays(rng: np.random.Generator, count: int, scene: RayScene) -> tuple[Floats, Floats]:
    """Return origins within 4 m and unit directions (n, 3): two thirds towards elements, the others anywhere."""
    origins, directions = rng.uniform(-4.0, 4.0, (count, 3)), rng.normal(size=(count, 3))
    aimed = 2 * count // 3
    centers = scene.world_t_element[:, :3, 3] if len(scene.shapes) else np.zeros((1, 3))
    aims = centers[rng.integers(len(centers), size=aimed)] + rng.normal(scale=0.25, size=(aimed, 3))
    directions[:aimed] = aims - origins[:aimed]
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """The first hits of n rays.

    Attributes:
        hits: as a ray caster gives them.
        sure: (n,) false where a ray passes so close to an edge, or surfaces are so close, that rounding decides.
    """

    hits: Hits
    sure: Booleans


def reference(scene: RayScene, origins: Floats, directions: Floats, max_range: float, precision: float) -> Truth:
    """Return the first hits of n rays, each tried on each triangle; what is closer than `precision` (m) is not sure.

    A ray from o along d meets the triangle a b c where d lies within the three planes through o and an edge: where the
    volumes d . (c x b), d . (a x c), d . (b x a), corners counted from o, have one sign (Woop, Benthin and Wald,
    Watertight Ray/Triangle Intersection, JCGT 2013).
    """
    corners, owner = _corners(scene)
    n = len(origins)
    distance, element, normal = np.full(n, np.inf), np.full(n, NO_ELEMENT, np.int32), np.zeros((n, 3))
    sure = np.ones(n, np.bool_)
    for start in range(0, n if len(corners) else 0, _RAYS_AT_ONCE):
        part = slice(start, start + _RAYS_AT_ONCE)
        weights, along = _crossings(corners, origins[part], directions[part])
        hit = (weights >= 0.0).all(axis=-1) & (along >= 0.0) & (along <= max_range)
        reached = np.where(hit, along, np.inf)
        first = reached.argmin(axis=1)
        rows = np.arange(len(first))
        nearest = reached[rows, first]
        is_hit = np.isfinite(nearest)
        distance[part] = nearest
        element[part] = np.where(is_hit, owner[first], NO_ELEMENT)
        normal[part] = np.where(is_hit[:, None], _normals(corners[first], directions[part]), 0.0)
        # What may come before, or be as near: triangles that the ray passes close to the edge of, other elements.
        before = (along > -precision) & (along < np.minimum(nearest, max_range)[:, None] + precision)
        near_edge = before & (weights > -_NEAR_EDGE).all(axis=-1) & (weights < _NEAR_EDGE).any(axis=-1)
        other = hit & before & (owner[None, :] != element[part][:, None])
        at_an_end = (
            before
            & (weights > -_NEAR_EDGE).all(axis=-1)
            & ((np.abs(along) < precision) | (np.abs(along - max_range) < precision))
        )
        sure[part] = ~(near_edge | other | at_an_end).any(axis=1)
    return Truth(Hits(distance, element, normal), sure)


def _corners(scene: RayScene) -> tuple[Floats, np.ndarray]:
    """Return the corners (t, 3, 3) of all triangles in the world that have an area, and the element of each."""
    found, owner = [np.zeros((0, 3, 3))], [np.zeros(0, np.int32)]
    for i, (shape, pose) in enumerate(zip(scene.shapes, scene.world_t_element, strict=True)):
        vertices = shape.vertices.astype(np.float64) @ pose[:3, :3].T + pose[:3, 3]
        corners = vertices[shape.triangles].reshape(-1, 3, 3)
        sides = np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).max(axis=1, initial=0.0)
        has_area = np.linalg.norm(_across(corners), axis=1) > 1e-7 * sides**2
        found.append(corners[has_area])
        owner.append(np.full(int(has_area.sum()), i, np.int32))
    return np.concatenate(found), np.concatenate(owner)


def _crossings(corners: Floats, origins: Floats, directions: Floats) -> tuple[Floats, Floats]:
    """Return barycentric weights (r, t, 3) and distances (r, t) where rays meet the planes of triangles."""
    a, b, c = np.moveaxis(corners[None] - origins[:, None, None, :], 2, 0)
    d = directions[:, None, :]
    volumes = np.stack([(d * np.cross(c, b)).sum(-1), (d * np.cross(a, c)).sum(-1), (d * np.cross(b, a)).sum(-1)], -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = volumes / volumes.sum(axis=-1, keepdims=True)
        across = _across(corners)[None]
        along = (a * across).sum(-1) / (d * across).sum(-1)
    weights = np.where(np.isfinite(weights), weights, -1.0)
    return weights, np.where(np.isfinite(along), along, -1.0)


def _across(corners: Floats) -> Floats:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _normals(corners: Floats, directions: Floats) -> Floats:
    across = _across(corners)
    normal = across / np.linalg.norm(across, axis=1, keepdims=True)
    return np.where((normal * directions).sum(axis=1, keepdims=True) > 0.0, -normal, normal)
