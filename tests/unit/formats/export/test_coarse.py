"""Fewer triangles for the same surface: how far both are apart, by points drawn on either, and what has a picture."""

from __future__ import annotations

import io

import numpy as np
import pytest
import trimesh
from PIL import Image
from virtualrobot_kernel.formats.export.coarse import coarser
from virtualrobot_kernel.shapes.submesh import Submesh

from tests.unit.formats.models import DATA

TOLERANCE = 1e-3
LINKS = ("franka_panda/meshes/visual/hand.obj", "kuka_iiwa/meshes/link_7.stl")


def part_of(mesh: trimesh.Trimesh) -> Submesh:
    return Submesh(mesh.vertices.astype(np.float32), mesh.faces.astype(np.int32))


def apart(points: np.ndarray, triangles: np.ndarray) -> float:
    """Return how far points (n, 3) are from triangles (m, 3, 3) at most."""
    worst = 0.0
    for some in np.array_split(points, -(-len(points) * len(triangles) // 500_000)):
        nearest = trimesh.triangles.closest_point(
            np.tile(triangles, (len(some), 1, 1)), np.repeat(some, len(triangles), axis=0)
        ).reshape(len(some), len(triangles), 3)
        worst = max(worst, float(np.linalg.norm(nearest - some[:, None], axis=2).min(axis=1).max()))
    return worst


def sampled(part: Submesh, rng: np.random.Generator, count: int) -> np.ndarray:
    """Return points of a surface, as many for each area, and some of its corners."""
    mesh = trimesh.Trimesh(part.vertices, part.faces, process=False)
    points = trimesh.sample.sample_surface(mesh, count, seed=rng)[0]
    return np.vstack([points, rng.choice(part.vertices, count)])


@pytest.mark.parametrize("link", LINKS)
def test_surfaces_are_no_farther_apart_than_the_tolerance(link: str, rng: np.random.Generator) -> None:
    """The Hausdorff distance, from the full surface to the coarse one and back, by points."""
    full = part_of(trimesh.load_scene(DATA / link).to_mesh())
    coarse, _ = coarser(full, TOLERANCE)
    assert len(coarse.faces) < 0.9 * len(full.faces)
    assert apart(sampled(full, rng, 250), coarse.vertices[coarse.faces].astype(float)) <= TOLERANCE
    assert apart(sampled(coarse, rng, 250), full.vertices[full.faces].astype(float)) <= TOLERANCE


def test_a_fine_ball_becomes_a_coarse_one_and_a_fine_box_its_twelve_triangles(rng: np.random.Generator) -> None:
    """No corner of a ball leaves its radius, no triangle is deeper than the tolerance and the fine ones' 0.1 mm."""
    ball = part_of(trimesh.creation.icosphere(5, 0.2))
    coarse, _ = coarser(ball, TOLERANCE)
    assert len(coarse.faces) < len(ball.faces) / 3
    radii = np.linalg.norm(sampled(coarse, rng, 500), axis=1)
    assert 0.2 - TOLERANCE - 1e-4 < radii.min() and radii.max() < 0.2 + 1e-6
    box = part_of(trimesh.creation.box((0.3, 0.2, 0.1)).subdivide().subdivide().subdivide())
    assert len(coarser(box, TOLERANCE)[0].faces) == 12


def test_borders_and_thin_walls_stay_where_they_are() -> None:
    """A square plate without thickness keeps its corners; walls 2 mm apart don't fall into one."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, 20), np.linspace(0.0, 1.0, 20))
    corner = np.arange(380).reshape(19, 20)[:, :-1].ravel()
    faces = np.stack([corner, corner + 1, corner + 20, corner + 1, corner + 21, corner + 20], 1).reshape(-1, 3)
    plate = Submesh(np.stack([u, v, 0 * u], 2).reshape(-1, 3).astype(np.float32), faces.astype(np.int32))
    coarse, _ = coarser(plate, TOLERANCE)
    assert len(coarse.faces) == 2
    assert sorted(map(tuple, coarse.vertices.tolist())) == [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0)]
    wall, _ = coarser(part_of(trimesh.creation.box((0.3, 0.2, 0.002)).subdivide().subdivide()), TOLERANCE)
    assert np.ptp(wall.vertices, axis=0) == pytest.approx([0.3, 0.2, 0.002])
    assert len(wall.faces) == 12


def pictured(left: int, right: int) -> Submesh:
    """Return a fine square that shows a picture of two tones, the lower left quarter of it alone for uv up to 0.5."""
    pixels = np.full((8, 8, 3), left, np.uint8)
    pixels[:, 4:] = right
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    fine = trimesh.creation.box((1.0, 1.0, 1.0)).subdivide().subdivide()
    uv = (fine.vertices[:, :2] + 0.5) * [0.4, 1.0]
    part = part_of(fine)
    return Submesh(part.vertices, part.faces, uv=uv.astype(np.float32), texture=file.getvalue(), color=(1, 0.5, 1, 1))


def test_what_shows_one_color_of_a_picture_has_that_color() -> None:
    plain, tone = coarser(pictured(102, 255), TOLERANCE)
    assert plain.texture is None and plain.uv is None and len(plain.faces) == 12
    assert plain.color == (1, 0.5, 1, 1) and tone == pytest.approx((0.4, 0.4, 0.4))


def test_what_shows_a_picture_or_colors_stays_as_it_is() -> None:
    part = pictured(102, 255)
    assert part.uv is not None
    wide = Submesh(part.vertices, part.faces, uv=part.uv * np.float32(2.0), texture=part.texture)
    colored = Submesh(part.vertices, part.faces, vertex_colors=np.zeros((len(part.vertices), 4), np.uint8))
    for one in (wide, colored):
        assert coarser(one, TOLERANCE) == (one, None)


def test_triangles_without_an_area_stay() -> None:
    line = Submesh(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], np.float32), np.array([[0, 1, 2]], np.int32))
    assert len(coarser(line, TOLERANCE)[0].faces) == 1
