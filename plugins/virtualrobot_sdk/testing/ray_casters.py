"""The contract suite for ray casters: laws against analytic shapes, and against every ray on every triangle."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, RayScene, Round, make_shape
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.ray_answers import (
    CasterFacts,
    RayTrial,
    apart,
    as_reference,
    cast,
    compared,
    met,
    must_be,
    nonsense,
    ray_words,
    worst_error,
)
from virtualrobot_sdk.testing.ray_curves import curve_hits, random_primitive, revolved
from virtualrobot_sdk.testing.ray_truth import (
    box,
    plane,
    random_pose,
    random_rays,
    random_scene,
    reference,
    sphere,
    tetrahedron,
)
from virtualrobot_sdk.testing.trial import Law, NotTried, must_refuse, numbers

RAYS = 300
"""Number of random rays that most laws cast into a scene."""
SCENES = 4
LONGEST = 12.0
"""Range of rays (m) where they need an end: across any scene of the suite."""
_COST_RAYS = 300
_SEGMENTS = 24
"""Number of sides of the triangles that stand for a curved surface."""
_BESIDE = 1e-3
"""Largest distance of barycentric coordinates outside a triangle, and largest turn of a normal (1 - cosine)."""


def solids(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Rays meet a box and a tetrahedron where their faces' planes say it, from outside and inside, at any pose.

    The ray enters a convex solid past the last plane that it comes in by, and leaves before the first that it goes out
    by (Cyrus and Beck, Generalized two- and three-dimensional clipping, 1978).
    """
    worst = 0.0
    sides, size = rng.uniform(0.5, 2.0, 3), rng.uniform(0.5, 1.5)
    across_tetrahedron = -tetrahedron(1.0).vertices.astype(np.float64)
    across_box = np.concatenate([np.eye(3), -np.eye(3)])
    for shape, normals, offsets in (
        (box(sides), across_box, np.concatenate([sides, sides]) / 2.0),
        (tetrahedron(size), across_tetrahedron, np.full(4, size / 3.0)),
    ):
        world_t_element = random_pose(rng, 2.0)
        normals = normals @ world_t_element[:3, :3].T
        offsets = offsets + normals @ world_t_element[:3, 3]
        scene = RayScene((shape,), world_t_element[None])
        origins, directions = random_rays(rng, RAYS, scene)
        origins[::3] = world_t_element[:3, 3] + rng.uniform(-0.1, 0.1, (len(origins[::3]), 3))  # from inside
        speed, ahead = directions @ normals.T, offsets - origins @ normals.T
        times = ahead / np.where(np.abs(speed) < 1e-12, 1e-12, speed)
        entry, leaving = np.where(speed < 0, times, -np.inf), np.where(speed > 0, times, np.inf)
        first, last = entry.max(axis=1), leaving.min(axis=1)
        inside = (first < 0.0) & (last > 0.0)
        expected = np.where(inside, last, np.where((first <= last) & (first >= 0.0), first, np.inf))
        face = np.where(inside, leaving.argmin(axis=1), entry.argmax(axis=1))
        # Close to an edge rounding decides which of two faces is met.
        edge = np.where(inside, np.diff(np.sort(leaving)[:, :2])[:, 0], np.diff(np.sort(entry)[:, -2:])[:, 0])
        sure = (np.abs(first - last) > 1e-3) & (np.abs(first) > 1e-3) & (np.abs(last) > 1e-3) & (edge > 1e-3)
        found = cast(trial, scene, origins, directions)
        toward = np.where(inside[:, None], -normals[face], normals[face])
        normal = np.where(np.isfinite(expected)[:, None], toward, 0.0)
        element = np.where(np.isfinite(expected), 0, NO_ELEMENT).astype(np.int32)
        worst = max(worst, compared(trial, found, Hits(expected, element, normal), sure, origins, directions))
    return Measured(2 * RAYS, {"m": worst})


