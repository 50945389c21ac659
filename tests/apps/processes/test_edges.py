"""Edges of meshes as seams: known lines and curves, and meshes that are refused."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import trimesh
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.processes.part import joined
from virtualrobot_apps.processes.sources.edges import edges, nearest
from virtualrobot_apps.processes.sources.sampling import sampled
from virtualrobot_apps.processes.sources.surface import solid_of, surface_of

from tests.apps.processes.workpieces import (
    BRANCH,
    MAIN,
    SEGMENTS,
    WALL,
    box,
    plate,
    sheet,
    tee_joint,
    tee_of_pipes,
    together,
    wall,
)


def test_the_foot_of_a_wall_is_four_seams() -> None:
    """Lines on z = 0 round a rectangle of 200 x 10 mm, with the normals of floor and wall on their sides."""
    found = edges(tee_joint())
    assert [way.length for way in found] == pytest.approx([0.2, 0.2, 0.01, 0.01])
    for way in found:
        np.testing.assert_allclose(np.abs(way.points), [[WALL[0] / 2, WALL[1] / 2, 0.0]] * 2, atol=1e-12)
        assert not way.closed
        middle, along = way.points.mean(axis=0), way.tangents[0]
        away = middle / np.linalg.norm(middle)
        for left, right in way.normals:
            # The face on the left of a concave edge looks to its right.
            np.testing.assert_allclose(sorted([left.tolist(), right.tolist()]), sorted([[0, 0, 1], away.tolist()]))
            assert np.cross(left + right, along) @ (left - right) < 0.0
    front = nearest(found, [0.0, 0.02, 0.0])
    np.testing.assert_allclose(front.points[:, 1], 0.005)
    assert nearest(found, [0.11, 0.0, 0.0]).length == pytest.approx(0.01)


def test_convex_edges_are_all_the_others() -> None:
    """Twelve of the plate, and eight of the wall: its foot's are concave."""
    convex = edges(tee_joint(), "convex")
    assert len(convex) == 20
    lengths = 4 * (0.4 + 0.3 + 0.02) + 2 * (0.2 + 0.01) + 4 * 0.1
    assert sum(way.length for way in convex) == pytest.approx(lengths)
    assert not edges(box((0.1, 0.1, 0.1)))
    with pytest.raises(InvalidArgumentError, match="edges are concave or convex, not 'sharp'"):
        edges(plate(), "sharp")


def test_chains_are_split_at_corners_alone() -> None:
    """The foot of the wall is one loop where corners of a right angle are none; short edges can be left out."""
    (loop,) = edges(tee_joint(), corner=np.radians(120.0))
    assert loop.closed and loop.length == pytest.approx(0.42)
    np.testing.assert_allclose(loop.points[0], loop.points[-1])
    np.testing.assert_allclose(loop.points[0], [-0.1, -0.005, 0.0], atol=1e-12)
    assert len(edges(tee_joint(), least=0.05)) == 2


def test_the_seam_of_two_pipes_is_the_saddle_curve() -> None:
    """Pipes of 96 sides are within their sagitta, r (1 - cos(pi / 96)), of the true ones, and so is their seam."""
    (seam,) = edges(tee_of_pipes())
    assert seam.closed
    sagitta = 1.0 - np.cos(np.pi / SEGMENTS)
    for way in (seam, sampled(seam, 1e-4, 2e-3)):
        x, y, z = way.points.T
        assert np.abs(np.hypot(x, y) - BRANCH).max() <= BRANCH * sagitta * 1.05
        assert np.abs(np.hypot(x, z) - MAIN).max() <= MAIN * sagitta * 1.05
    angle = np.linspace(0.0, 2.0 * np.pi, 20_001)
    saddle = np.stack([np.cos(angle), np.sin(angle), np.sqrt((MAIN / BRANCH) ** 2 - np.cos(angle) ** 2)], axis=1)
    assert seam.length == pytest.approx(BRANCH * np.linalg.norm(np.diff(saddle, axis=0), axis=1).sum(), rel=1e-3)
    dense = sampled(seam, 1e-4, 2e-3)
    assert np.linalg.norm(np.diff(dense.points, axis=0), axis=1).max() <= 2e-3 * 1.01
    # Normals of the pipes: (x, y, 0) / r and (x, 0, z) / R, one on either side; half a side is 1.9 degrees.
    x, y, z = dense.points.T
    branch, main = (np.stack(one, axis=1) for one in ((x, y, 0 * z), (x, 0 * y, z)))
    if (dense.normals[0, 0] @ branch[0]) < (dense.normals[0, 1] @ branch[0]):
        branch, main = main, branch
    for side, true in enumerate((branch, main)):
        cosines = np.einsum("ij,ij->i", dense.normals[:, side], true / np.linalg.norm(true, axis=1)[:, None])
        assert np.degrees(np.arccos(cosines.clip(-1.0, 1.0))).max() < 2.0


