"""The contract suite for ray casters: laws against analytic shapes, and against every ray on every triangle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, RayScene, make_shape
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.laws import LawBroken, Measured
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
from virtualrobot_sdk.testing.trial import Law, Trial, checked, must_refuse, numbers

RAYS = 300
"""How many random rays most laws cast into a scene."""
SCENES = 4
_NORMAL = 1e-3
"""How far a normal may be from the triangle's (length of the difference)."""
_COST_RAYS = 300


@dataclass(frozen=True, slots=True)
class CasterFacts:
    """What the author says of a ray caster.

    Attributes:
        precision: the largest error of a distance (m), for scenes and rays within 10 m: the default is good for single
            precision.
    """

    precision: float = 1e-4


RayTrial = Trial[CasterFacts]


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
        origins, directions = random_rays(rng, RAYS)
        origins[::3] = world_t_element[:3, 3] + rng.uniform(-0.1, 0.1, (len(origins[::3]), 3))  # from inside
        speed, ahead = directions @ normals.T, offsets - origins @ normals.T
        times = ahead / np.where(np.abs(speed) < 1e-12, 1e-12, speed)
        entry, leaving = np.where(speed < 0, times, -np.inf), np.where(speed > 0, times, np.inf)
        first, last = entry.max(axis=1), leaving.min(axis=1)
        inside = (first < 0.0) & (last > 0.0)
        expected = np.where(inside, last, np.where((first <= last) & (first >= 0.0), first, np.inf))
        face = np.where(inside, leaving.argmin(axis=1), entry.argmax(axis=1))
        sure = (np.abs(first - last) > 1e-3) & (np.abs(first) > 1e-3) & (np.abs(last) > 1e-3)
        found = _cast(trial, RayScene((shape,), world_t_element[None]), origins, directions)
        toward = np.where(inside[:, None], -normals[face], normals[face])
        normal = np.where(np.isfinite(expected)[:, None], toward, 0.0)
        element = np.where(np.isfinite(expected), 0, NO_ELEMENT).astype(np.int32)
        worst = max(worst, _compared(trial, found, Hits(expected, element, normal), sure, origins, directions))
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
    found = _cast(trial, RayScene((shape,), pose[None]), origins, directions)
    room = trial.facts.precision
    outer_hit, inner_hit = (_to_sphere(origins - center, directions, r) for r in (1.0 + room, inner - room))
    wrong = np.isfinite(inner_hit) & ~((found.distance > outer_hit - room) & (found.distance < inner_hit + room))
    wrong |= np.isinf(outer_hit) & np.isfinite(found.distance)
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        raise LawBroken(
            f"{_ray(origins, directions, i)} meets a sphere at {found.distance[i]:.6g} m; it must be between "
            f"{outer_hit[i]:.6g} and {inner_hit[i]:.6g} m"
        )
    return Measured(RAYS)


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
    found = _cast(trial, scene, origins, directions)
    return Measured(RAYS, {"m": _compared(trial, found, hits, sure, origins, directions)})


