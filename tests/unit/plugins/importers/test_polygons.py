"""Triangles of a polygon cover it once: their areas add up, and each turns as the polygon does."""

import numpy as np
import pytest
from virtualrobot_plugins.importers import polygons
from virtualrobot_plugins.importers.polygons import newell_normal, triangulate, triangulate_one


def star(rng: np.random.Generator, corners: int) -> np.ndarray:
    """Return a polygon around the origin, counter-clockwise, with bays as deep as they come, somewhere in space."""
    # No two corners more than half a turn apart, or edges would cross.
    angles = 2.0 * np.pi * (np.arange(corners) + rng.uniform(-0.2, 0.2, corners)) / corners
    radii = rng.uniform(0.05, 2.0, corners)
    flat = np.column_stack([radii * np.cos(angles), radii * np.sin(angles), np.zeros(corners)])
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return flat @ turn.T + rng.uniform(-3.0, 3.0, 3)


def test_areas_of_random_polygons(rng: np.random.Generator) -> None:
    for corners in (3, 4, 5, 8, 20, 60):
        points = star(rng, corners)
        faces = triangulate_one(points)
        assert len(faces) == corners - 2
        whole = newell_normal(points) / 2.0
        normals = np.array([newell_normal(points[face]) / 2.0 for face in faces])
        assert normals.sum(axis=0) == pytest.approx(whole, abs=1e-9)
        # All look the same way, so the areas add up only when nothing is covered twice.
        assert np.linalg.norm(normals, axis=1).sum() == pytest.approx(np.linalg.norm(whole), abs=1e-9)


def test_polygons_of_several_lengths_keep_their_order() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.2, 0]], float)
    arrow = [0, 4, 1, 2, 3]  # concave at 4
    corners = np.array([0, 1, 2, 3, *arrow, 0, 1, 0, 1, 2])
    triangles, owner = triangulate(points, corners, np.array([4, 5, 2, 3]))
    assert owner.tolist() == [0, 0, 1, 1, 1, 3]
    area = [float(newell_normal(points[corners[t]])[2]) / 2.0 for t in triangles]
    assert sum(area[:2]) == pytest.approx(1.0) and sum(area[2:5]) == pytest.approx(0.9)
    assert min(area) > 0.0


def test_crossed_and_flat_polygons_end(rng: np.random.Generator) -> None:
    bow = np.array([[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]], float)
    assert len(triangulate_one(bow)) == 2
    line = np.column_stack([np.arange(7.0), np.zeros(7), np.zeros(7)])
    assert len(triangulate_one(line)) == 5
    assert len(triangulate_one(rng.normal(size=(40, 3)))) == 38


def test_a_huge_concave_polygon_is_cut_as_a_fan(rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(polygons, "MAX_CONCAVE_CORNERS", 10)
    assert triangulate_one(star(rng, 30))[:, 0].tolist() == [0] * 28