def spheres(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Rays meet a sphere of 2048 triangles between its own surface and the sphere that its faces touch inside."""
    shape, center = sphere(1.0, 4), rng.uniform(-1.0, 1.0, 3)
    corners = shape.vertices[shape.triangles].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inner = float(((corners[:, 0] * across).sum(axis=1) / np.linalg.norm(across, axis=1)).min())
    pose = random_pose(rng, 0.0)
    pose[:3, 3] = center
    directions = rng.normal(size=(RAYS, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    origins = center + 3.0 * directions
    aims = center + rng.uniform(-1.0, 1.0, (RAYS, 3))
    directions = (aims - origins) / np.linalg.norm(aims - origins, axis=1, keepdims=True)
    found = cast(trial, RayScene((shape,), pose[None]), origins, directions)
    room = trial.facts.precision
    outer_hit, inner_hit = (_to_sphere(origins - center, directions, r) for r in (1.0 + room, inner - room))
    wrong = np.isfinite(inner_hit) & ~((found.distance > outer_hit - room) & (found.distance < inner_hit + room))
    wrong |= np.isinf(outer_hit) & np.isfinite(found.distance)
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        raise LawBroken(
            f"{ray_words(origins, directions, i)} meets a sphere at {found.distance[i]:.6g} m; it must be between "
            f"{outer_hit[i]:.6g} and {inner_hit[i]:.6g} m"
        )
    return Measured(RAYS)


def curves(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Rays meet spheres, cylinders, cones and capsules as they are meant, or else the triangles that stand for them.

    From outside and inside, at any pose. A caster whose facts say so meets them as meant, to 1e-6 of the range.
    """
    worst = 0.0
    for kind in Round:
        primitive = random_primitive(rng, kind)
        scene = RayScene((revolved(primitive, _SEGMENTS),), random_pose(rng, 2.0)[None])
        origins, directions = random_rays(rng, RAYS, scene)
        origins[::3] = scene.world_t_element[0, :3, 3] + rng.uniform(-0.02, 0.02, (len(origins[::3]), 3))
        found = cast(trial, scene, origins, directions, LONGEST)
        meant = curve_hits(primitive, scene.world_t_element[0], origins, directions)
        precision = 1e-6 * LONGEST if trial.facts.exact_curves else trial.facts.precision
        wrong = meant.sure & apart(found, meant.hits, directions, precision)
        if not trial.facts.exact_curves:
            faceted = reference(scene, origins, directions, LONGEST, 10.0 * precision)
            wrong &= faceted.sure & apart(found, faceted.hits, directions, precision)
        must_be(found, meant.hits, wrong, origins, directions)
        worst = max(worst, worst_error(found, meant.hits, meant.sure & (found.element == meant.hits.element)))
    return Measured(len(Round) * RAYS, {"m": worst})


def nearest(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Of parallel plates in any order the first along the ray counts, from either side, with its normal to the ray."""
    order = rng.permutation(6)
    pose = random_pose(rng, 2.0)
    plates = np.repeat(pose[None], 6, axis=0)
    plates[:, :3, 3] += np.outer(0.5 * order, pose[:3, 2])
    scene = RayScene((plane(4.0),) * 6, plates)
    heights = rng.uniform(-1.0, 3.5, RAYS)
    heights = np.where(np.abs(heights * 2 - np.round(heights * 2)) < 0.02, heights + 0.1, heights)
    up = np.where(rng.random(RAYS) < 0.5, 1.0, -1.0)
    across = rng.uniform(-1.0, 1.0, (RAYS, 2))
    origins = pose[:3, 3] + np.column_stack([across, heights]) @ pose[:3, :3].T
    directions = up[:, None] * pose[:3, 2]
    level = np.where(up > 0, np.maximum(np.ceil(heights * 2), 0), np.minimum(np.floor(heights * 2), 5))
    is_hit = (level >= 0) & (level <= 5)
    expected = np.where(is_hit, np.abs(level / 2 - heights), np.inf)
    element = np.where(is_hit, np.argsort(order)[np.clip(level, 0, 5).astype(int)], NO_ELEMENT).astype(np.int32)
    hits = Hits(expected, element, np.where(is_hit[:, None], -directions, 0.0))
    # On the diagonal of a plate one of its two triangles must catch the ray, but rounding may lose it.
    sure = np.abs(across[:, 0] - across[:, 1]) > 1e-3
    found = cast(trial, scene, origins, directions)
    return Measured(RAYS, {"m": compared(trial, found, hits, sure, origins, directions)})


def scenes(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Random scenes of several elements, some of one shape, answer as when every ray is tried on every triangle."""
    worst = 0.0
    for elements in (1, 3, 8, 20)[:SCENES]:
        scene = random_scene(rng, elements)
        worst = max(worst, as_reference(trial, scene, *random_rays(rng, RAYS, scene)))
    return Measured(SCENES * RAYS, {"m": worst})


def triangles(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """The hit lies in the triangle that a caster tells, where it tells one, and the normal is the triangle's."""
    worst, tried = 0.0, 0
    for elements in (1, 8):
        scene = random_scene(rng, elements)
        origins, directions = random_rays(rng, RAYS, scene)
        found = cast(trial, scene, origins, directions)
        if found.triangle is None:
            raise NotTried("it does not tell triangles")
        for i in np.flatnonzero(found.element != NO_ELEMENT).tolist():
            shape, pose = scene.shapes[found.element[i]], scene.world_t_element[found.element[i]]
            corners = shape.vertices[shape.triangles[found.triangle[i]]] @ pose[:3, :3].T + pose[:3, 3]
            point = origins[i] + found.distance[i] * directions[i]
            across = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            weights = (np.cross(corners - point, np.roll(corners, -1, axis=0) - point) @ across) / (across @ across)
            off = abs(float((point - corners[0]) @ across)) / float(np.linalg.norm(across))
            turned = 1.0 - abs(float(found.normal[i] @ across)) / float(np.linalg.norm(across))
            if off > trial.facts.precision or weights.min() < -_BESIDE or turned > _BESIDE:
                raise LawBroken(
                    f"{ray_words(origins, directions, i)} meets {met(found, i)}, which is not in triangle "
                    f"{found.triangle[i]}: {off:.3g} m from its plane, barycentric coordinates {numbers(weights)}"
                )
            worst, tried = max(worst, off), tried + 1
    return Measured(tried, {"m": worst})


def ranges(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Nothing farther than the range counts, and what is nearer still does."""
    scene = random_scene(rng, 8)
    for max_range in rng.uniform(0.5, 6.0, 3):
        as_reference(trial, scene, *random_rays(rng, RAYS, scene), float(max_range))
    return Measured(3 * RAYS)


def changes(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Nothing kept of one scene is taken for another: elements that move, shapes that change, scenes by turns."""
    first, other = random_scene(rng, 5), random_scene(rng, 5)
    moved = RayScene(first.shapes, first.world_t_element[::-1].copy())
    scaled = tuple(make_shape(1.5 * shape.vertices, shape.triangles) for shape in first.shapes)
    changed = RayScene(scaled, first.world_t_element)
    rays = random_rays(rng, 100, first)
    for scene in (first, moved, changed, other, first, changed):
        as_reference(trial, scene, *rays)
    return Measured(600)


def degenerate(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Triangles without area change nothing: corners that are one, corners in a row."""
    scene = random_scene(rng, 4)
    spoilt = []
    for shape in scene.shapes:
        a, b = shape.vertices[shape.triangles[0, :2]]
        start = len(shape.vertices)
        vertices = np.concatenate([shape.vertices, [(a + b) / 2]])
        extra = [[0, 0, 0], [1, 1, 2], [shape.triangles[0, 0], start, shape.triangles[0, 1]]]
        spoilt.append(make_shape(vertices, np.concatenate([extra, shape.triangles])))
    worst = as_reference(trial, RayScene(tuple(spoilt), scene.world_t_element), *random_rays(rng, RAYS, scene))
    return Measured(RAYS, {"m": worst})


def nothing(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """A scene without elements, a shape without triangles and no rays at all are answered like others."""
    none = np.zeros((0, 3))
    empty = make_shape(none.astype(np.float32), np.zeros((0, 3), np.int32))
    scene = random_scene(rng, 2)
    rays = random_rays(rng, 20, scene)
    mixed = RayScene((empty, *scene.shapes), np.concatenate([np.eye(4)[None], scene.world_t_element]))
    for given in (RayScene((), np.zeros((0, 4, 4))), RayScene((empty,), np.eye(4)[None]), mixed):
        as_reference(trial, given, *rays)
        cast(trial, given, none, none)
    return Measured(6)


def refusals(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Arguments that make no sense are refused by an ArgumentError, and the next cast is answered rightly."""
    scene = random_scene(rng, 3)
    rays = random_rays(rng, 20, scene)
    tried = must_refuse(trial, nonsense(scene, *rays))
    as_reference(trial, scene, *rays)
    return Measured(tried)


def determinism(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """The same cast gives the same bits: twice in a row, after another one, and in another process."""
    scene = random_scene(rng, 6)
    rays = random_rays(rng, RAYS, scene)
    first = cast(trial, scene, *rays)
    cast(trial, random_scene(rng, 6), *rays)
    with trial.twin() as twin:
        for where, other in (("", trial), (" in another process", twin)):
            again = cast(other, scene, *rays)
            for name in ("distance", "element", "normal", "triangle"):
                one, other_one = getattr(first, name), getattr(again, name)
                if one is not None and one.tobytes() != other_one.tobytes():
                    raise LawBroken(f"the same cast gives another {name}{where}")
    return Measured(2 * RAYS)


def cost(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Tell what a ray costs on few and on many triangles; nothing is demanded."""
    found = {}
    for divisions in (1, 4):
        shape = sphere(1.0, divisions)
        scene = RayScene((shape,), np.eye(4)[None])
        seconds = np.median(trial.seconds(3, "cast", scene, *random_rays(rng, _COST_RAYS, scene), np.inf))
        found[f"us a ray on {len(shape.triangles)} triangles"] = float(1e6 * seconds / _COST_RAYS)
    return Measured(2 * _COST_RAYS, found)


LAWS: Mapping[str, Law] = MappingProxyType(
    {
        law.__name__: law
        for law in (
            *(solids, spheres, curves, nearest, scenes, triangles, ranges),
            *(changes, degenerate, nothing, refusals, determinism, cost),
        )
    }
)
"""Laws of all ray casters, by name, in the order in which they are tried."""


class RayCasterContract(ComponentContract):
    """Contract of all ray casters; subclass it in a test file.

    class TestMyCaster(RayCasterContract):
        component = "my_package/my_caster"
    """

    kind = ComponentKind.RAY_CASTER
    laws = LAWS
    facts: ClassVar[CasterFacts] = CasterFacts()


def _to_sphere(origins: Floats, directions: Floats, radius: float) -> Floats:
    """Return the distance (n,) at which rays from outside meet a sphere about the origin; inf where they miss it."""
    along = -(origins * directions).sum(axis=1)
    under = radius**2 - (origins**2).sum(axis=1) + along**2
    return np.where(under > 0.0, along - np.sqrt(np.maximum(under, 0.0)), np.inf)
