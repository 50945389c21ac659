"""Primitives against their formulas: volume, area, outside, normals."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.shapes import primitives
from virtualrobot_kernel.shapes.submesh import Submesh

# A regular polygon of n corners has this part of its circle's area, which is what a cylinder or cone loses.
POLYGON = primitives.SEGMENTS / (2.0 * np.pi) * np.sin(2.0 * np.pi / primitives.SEGMENTS)


def corners(shape: Submesh) -> np.ndarray:
    return shape.vertices[shape.faces].astype(np.float64)


def volume(shape: Submesh) -> float:
    """Return the signed volume by the divergence theorem; it is positive when faces are counter-clockwise outside."""
    a, b, c = np.moveaxis(corners(shape), 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def area(shape: Submesh) -> float:
    a, b, c = np.moveaxis(corners(shape), 1, 0)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def face_normals(shape: Submesh) -> np.ndarray:
    a, b, c = np.moveaxis(corners(shape), 1, 0)
    normals = np.cross(b - a, c - a)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def normals_of(shape: Submesh) -> np.ndarray:
    assert shape.normals is not None
    return shape.normals


ALL = {
    "box": primitives.box(),
    "sphere": primitives.sphere(),
    "cylinder": primitives.cylinder(),
    "cone": primitives.cone(),
    "capsule": primitives.capsule(0.3, 0.8),
    "ball": primitives.capsule(0.3, 0.0),
    "arrow": primitives.arrow(),
    "axis arrow": primitives.axis_arrow(),
    "frame": primitives.frame(),
}


def test_box_has_the_volume_and_area_of_a_cube() -> None:
    assert volume(ALL["box"]) == pytest.approx(1.0, abs=1e-6)
    assert area(ALL["box"]) == pytest.approx(6.0, abs=1e-6)


def test_cylinder_is_a_prism_in_its_circle() -> None:
    chord = 2.0 * np.sin(np.pi / primitives.SEGMENTS)
    assert volume(ALL["cylinder"]) == pytest.approx(np.pi * POLYGON, rel=1e-5)
    assert area(ALL["cylinder"]) == pytest.approx(2.0 * np.pi * POLYGON + primitives.SEGMENTS * chord, rel=1e-5)


def test_cone_has_a_third_of_the_cylinder() -> None:
    assert volume(ALL["cone"]) == pytest.approx(np.pi * POLYGON / 3.0, rel=1e-5)


def test_sphere_is_within_one_percent_of_its_formula() -> None:
    assert volume(ALL["sphere"]) == pytest.approx(4.0 * np.pi / 3.0, rel=0.01)
    assert area(ALL["sphere"]) == pytest.approx(4.0 * np.pi, rel=0.01)
    assert np.linalg.norm(ALL["sphere"].vertices, axis=1) == pytest.approx(1.0, abs=1e-6)


def test_capsule_is_a_cylinder_and_a_sphere() -> None:
    radius, length = 0.3, 0.8
    assert volume(ALL["capsule"]) == pytest.approx(np.pi * radius**2 * (length + 4.0 * radius / 3.0), rel=0.01)
    assert np.ptp(ALL["capsule"].vertices[:, 2]) == pytest.approx(length + 2.0 * radius)


def test_a_capsule_without_length_is_a_sphere() -> None:
    assert volume(ALL["ball"]) == pytest.approx(4.0 * np.pi / 3.0 * 0.3**3, rel=0.01)


def test_frame_has_red_x_green_y_blue_z() -> None:
    frame = ALL["frame"]
    assert frame.vertex_colors is not None
    for axis, color in enumerate((primitives.RED, primitives.GREEN, primitives.BLUE)):
        arrow = frame.vertices[(frame.vertex_colors == color).all(axis=1)]
        assert arrow[:, axis].max() == pytest.approx(1.0)
        assert np.abs(np.delete(arrow, axis, axis=1)).max() < 0.1


def test_axis_arrow_reaches_one_meter_both_ways() -> None:
    heights = ALL["axis arrow"].vertices[:, 2]
    assert (heights.min(), heights.max()) == (pytest.approx(-1.0), pytest.approx(1.0))


@pytest.mark.parametrize("name", ALL)
def test_every_edge_joins_two_faces_that_run_along_it_in_opposite_ways(name: str) -> None:
    """The surface is closed and turned the same way everywhere (closed orientable manifold)."""
    shape = ALL[name]
    places = np.unique(np.round(shape.vertices, 5) + 0.0, axis=0, return_inverse=True)[1].reshape(-1)
    faces = places[shape.faces]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    forth, count = np.unique(edges, axis=0, return_counts=True)
    back = np.unique(edges[:, ::-1], axis=0)
    assert np.array_equal(forth, back)
    assert name == "frame" or count.max() == 1  # the three arrows of a frame start with discs that cross


@pytest.mark.parametrize("name", ALL)
def test_normals_are_units_and_point_out_of_their_faces(name: str) -> None:
    shape = ALL[name]
    normals = normals_of(shape)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=1e-5)
    assert volume(shape) > 0.0
    agreement = np.einsum("ij,ikj->ik", face_normals(shape), normals[shape.faces])
    # A cone's tip joins normals from all around, so that one corner of a face may be up to 90 degrees off.
    assert np.sort(agreement, axis=1)[:, 1:].min() > 0.9


def test_scaling_a_sphere_keeps_its_normals_upright(rng: np.random.Generator) -> None:
    """The normal of the ellipsoid x/a, y/b, z/c at p is along (x/a^2, y/b^2, z/c^2)."""
    scale = rng.uniform(0.2, 3.0, 3)
    ellipsoid = primitives.transformed(primitives.sphere(), tuple(scale), (1.0, 2.0, 3.0))
    places = ellipsoid.vertices - np.array([1.0, 2.0, 3.0])
    expected = places / scale**2
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    assert normals_of(ellipsoid) == pytest.approx(expected, abs=1e-4)
