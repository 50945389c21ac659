"""The scene that ray engines are compared on: 200 objects, 200,000 triangles, round a sensor, and a moving iiwa."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pybullet_data
import trimesh
from numpy.typing import NDArray
from virtualrobot_sdk.rays import Shape, make_shape

Floats = NDArray[np.float64]

DATA = Path(pybullet_data.getDataPath())
MESHES = (
    "duck.obj",
    "teddy2_VHACD_CHs.obj",
    "laikago/chassis.stl",
    "husky/meshes/wheel.stl",
    "differential/diff_stand.stl",
    "quadruped/microtaur/xm430w210.stl",
    "xarm/xarm_description/meshes/xarm6/visual/link4.stl",
    "husky/meshes/top_plate.stl",
)
"""Real meshes; each is brought to 2,000 triangles and a greatest extent of 1 m."""
TRIANGLES = 2000
OBJECTS, HALF = 200, 4.0
"""Every other object is a mesh, the others are boxes; they lie within `HALF` of the middle (m)."""
SENSOR = np.array([1.6, -1.2, 1.0])
MAX_RANGE = 30.0
LINKS = 8

BOX = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
BOX_FACES = np.array(
    "0 1 3 0 3 2 4 6 7 4 7 5 0 4 5 0 5 1 2 3 7 2 7 6 0 2 6 0 6 4 1 5 7 1 7 3".split(), np.int32
).reshape(-1, 3)


@dataclass(frozen=True, slots=True, eq=False)
class RayCell:
    """Shapes, where they are, and the row of the first of the iiwa's links, which come last."""

    shapes: tuple[Shape, ...]
    world_t_element: Floats
    first_link: int

    @property
    def triangles(self) -> int:
        """Return the count of triangles."""
        return sum(len(shape.triangles) for shape in self.shapes)

    def moved(self, angle: float) -> Floats:
        """Return where all are (e, 4, 4) with the links turned about z by `angle`, growing from link to link."""
        poses = self.world_t_element.copy()
        for link in range(LINKS):
            turn = angle * (link + 1) / LINKS
            poses[self.first_link + link, :2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        return poses


def ray_cell(seed: int = 1) -> RayCell:
    """Return the scene; random, but always the same for a seed."""
    rng = np.random.default_rng(seed)
    meshes = [unit_mesh(DATA / name) for name in MESHES]
    shapes, poses = [], []
    walls = [((0.0, 0.0, -0.06), (9.0, 9.0, 0.1))]
    walls += [((side * (HALF + 0.4), 0.0, 1.5), (0.1, 9.0, 3.0)) for side in (-1, 1)]
    walls += [((0.0, side * (HALF + 0.4), 1.5), (9.0, 0.1, 3.0)) for side in (-1, 1)]
    for place, size in walls:
        shapes.append(make_shape(BOX * size, BOX_FACES))
        poses.append(_pose(np.eye(3), np.array(place)))
    while len(shapes) < OBJECTS:
        place = np.array([*rng.uniform(-HALF, HALF, 2), rng.uniform(0.1, 2.5)])
        size = rng.uniform(0.15, 0.6)
        if np.hypot(*place[:2]) < 0.35 + size or np.linalg.norm(place - SENSOR) < 0.6:
            continue
        if len(shapes) % 2 == 0:
            vertices, faces = meshes[rng.integers(len(meshes))]
            shapes.append(make_shape(vertices * size, faces))
        else:
            shapes.append(make_shape(BOX * rng.uniform(0.4, 1.0, 3) * size, BOX_FACES))
        poses.append(_pose(np.linalg.qr(rng.normal(size=(3, 3)))[0], place))
    for link in range(LINKS):
        mesh: Any = trimesh.load_mesh(DATA / f"kuka_iiwa/meshes/link_{link}.stl")
        shapes.append(make_shape(mesh.vertices, mesh.faces))
        poses.append(_pose(np.eye(3), np.array([0.0, 0.0, 0.15 * link])))
    return RayCell(tuple(shapes), np.array(poses), OBJECTS)


def spinning(beams: int = 16, columns: int = 1800) -> Floats:
    """Return the directions (beams * columns, 3) of a spinning head, 15 degrees up and down, beam after beam."""
    elevation, azimuth = np.meshgrid(
        np.radians(np.linspace(-15.0, 15.0, beams)), np.arange(columns) * 2.0 * np.pi / columns, indexing="ij"
    )
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1).reshape(-1, 3)


def unit_mesh(path: Path) -> tuple[Floats, NDArray]:
    """Return vertices (n, 3) and faces (m, 3) of a mesh brought to a greatest extent of 1 m, about its middle."""
    mesh: Any = trimesh.load_mesh(path)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    mesh = mesh.simplify_quadric_decimation(face_count=TRIANGLES)
    vertices = np.asarray(mesh.vertices, np.float64)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    return (vertices - (low + high) / 2.0) / (high - low).max(), np.asarray(mesh.faces, np.int32)


def _pose(rotation: Floats, place: Floats) -> Floats:
    pose = np.eye(4)
    pose[:3, :3] = rotation * np.sign(np.linalg.det(rotation))
    pose[:3, 3] = place
    return pose
