"""Grasps on bodies whose good grasps are known, judged by a linear program of their own."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.optimize import linprog
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.seeing.grasping.antipodal import Grasp, GraspError, Jaw, grasps
from virtualrobot_apps.seeing.grasping.surface import Floats, Surface, surface_of_cloud, surface_of_mesh

JAW = Jaw(0.08)
FRICTION = 0.5


def sampled(mesh: trimesh.Trimesh, rng: np.random.Generator, count: int = 1500) -> Surface:
    """Return the surface of a mesh."""
    return surface_of_mesh(mesh.vertices, mesh.faces, count, rng)


def holds(contacts: Floats, inward: Floats, friction: float) -> bool:
    """Return whether soft fingers at contacts (2, 3) with normals (2, 3) resist any wrench.

    Forces within friction cones of 16 sides and torques about normals must sum to zero with all parts above zero, and
    span all six dimensions: K. M. Lynch, F. C. Park, Modern Robotics, 2017, 12.1.7.
    """
    wrenches = []
    for place, normal in zip(contacts - contacts.mean(axis=0), inward, strict=True):
        first = np.cross(normal, [1.0, 0.0, 0.0] if abs(normal[0]) < 0.9 else [0.0, 1.0, 0.0])
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        for angle in np.arange(16) * np.pi / 8.0:
            force = normal + friction * (np.cos(angle) * first + np.sin(angle) * second)
            for spin in (-0.01, 0.01):
                wrenches.append(np.concatenate([force, np.cross(place, force) + spin * normal]))
    matrix = np.array(wrenches).T
    matrix[3:] /= np.linalg.norm(contacts[1] - contacts[0])
    if np.linalg.matrix_rank(matrix, tol=1e-6) < 6:
        return False
    found = linprog(np.ones(matrix.shape[1]), A_eq=matrix, b_eq=np.zeros(6), bounds=(1.0, None))
    return found.status == 0


@pytest.mark.parametrize("shape", ["box", "cylinder", "ball"])
def test_what_is_found_holds_against_any_wrench(shape: str, rng: np.random.Generator) -> None:
    mesh = {
        "box": trimesh.creation.box((0.05, 0.07, 0.12)),
        "cylinder": trimesh.creation.cylinder(0.03, 0.12, sections=48),
        "ball": trimesh.creation.icosphere(2, 0.03),
    }[shape]
    found = grasps(sampled(mesh, rng), JAW, rng, friction=FRICTION, samples=200)
    assert len(found) > 100
    for grasp in found[:: len(found) // 8]:
        rotation = grasp.pose[:3, :3]
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(rotation) > 0.0 and 0.0 <= grasp.quality <= 1.0
        contacts = grasp.pose[:3, 3] + 0.5 * grasp.width * np.array([-1.0, 1.0])[:, None] * rotation[:, 1]
        nearest, away, faces = trimesh.proximity.closest_point_naive(mesh, contacts)
        assert away.max() < 0.004
        assert holds(nearest, -mesh.face_normals[faces], FRICTION)


def test_fingers_close_across_a_box_and_come_from_where_there_is_room(rng: np.random.Generator) -> None:
    """A box 50 x 120 mm on a table: only its narrow side fits a jaw of 80 mm, and no finger is in the table."""
    surface = sampled(trimesh.creation.box((0.05, 0.12, 0.12)), rng)
    table = np.column_stack([rng.uniform(-0.2, 0.2, (4000, 2)), np.full(4000, -0.06)])
    found = grasps(surface, JAW, rng, obstacles=table)
    best = found[0]
    assert abs(best.pose[0, 1]) > 0.95 and abs(best.width - 0.05) < 0.003
    tips = np.array([one.pose[:3, 3] + JAW.tip * one.pose[:3, 2] for one in found])
    assert tips[:, 2].min() > -0.065
    assert best.quality > 0.5 and np.linalg.norm(best.pose[:3, 3]) < 0.04


def test_a_thin_plate_is_gripped_across_its_thickness(rng: np.random.Generator) -> None:
    """Points of its far side lie within a finger's pad, and are no edge: a hand comes from its rim."""
    plate = trimesh.creation.box((0.15, 0.1, 0.003))
    found = grasps(surface_of_mesh(plate.vertices, plate.faces, 1500, rng), JAW, rng)
    assert len(found) > 100
    for one in found:
        assert abs(one.pose[2, 1]) > 0.8 and one.width < 0.006
        assert np.abs(one.pose[2, 3]) < 0.002