def test_bodies_that_touch_are_joined_to_one() -> None:
    """The foot of a wall that stands on a plate is a seam, whether they are one mesh or two; both have two bodies."""
    for meshes in ([plate(), wall()], [together(plate(), wall())]):
        assert [way.length for way in edges(joined(meshes))] == pytest.approx([0.2, 0.2, 0.01, 0.01])
    open_wall = wall()
    open_wall.update_faces(np.arange(len(open_wall.faces)) > 1)
    with pytest.raises(InvalidArgumentError, match=r"body 2 of 2 can't be joined: the mesh is open"):
        joined([plate(), open_wall])


def inside_out() -> trimesh.Trimesh:
    mesh = plate()
    mesh.invert()
    return mesh


def with_a_turned_triangle() -> trimesh.Trimesh:
    mesh = plate()
    return trimesh.Trimesh(mesh.vertices, np.concatenate([mesh.faces[:1, ::-1], mesh.faces[1:]]), process=False)


def with_a_flat_triangle() -> trimesh.Trimesh:
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0, 0]]
    triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 1, 4]]
    return trimesh.Trimesh(corners, triangles, process=False)


def with_nan() -> trimesh.Trimesh:
    return trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], process=False)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: sheet(), r"the mesh is open: 28 of its edges have one triangle alone, the first at \("),
        (inside_out, r"the mesh is inside out: its volume is -2400 cm\^3"),
        (lambda: together(plate(), box((0.1, 0.1, 0.1), (0, 0, 1))), "the mesh has 2 bodies"),
        (lambda: together(plate(), plate()), "has more than two triangles: two bodies touch there"),
        (with_a_turned_triangle, "has two triangles that lie different ways round"),
        (with_a_flat_triangle, r"1 of 5 triangles of the mesh have no area, the first at \(0, 0, 0\) mm"),
        (with_nan, r"corner 2 of the mesh is \[0.0, nan, 0.0\]; it must be finite"),
        (lambda: trimesh.Trimesh(), "the mesh has no triangles"),
        (lambda: trimesh.Trimesh(np.ones((3, 3)), [[0, 1, 2]], process=False), "the mesh has no size"),
    ],
    ids=["open", "inside out", "two bodies", "doubled", "turned", "flat", "nan", "empty", "a point"],
)
def test_meshes_without_clear_edges_are_refused(make: Callable[[], trimesh.Trimesh], words: str) -> None:
    with pytest.raises(InvalidArgumentError, match=words):
        edges(make())


def test_corners_that_each_triangle_has_of_its_own_are_joined() -> None:
    """As files of triangles have them (STL); triangles that become lines by that are left out."""
    mesh = plate()
    apart = trimesh.Trimesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(36).reshape(-1, 3), process=False)
    assert len(solid_of(apart).corners) == 8
    more = trimesh.Trimesh(apart.vertices, np.concatenate([apart.faces, [[0, 1, 0]]]), process=False)
    assert len(surface_of(more).triangles) == 12
    assert len(edges(more, "convex")) == 12
