"""The suite for ray casters: a plain one keeps it, and each wrong one is found by the law that it breaks."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, RayScene, Round, Shape
from virtualrobot_sdk.testing.ray_answers import CasterFacts, apart
from virtualrobot_sdk.testing.ray_casters import RayCasterContract
from virtualrobot_sdk.testing.ray_curves import curve_hits, random_primitive, revolved
from virtualrobot_sdk.testing.ray_truth import (
    box,
    random_pose,
    random_rays,
    random_scene,
    reference,
    sphere,
    tetrahedron,
)

from tests.contract.breaking import broken
from tests.pybullet_models import pybullet
from tests.tiers import every_fifth

COMPONENTS = "tests.contract.components.ray_casters"
LONGEST = 10.0
"""How far rays go (m) where they need an end."""

WRONG = {
    "OneSided": ("solids", r"meets nothing; it must be element 0 at"),
    "LastElement": ("nearest", r"meets element \d at .*; it must be element \d at"),
    "OutwardNormals": ("scenes", r"a normal turned away from the ray's origin"),
    "EndlessRange": ("ranges", r"it must be nothing"),
    "KeptByPlace": ("changes", r"it must be"),
    "NoChecks": ("refusals", r"cast of a direction of length 2.0 was answered"),
    "Swollen": ("curves", r"it must be element 0 at|it must be nothing"),
    "NextTriangle": ("triangles", r"which is not in triangle \d+: .* m from its plane"),
    "WritesToRays": ("scenes", r"ValueError: output array is read-only \(ray_casters\.py:\d+ in cast\)"),
}


class TestMoellerTrumbore(RayCasterContract):
    component = f"{COMPONENTS}:MoellerTrumbore"


class TestByFormula(RayCasterContract):
    component = f"{COMPONENTS}:ByFormula"
    facts = CasterFacts(exact_curves=True)


class TestEmbree(RayCasterContract):
    component = "virtualrobot_plugins.rays/embree"
    facts = CasterFacts(precision=1e-5, exact_curves=True)


@pytest.mark.long
class TestWithoutLibrary(RayCasterContract):
    component = f"{COMPONENTS}:WithoutLibrary"
    facts = CasterFacts(precision=1e-5)


@pytest.mark.long
class TestReference(RayCasterContract):
    component = "virtualrobot_plugins.rays/reference"
    facts = CasterFacts(precision=1e-6)


class TestBullet(RayCasterContract):
    component = "virtualrobot_plugins.rays/bullet"
    facts = CasterFacts(precision=1e-6)


@pytest.mark.parametrize("name", every_fifth(WRONG))
def test_a_wrong_one_is_found(name: str, seed: int) -> None:
    law, said = WRONG[name]
    found = broken(RayCasterContract, f"{COMPONENTS}:{name}", law, seed)
    assert re.search(said, found), found


def test_facets_are_not_exact_curves(seed: int) -> None:
    facts = CasterFacts(exact_curves=True)
    found = broken(RayCasterContract, f"{COMPONENTS}:MoellerTrumbore", "curves", seed, facts)
    assert re.search(r"it must be element 0 at|it must be nothing", found), found


@pytest.mark.parametrize("slant", [1.0, 0.1, 0.002])
def test_a_surface_that_is_off_moves_hits_by_its_slant(slant: float) -> None:
    """By 1 / slant of what it is off: so much may be off what a caster of this precision meets."""
    directions = np.array([[np.sqrt(1.0 - slant**2), 0.0, -slant]])
    for part, is_apart in ((0.9, False), (1.1, True)):
        true, found = (
            Hits(np.array([distance]), np.zeros(1, np.int32), np.array([[0.0, 0.0, 1.0]]))
            for distance in (2.0, 2.0 + part * 1e-5 / slant)
        )
        assert apart(found, true, directions, 1e-5).tolist() == [is_apart]


@pytest.mark.parametrize(
    ("shape", "volume", "part_cut_off"),
    [
        (box(np.array([1.0, 2.0, 3.0])), 6.0, 1e-6),
        # A regular tetrahedron with its corners at distance r has 8 r^3 / (9 sqrt 3).
        (tetrahedron(1.5), 8.0 * 1.5**3 / (9.0 * np.sqrt(3.0)), 1e-6),
        (sphere(1.0, 4), 4.0 / 3.0 * np.pi, 0.01),
    ],
)
def test_the_kit_s_solids_look_outward(shape: Shape, volume: float, part_cut_off: float) -> None:
    a, b, c = np.moveaxis(shape.vertices[shape.triangles].astype(np.float64), 1, 0)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0 == pytest.approx(volume, rel=part_cut_off)


@pytest.mark.parametrize("kind", Round, ids=lambda kind: kind.value)
def test_the_kit_s_curves_are_where_a_point_inside_is_no_longer_inside(kind: Round, rng: np.random.Generator) -> None:
    """Points along the ray lie all outside or all inside before the hit, and on the other side right behind it."""
    primitive, pose = random_primitive(rng, kind), random_pose(rng, 2.0)
    scene = RayScene((revolved(primitive, 24),), pose[None])
    origins, directions = random_rays(rng, 600, scene)
    origins[::3] = pose[:3, 3] + rng.uniform(-0.02, 0.02, (200, 3))
    truth = curve_hits(primitive, pose, origins, directions)
    distance, is_hit = truth.hits.distance, truth.hits.element == 0
    assert truth.sure.sum() > 400
    assert (truth.sure & is_hit).sum() > 200

    def outside(along: np.ndarray) -> np.ndarray:
        x, y, z = np.moveaxis((origins + along[:, None] * directions - pose[:3, 3]) @ pose[:3, :3], 1, 0)
        radial, half = np.hypot(x, y), primitive.length / 2.0
        if kind is Round.CYLINDER:
            return (radial > primitive.radius) | (np.abs(z) > half)
        if kind is Round.CONE:
            return (radial > primitive.radius * (half - z) / primitive.length) | (z < -half)
        return np.hypot(radial, np.maximum(np.abs(z) - half, 0.0)) > primitive.radius

    ends = np.where(is_hit, distance, 12.0)
    begins = outside(np.zeros(600))
    for part in (*rng.uniform(0.0, 1.0, 50), 1.0 - 1e-6):
        np.testing.assert_array_equal(outside(part * ends)[truth.sure], begins[truth.sure])
    hit = truth.sure & is_hit
    assert (outside(ends + 1e-5)[hit] != begins[hit]).all()
    slope = np.einsum("ij,ij->i", truth.hits.normal, directions)
    assert (slope[hit] < 0.0).all()


@pytest.mark.parametrize("kind", Round, ids=lambda kind: kind.value)
def test_the_kit_s_normals_of_curves_are_their_slopes(kind: Round, rng: np.random.Generator) -> None:
    """Two rays beside one another end on a line that is at right angles to the normal."""
    primitive, pose = random_primitive(rng, kind), random_pose(rng, 2.0)
    origins, directions = random_rays(rng, 300, RayScene((revolved(primitive, 24),), pose[None]))
    truth = curve_hits(primitive, pose, origins, directions)
    for _ in range(2):
        # So close by that the line is one even where the tip of a cone bends it most.
        sideways = np.cross(directions, rng.normal(size=3))
        beside = origins + 1e-8 * sideways / np.linalg.norm(sideways, axis=1, keepdims=True)
        other = curve_hits(primitive, pose, beside, directions)
        both = truth.sure & other.sure & (truth.hits.element == 0)
        here, there = (
            start[both] + hits.distance[both, None] * directions[both]
            for start, hits in ((origins, truth.hits), (beside, other.hits))
        )
        along = (there - here) / np.linalg.norm(there - here, axis=1, keepdims=True)
        assert np.abs(np.einsum("ij,ij->i", along, truth.hits.normal[both])).max() < 1e-2


@pytest.mark.parametrize("kind", Round, ids=lambda kind: kind.value)
def test_the_kit_s_triangles_of_curves_fill_them(kind: Round, rng: np.random.Generator) -> None:
    """By the volumes of the bodies; what the triangles cut off becomes less by the square of the segments."""
    primitive = random_primitive(rng, kind)
    r, length = primitive.radius, primitive.length
    ball, pillar = 4.0 / 3.0 * np.pi * r**3, np.pi * r * r * length
    volume = {Round.SPHERE: ball, Round.CYLINDER: pillar, Round.CONE: pillar / 3.0, Round.CAPSULE: ball + pillar}[kind]
    shape = revolved(primitive, 96)
    a, b, c = np.moveaxis(shape.vertices[shape.triangles].astype(np.float64), 1, 0)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0 == pytest.approx(volume, rel=3e-3)


def test_the_kit_s_reference_is_pybullet_s(rng: np.random.Generator) -> None:
    """Bullet keeps triangles in single precision, and its rays end."""
    scene = random_scene(rng, 12)
    origins, directions = random_rays(rng, 600, scene)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        for shape, pose in zip(scene.shapes, scene.world_t_element, strict=True):
            mesh = pybullet.createCollisionShape(
                pybullet.GEOM_MESH,
                vertices=shape.vertices.tolist(),
                indices=shape.triangles.ravel().tolist(),
                flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
                physicsClientId=client,
            )
            turn = Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()
            pybullet.createMultiBody(0.0, mesh, -1, pose[:3, 3].tolist(), turn, physicsClientId=client)
        ends = origins + LONGEST * directions
        answers = pybullet.rayTestBatch(origins.tolist(), ends.tolist(), physicsClientId=client)
    finally:
        pybullet.disconnect(client)
    truth = reference(scene, origins, directions, LONGEST, 1e-2)
    bodies = np.array([answer[0] for answer in answers])
    distances = np.array([answer[2] for answer in answers]) * LONGEST
    is_hit = truth.sure & (truth.hits.element != NO_ELEMENT)
    assert is_hit.sum() > 100
    np.testing.assert_array_equal(bodies[truth.sure], truth.hits.element[truth.sure])
    assert np.abs(distances - truth.hits.distance)[is_hit].max() < 1e-4
    normals = np.array([answer[4] for answer in answers])
    assert np.abs(normals - truth.hits.normal)[is_hit].max() < 1e-3