def test_a_cloud_that_was_seen_from_around_is_gripped_like_its_mesh(rng: np.random.Generator) -> None:
    """Points of a cylinder, 30 mm in radius, with noise of 0.5 mm: lines between contacts go through its axis."""
    turn, z = rng.uniform(0.0, 2.0 * np.pi, 3000), rng.uniform(-0.06, 0.06, 3000)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(3000)])
    points = out * (0.03 + rng.normal(0.0, 0.0005, (3000, 1))) + z[:, None] * [0.0, 0.0, 1.0]
    surface = surface_of_cloud(points, 1.0 * out)
    assert (surface.normals * out).sum(axis=1).min() > 0.5
    found = grasps(surface, JAW, rng)
    assert np.median([np.hypot(*one.pose[:2, 3]) for one in found[:50]]) < 0.006
    assert np.median([one.width for one in found[:50]]) == pytest.approx(0.06, abs=0.003)


def test_bad_bodies_and_jaws_are_refused_in_words(rng: np.random.Generator) -> None:
    cube = trimesh.creation.box((0.12, 0.13, 0.14))
    with pytest.raises(GraspError, match=r"the jaw opens to 0\.080 m, and this body is 0\.1[12]\d m wide"):
        grasps(sampled(cube, rng), JAW, rng)
    inside_out = surface_of_mesh(cube.vertices, cube.faces[:, ::-1], 500, rng)
    assert (inside_out.normals * inside_out.points).sum(axis=1).min() > 0.0
    plate = np.array([(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0)])
    with pytest.raises(GraspError, match="no two places of this body are opposite"):
        grasps(surface_of_mesh(plate, [(0, 1, 2)], 200, rng), JAW, rng)
    with pytest.raises(InvalidArgumentError, match="a mesh of 1 triangles has no area"):
        surface_of_mesh(np.zeros((3, 3)), [(0, 1, 2)], 200, rng)
    with pytest.raises(InvalidArgumentError, match="a cloud has 16 points at least, not 0"):
        surface_of_cloud(np.zeros((0, 3)), np.zeros(3))
    cloud = rng.normal(size=(20, 3))
    cloud[3] = np.nan
    with pytest.raises(InvalidArgumentError, match="1 of 20 points of a cloud are not finite, the first is number 3"):
        surface_of_cloud(cloud, np.zeros(3))
    with pytest.raises(InvalidArgumentError, match="20 points was seen from 1 place or as many, not 2"):
        surface_of_cloud(np.ones((20, 3)), np.zeros((2, 3)))
    with pytest.raises(InvalidArgumentError, match="a surface has a normal for each point, not 19 for 20"):
        Surface(np.ones((20, 3)), np.ones((19, 3)))
    with pytest.raises(InvalidArgumentError, match="a friction coefficient is above 0"):
        grasps(sampled(cube, rng), JAW, rng, friction=0.0)
    with pytest.raises(InvalidArgumentError, match="sizes of a jaw are above 0"):
        Jaw(-0.1)
    boxed = trimesh.creation.box((0.05, 0.05, 0.05))
    cage = rng.uniform(-0.2, 0.2, (60000, 3))
    cage = cage[np.abs(cage).max(axis=1) > 0.03]
    with pytest.raises(GraspError, match="have no room on both sides of any of"):
        grasps(sampled(boxed, rng, 300), JAW, rng, obstacles=cage, samples=30)


def test_the_same_numbers_give_the_same_grasps() -> None:
    def once() -> list[Grasp]:
        rng = np.random.default_rng(3)
        return grasps(sampled(trimesh.creation.box((0.05, 0.05, 0.1)), rng, 500), JAW, rng, samples=50)

    for one, other in zip(once(), once(), strict=True):
        np.testing.assert_array_equal(one.pose, other.pose)
