"""Normals made for triangles that have none: sharp on a cube, smooth on a sphere."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.shapes import primitives
from virtualrobot_kernel.shapes.creases import MOST_FACES, with_normals
from virtualrobot_kernel.shapes.submesh import Submesh


def welded(shape: Submesh) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and faces with each place once, as STL files are read."""
    vertices, place = np.unique(np.round(shape.vertices, 5) + 0.0, axis=0, return_inverse=True)
    faces = place.reshape(-1)[shape.faces]
    return vertices.astype(np.float32), faces.astype(np.int32)


def test_a_cube_keeps_flat_sides() -> None:
    vertices, faces = welded(primitives.box())
    assert len(vertices) == 8
    rows, split, normals = with_normals(vertices, faces)
    assert len(rows) == 24  # each corner once for each of its three sides
    assert np.array_equal(vertices[rows][split], vertices[faces])
    assert np.sort(np.abs(normals), axis=1) == pytest.approx(np.tile([0.0, 0.0, 1.0], (24, 1)), abs=1e-6)
    centers = vertices[faces].mean(axis=1)
    assert np.einsum("ij,ikj->ik", centers, normals[split]).min() > 0.0


def test_a_sphere_becomes_smooth() -> None:
    vertices, faces = welded(primitives.sphere())
    rows, _, normals = with_normals(vertices, faces)
    assert len(rows) == len(vertices)
    # The normal of a sphere is its radius; the mean over facets of 7.5 degrees stays within 2 degrees of it.
    assert np.einsum("ij,ij->i", normals, vertices[rows]).min() > np.cos(np.radians(2.0))


def test_a_cylinder_is_smooth_around_and_sharp_at_its_rims() -> None:
    vertices, faces = welded(primitives.cylinder())
    rows, _, normals = with_normals(vertices, faces)
    side = np.abs(normals[:, 2]) < 0.5
    places = vertices[rows]
    assert np.einsum("ij,ij->i", normals[side, :2], places[side, :2]).min() > 0.99
    assert np.abs(normals[~side, 2]) == pytest.approx(1.0, abs=1e-6)


def test_a_vertex_with_very_many_faces_is_shaded_too() -> None:
    """A flat fan around one vertex: all normals are the plane's."""
    angles = np.linspace(0.0, 2.0 * np.pi, 4 * MOST_FACES, endpoint=False)
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    vertices = np.concatenate([[[0.0, 0.0, 0.0]], rim]).astype(np.float32)
    index = np.arange(len(rim))
    faces = np.stack([np.zeros_like(index), index + 1, (index + 1) % len(rim) + 1], axis=1).astype(np.int32)
    rows, _, normals = with_normals(vertices, faces)
    assert len(rows) == len(vertices)
    assert normals == pytest.approx(np.tile([0.0, 0.0, 1.0], (len(rows), 1)), abs=1e-6)


def test_a_face_without_area_gets_unit_normals() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], np.float32)
    _, _, normals = with_normals(vertices, np.array([[0, 1, 2]], np.int32))
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
