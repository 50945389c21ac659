"""Convex hulls against scipy's Qhull, and what they leave out when they may have few corners."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull
from virtualrobot_kernel.numeric.hull import convex_hull


def hull(points: np.ndarray, most: int = 4096) -> tuple[np.ndarray, float]:
    """Return the triangles (k, 3) of the hull of points, and how far it is exceeded."""
    faces, exceeded = np.empty((2 * most, 3), np.int32), np.empty(1)
    count = convex_hull(np.ascontiguousarray(points, np.float64), most, faces, exceeded)
    return faces[:count], float(exceeded[0])


def clouds(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return points with and without many in a plane, as meshes have them: single floats."""
    grid = np.linspace(0.0, 1.0, 9)
    sphere = rng.normal(size=(1000, 3))
    angle = np.arange(60) * (2 * np.pi / 60)
    rings = [np.stack([np.cos(angle), np.sin(angle), np.full(60, z)], axis=1) for z in (0.0, 0.4, 1.0)]
    found = {
        "grid": np.array(np.meshgrid(grid, grid, grid)).reshape(3, -1).T,
        "ball": rng.normal(size=(3000, 3)),
        "sphere": sphere / np.linalg.norm(sphere, axis=1, keepdims=True),
        "cylinder": np.concatenate(rings),
        "twice": np.repeat(rng.normal(size=(200, 3)), 3, axis=0),
        "needle": rng.normal(size=(500, 3)) * (1.0, 1e-3, 1e-3),
    }
    return {name: points.astype(np.float32).astype(np.float64) for name, points in found.items()}


@pytest.mark.parametrize("kind", ["grid", "ball", "sphere", "cylinder", "twice", "needle"])
def test_hulls_are_those_of_qhull(rng: np.random.Generator, kind: str) -> None:
    """Closed, of the same volume and surface, with no point outside."""
    points = clouds(rng)[kind]
    faces, exceeded = hull(points)
    mesh = trimesh.Trimesh(points, faces, process=False)
    theirs = ConvexHull(points)
    assert mesh.is_watertight and mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(theirs.volume, rel=1e-9, abs=exceeded * theirs.area)
    assert mesh.area == pytest.approx(theirs.area, rel=1e-6)
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    real = length > 0.0
    above = ((points[None] - a[real, None]) * (normals[real] / length[real, None])[:, None]).sum(axis=2)
    most = 1e-6 * np.ptp(points, axis=0).max()
    # High above the plane of a sliver a point may be beside its edge.
    for point in points[(above > most).any(axis=0)]:
        near = trimesh.triangles.closest_point(points[faces], np.tile(point, (len(faces), 1)))
        assert np.linalg.norm(near - point, axis=1).min() <= most
    assert exceeded <= most


def test_few_corners_leave_out_what_they_say(rng: np.random.Generator) -> None:
    """Every point is at most so far outside, by scipy's and trimesh's distances; more corners leave out less."""
    points = clouds(rng)["sphere"]
    last = np.inf
    for most in (4, 8, 32, 128, 512):
        faces, exceeded = hull(points, most)
        assert len(faces) == 2 * most - 4
        mesh = trimesh.Trimesh(points, faces, process=False)
        assert mesh.is_watertight
        triangles = points[faces]
        gaps = []
        for point in points:
            inside = ((point - triangles[:, 0]) * mesh.face_normals).sum(axis=1).max() <= 0.0
            near = trimesh.triangles.closest_point(triangles, np.tile(point, (len(triangles), 1)))
            gaps.append(0.0 if inside else np.linalg.norm(near - point, axis=1).min())
        assert max(gaps) <= exceeded + 1e-9
        assert exceeded < last
        last = exceeded


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.eye(3), np.zeros((50, 3)), np.ones((9, 1)) * [1.0, 2.0, 3.0]])
def test_what_is_flat_has_no_hull(points: np.ndarray) -> None:
    assert len(hull(points)[0]) == 0
    flat = np.random.default_rng(0).normal(size=(300, 3)) * (1.0, 1.0, 0.0)
    assert len(hull(flat)[0]) == 0