def scenes(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Random scenes of several elements, some of one shape, answer as when every ray is tried on every triangle."""
    worst = 0.0
    for elements in (1, 3, 8, 20)[:SCENES]:
        worst = max(worst, _as_reference(trial, random_scene(rng, elements), *random_rays(rng, RAYS)))
    return Measured(SCENES * RAYS, {"m": worst})


def ranges(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Nothing farther than the range counts, and what is nearer still does."""
    scene = random_scene(rng, 8)
    for max_range in rng.uniform(0.5, 6.0, 3):
        _as_reference(trial, scene, *random_rays(rng, RAYS), float(max_range))
    return Measured(3 * RAYS)


def changes(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """What is kept of one scene is not taken for another: elements that move, shapes that change, scenes by turns."""
    first, other = random_scene(rng, 5), random_scene(rng, 5)
    moved = RayScene(first.shapes, first.world_t_element[::-1].copy())
    scaled = tuple(make_shape(1.5 * shape.vertices, shape.triangles) for shape in first.shapes)
    changed = RayScene(scaled, first.world_t_element)
    rays = random_rays(rng, 100)
    for scene in (first, moved, changed, other, first, changed):
        _as_reference(trial, scene, *rays)
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
    worst = _as_reference(trial, RayScene(tuple(spoilt), scene.world_t_element), *random_rays(rng, RAYS))
    return Measured(RAYS, {"m": worst})


def nothing(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """A scene without elements, a shape without triangles and no rays at all are answered like others."""
    rays = random_rays(rng, 20)
    none = np.zeros((0, 3))
    empty = make_shape(none.astype(np.float32), np.zeros((0, 3), np.int32))
    scene = random_scene(rng, 2)
    mixed = RayScene((empty, *scene.shapes), np.concatenate([np.eye(4)[None], scene.world_t_element]))
    for given in (RayScene((), np.zeros((0, 4, 4))), RayScene((empty,), np.eye(4)[None]), mixed):
        _as_reference(trial, given, *rays)
        _cast(trial, given, none, none)
    return Measured(6)


def refusals(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """What makes no sense is refused by an ArgumentError, and the next cast is answered rightly."""
    scene, rays = random_scene(rng, 3), random_rays(rng, 20)
    tried = must_refuse(trial, _nonsense(scene, *rays))
    _as_reference(trial, scene, *rays)
    return Measured(tried)


def determinism(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """The same cast gives the same bits: twice in a row, after another one, and in another process."""
    scene, rays = random_scene(rng, 6), random_rays(rng, RAYS)
    first = _cast(trial, scene, *rays)
    _cast(trial, random_scene(rng, 6), *rays)
    with trial.twin() as twin:
        for where, other in (("", trial), (" in another process", twin)):
            again = _cast(other, scene, *rays)
            for name in ("distance", "element", "normal"):
                if getattr(first, name).tobytes() != getattr(again, name).tobytes():
                    raise LawBroken(f"the same cast gives another {name}{where}")
    return Measured(2 * RAYS)


def cost(trial: RayTrial, rng: np.random.Generator) -> Measured:
    """Tell what a ray costs on few and on many triangles; nothing is demanded."""
    found = {}
    for divisions in (1, 4):
        shape = sphere(1.0, divisions)
        scene, rays = RayScene((shape,), np.eye(4)[None]), random_rays(rng, _COST_RAYS)
        seconds = np.median(trial.seconds(3, "cast", scene, *rays, np.inf))
        found[f"us a ray on {len(shape.triangles)} triangles"] = float(1e6 * seconds / _COST_RAYS)
    return Measured(2 * _COST_RAYS, found)


LAWS: Mapping[str, Law] = MappingProxyType(
    {
        law.__name__: law
        for law in (
            *(solids, spheres, nearest, scenes, ranges, changes, degenerate),
            *(nothing, refusals, determinism, cost),
        )
    }
)
"""What every ray caster must keep, in the order in which it is tried."""


class RayCasterContract(ComponentContract):
    """What every ray caster must keep; subclass it in a test file.

    class TestMyCaster(RayCasterContract):
        component = "my_package/my_caster"
    """

    kind = ComponentKind.RAY_CASTER
    laws = LAWS
    facts: ClassVar[CasterFacts] = CasterFacts()


def _cast(trial: RayTrial, scene: RayScene, origins: Floats, directions: Floats, max_range: float = np.inf) -> Hits:
    """Return the hits, of the right types and shapes, finite where they must be, normals of unit length or 0."""
    hits = trial.call("cast", scene, origins, directions, max_range)
    if not isinstance(hits, Hits):
        raise LawBroken(f"cast returned {type(hits).__name__}; it must be Hits")
    n = len(origins)
    checked(hits.distance, "distance", np.float64, (n,))
    checked(hits.element, "element", np.int32, (n,))
    checked(hits.normal, "normal", np.float64, (n, 3))
    is_hit = hits.element != NO_ELEMENT
    wrong = {
        "a distance that is NaN or below 0": ~(hits.distance >= 0.0),
        "an element that is not there": is_hit & ((hits.element < 0) | (hits.element >= len(scene.shapes))),
        "a distance without an element, or an element at no distance": np.isfinite(hits.distance) != is_hit,
        "a miss with a normal": ~is_hit & hits.normal.any(axis=1),
        "a normal that is not of unit length": is_hit & ~(np.abs(np.linalg.norm(hits.normal, axis=1) - 1.0) <= 1e-6),
        "a normal turned away from the ray's origin": is_hit & ~((hits.normal * directions).sum(axis=1) <= 1e-6),
    }
    for what, rows in wrong.items():
        if rows.any():
            i = int(np.flatnonzero(rows)[0])
            raise LawBroken(
                f"{_ray(origins, directions, i)} gives {what}: distance {hits.distance[i]}, element "
                f"{hits.element[i]}, normal {numbers(hits.normal[i])}"
            )
    return hits


def _as_reference(
    trial: RayTrial, scene: RayScene, origins: Floats, directions: Floats, max_range: float = np.inf
) -> float:
    """Return the worst distance from the reference's (m)."""
    found = _cast(trial, scene, origins, directions, max_range)
    truth = reference(scene, origins, directions, max_range, 10.0 * trial.facts.precision)
    return _compared(trial, found, truth.hits, truth.sure, origins, directions)


def _compared(trial: RayTrial, found: Hits, true: Hits, sure: np.ndarray, origins: Floats, directions: Floats) -> float:
    """Return the worst distance of what was found from the truth (m) among the rays that are sure."""
    with np.errstate(invalid="ignore"):
        off = np.where(found.distance == true.distance, 0.0, np.abs(found.distance - true.distance))
    # A surface that is met at a slant moves the hit by more than it moves itself.
    slant = np.maximum(0.05, np.abs((true.normal * directions).sum(axis=1)))
    apart = np.linalg.norm(found.normal - true.normal, axis=1) > _NORMAL
    wrong = sure & ((off * slant > trial.facts.precision) | (found.element != true.element) | apart)
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        raise LawBroken(
            f"{_ray(origins, directions, i)} meets {_met(found, i)}; it must be {_met(true, i)} ({int(wrong.sum())} of "
            f"{len(wrong)} rays are wrong)"
        )
    return float(np.where(sure & np.isfinite(off), off, 0.0).max(initial=0.0))


def _nonsense(scene: RayScene, origins: Floats, directions: Floats) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield calls that must be refused."""
    for what, value in (("NaN", np.nan), ("infinity", np.inf)):
        for name, given in (("origin", origins), ("direction", directions)):
            broken = given.copy()
            broken[-1, 1] = value
            rays = (broken, directions) if name == "origin" else (origins, broken)
            yield "cast", (scene, *rays, 10.0), f"{name} with {what}"
    poses = scene.world_t_element.copy()
    poses[0, 0, 3] = np.nan
    yield "cast", (RayScene(scene.shapes, poses), origins, directions, 10.0), "an element's pose with NaN"
    yield "cast", (RayScene(scene.shapes, poses[:-1]), origins, directions, 10.0), "fewer poses than shapes"
    for factor in (0.0, 2.0, 1.0 + 1e-4):
        broken = directions.copy()
        broken[0] *= factor
        yield "cast", (scene, origins, broken, 10.0), f"a direction of length {factor}"
    yield "cast", (scene, origins[:-1], directions, 10.0), "fewer origins than directions"
    yield "cast", (scene, origins[:, :2], directions[:, :2], 10.0), "rays in two dimensions"
    for max_range in (np.nan, -1.0, 0.0):
        yield "cast", (scene, origins, directions, max_range), f"a range of {max_range}"


def _to_sphere(origins: Floats, directions: Floats, radius: float) -> Floats:
    """Return the distance (n,) at which rays from outside meet a sphere about the origin; inf where they miss it."""
    along = -(origins * directions).sum(axis=1)
    under = radius**2 - (origins**2).sum(axis=1) + along**2
    return np.where(under > 0.0, along - np.sqrt(np.maximum(under, 0.0)), np.inf)


def _ray(origins: Floats, directions: Floats, i: int) -> str:
    return f"the ray from {numbers(origins[i])} along {numbers(directions[i])}"


def _met(hits: Hits, i: int) -> str:
    if hits.element[i] == NO_ELEMENT:
        return "nothing"
    return f"element {hits.element[i]} at {hits.distance[i]:.6g} m with the normal {numbers(hits.normal[i])}"
