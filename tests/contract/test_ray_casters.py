"""The suite for ray casters: a plain one keeps it, and each wrong one is found by the law that it breaks."""

from __future__ import annotations

import re

import numpy as np
import pybullet
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_sdk.rays import NO_ELEMENT, Shape
from virtualrobot_sdk.testing.ray_casters import RayCasterContract
from virtualrobot_sdk.testing.ray_truth import box, random_rays, random_scene, reference, sphere, tetrahedron

from tests.contract.breaking import broken

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
    "WritesToRays": ("scenes", r"ValueError: output array is read-only \(ray_casters\.py:\d+ in cast\)"),
}


class TestMoellerTrumbore(RayCasterContract):
    component = f"{COMPONENTS}:MoellerTrumbore"


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_one_is_found(name: str, seed: int) -> None:
    law, said = WRONG[name]
    found = broken(RayCasterContract, f"{COMPONENTS}:{name}", law, seed)
    assert re.search(said, found), found


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
    assert is_hit.sum() > 200
    np.testing.assert_array_equal(bodies[truth.sure], truth.hits.element[truth.sure])
    assert np.abs(distances - truth.hits.distance)[is_hit].max() < 1e-4
    normals = np.array([answer[4] for answer in answers])
    assert np.abs(normals - truth.hits.normal)[is_hit].max() < 1e-3
