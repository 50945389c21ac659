"""Curved surfaces for the suite of ray casters: triangles that stand for them, and where rays meet them by formula."""

from __future__ import annotations

import numpy as np

from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, Primitive, Round, Shape, make_shape
from virtualrobot_sdk.testing.ray_truth import Truth

_GRAZING = 0.05
"""Rays whose direction and normal have a smaller product than this touch a surface rather than cross it."""
_EDGE = 1e-3
"""Hits that are closer to a rim (m) than this may count for either of its sides."""
_NEAR_MISS = 1e-4
"""Rays that miss by so little that a rounded equation may have roots (m^2, of its discriminant)."""


def random_primitive(rng: np.random.Generator, kind: Round) -> Primitive:
    """Return a curved surface of this kind, up to about a meter large."""
    return Primitive(kind, float(rng.uniform(0.1, 0.5)), 0.0 if kind is Round.SPHERE else float(rng.uniform(0.2, 1.0)))


def revolved(primitive: Primitive, segments: int) -> Shape:
    """Return a curved surface with the triangles that stand for it: its outline turned about z in so many segments."""
    r, h = primitive.radius, primitive.length / 2.0
    rise = np.linspace(-np.pi / 2.0, np.pi / 2.0, segments + 1)
    above = np.repeat([-h, h], [segments // 2 + 1, segments - segments // 2])
    outline = {
        Round.SPHERE: np.column_stack([r * np.cos(rise), r * np.sin(rise)]),
        Round.CYLINDER: np.array([[0.0, -h], [r, -h], [r, h], [0.0, h]]),
        Round.CONE: np.array([[0.0, -h], [r, -h], [0.0, h]]),
        Round.CAPSULE: np.column_stack([r * np.cos(rise), r * np.sin(rise) + above]),
    }[primitive.kind]
    turns = 2.0 * np.pi * np.arange(segments) / segments
    radius, z = outline[:, :1], np.broadcast_to(outline[:, 1:], (len(outline), segments))
    vertices = np.stack([radius * np.cos(turns), radius * np.sin(turns), z], axis=-1).reshape(-1, 3)
    lower = np.arange(len(outline) - 1)[:, None] * segments + np.arange(segments)
    beside = np.roll(lower, -1, axis=1)
    quads = np.stack([lower, beside, beside + segments, lower + segments], axis=-1).reshape(-1, 4)
    triangles = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    has_area = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-9
    return make_shape(vertices, triangles[has_area], primitive)


def curve_hits(primitive: Primitive, world_t_element: Floats, origins: Floats, directions: Floats) -> Truth:
    """Return the first hits of n rays on a curved surface, element 0 of its scene, by the roots of its equations.

    Each surface is made of patches: quadrics x^T A x + 2 b^T x + c = 0 and planes, of which a part counts. A ray
    o + t d meets a patch at the roots t that lie on this part.
    """
    rotation = world_t_element[:3, :3]
    o, d = (origins - world_t_element[:3, 3]) @ rotation, directions @ rotation
    n = len(o)
    distance, normal, sure = np.full(n, np.inf), np.zeros((n, 3)), np.ones(n, np.bool_)
    for times, inside, normals, edge in _patches(primitive, o, d):
        ahead = np.isfinite(times) & (times > -_EDGE) & (inside > -_EDGE)
        grazes = np.abs((normals * d).sum(axis=1)) < _GRAZING
        sure &= ~(ahead & ((np.abs(times) < _EDGE) | (edge & (inside < _EDGE)) | grazes))
        first = ahead & (times >= 0.0) & (inside >= 0.0) & (times < distance)
        distance[first], normal[first] = times[first], normals[first]
    normal = np.where((normal * d).sum(axis=1, keepdims=True) > 0.0, -normal, normal)
    is_hit = np.isfinite(distance)
    return Truth(Hits(distance, np.where(is_hit, 0, NO_ELEMENT).astype(np.int32), normal @ rotation.T), sure)


def _patches(primitive: Primitive, o: Floats, d: Floats) -> list[tuple[Floats, Floats, Floats, bool]]:
    """Return what each patch gives: times (n,), how far inside its part (n,), normals (n, 3), whether it has a rim.

    A ray that just misses gets the time of its nearest approach, and is outside: nobody can be sure of it.
    """
    kind, r, h = primitive.kind, primitive.radius, primitive.length / 2.0
    found: list[tuple[Floats, Floats, Floats, bool]] = []

    def quadric(diagonal: Floats, b: Floats, c: float, low: float, high: float, has_rim: bool) -> None:
        across, middle = (diagonal * d * d).sum(axis=1), (diagonal * o * d + b * d).sum(axis=1)
        rest = (diagonal * o * o + 2.0 * b * o).sum(axis=1) + c
        under = middle**2 - across * rest
        for sign in (-1.0, 1.0):
            with np.errstate(divide="ignore", invalid="ignore"):
                times = (-middle + sign * np.sqrt(np.maximum(under, 0.0))) / across
                point = o + times[:, None] * d
                gradient = diagonal * point + b
                normals = gradient / np.linalg.norm(gradient, axis=1, keepdims=True)
            times = np.where(under > -_NEAR_MISS, times, np.nan)
            inside = np.minimum(point[:, 2] - low, high - point[:, 2])
            found.append((times, np.where(under > 0.0, inside, np.minimum(inside, -1e-9)), normals, has_rim))

    def disc(z: float) -> None:
        with np.errstate(divide="ignore", invalid="ignore"):
            times = (z - o[:, 2]) / d[:, 2]
            point = o + times[:, None] * d
        inside = r - np.hypot(point[:, 0], point[:, 1])
        found.append((times, inside, np.broadcast_to([0.0, 0.0, 1.0], o.shape), True))

    ball, round_z = np.ones(3), np.array([1.0, 1.0, 0.0])
    match kind:
        case Round.SPHERE:
            quadric(ball, np.zeros(3), -r * r, -np.inf, np.inf, False)
        case Round.CYLINDER:
            quadric(round_z, np.zeros(3), -r * r, -h, h, True)
            disc(-h)
            disc(h)
        case Round.CONE:
            # x^2 + y^2 = k^2 (h - z)^2 with the slope k of the side.
            k = (r / (2.0 * h)) ** 2
            quadric(np.array([1.0, 1.0, -k]), np.array([0.0, 0.0, k * h]), -k * h * h, -h, h, True)
            disc(-h)
        case Round.CAPSULE:
            # Its patches go on into each other without a rim.
            quadric(round_z, np.zeros(3), -r * r, -h, h, False)
            quadric(ball, np.array([0.0, 0.0, h]), h * h - r * r, -np.inf, -h, False)
            quadric(ball, np.array([0.0, 0.0, -h]), h * h - r * r, h, np.inf, False)
    return found
