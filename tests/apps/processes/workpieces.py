"""Workpieces with edges that formulas tell."""

from __future__ import annotations

import numpy as np
import trimesh

PLATE, WALL = (0.4, 0.3, 0.02), (0.2, 0.01, 0.1)
MAIN, BRANCH, SEGMENTS = 0.15, 0.08, 96
"""Radii (m) of the pipes of a tee, and the number of their sides."""


def box(size: tuple[float, float, float], at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> trimesh.Trimesh:
    """Return a box about a point (m)."""
    return trimesh.creation.box(size, np.block([[np.eye(3), np.array(at)[:, None]], [np.zeros(3), 1.0]]))


def plate() -> trimesh.Trimesh:
    """Return a plate whose upper face is at z = 0."""
    return box(PLATE, (0.0, 0.0, -0.5 * PLATE[2]))


def wall() -> trimesh.Trimesh:
    """Return a wall that stands on it."""
    return box(WALL, (0.0, 0.0, 0.5 * WALL[2]))


def together(*meshes: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return meshes as one, of several bodies."""
    one = trimesh.util.concatenate(meshes)
    assert isinstance(one, trimesh.Trimesh)
    return one


def tee_joint() -> trimesh.Trimesh:
    """Return a wall on a plate: its foot is four seams on z = 0."""
    return trimesh.boolean.union([plate(), wall()], engine="manifold")


def tee_of_pipes() -> trimesh.Trimesh:
    """Return a pipe along z on one along y, about the origin: where they meet, x^2 + y^2 = r^2 and x^2 + z^2 = R^2."""
    main = trimesh.creation.cylinder(MAIN, 0.7, sections=SEGMENTS)
    main.apply_transform(trimesh.transformations.rotation_matrix(0.5 * np.pi, [1.0, 0.0, 0.0]))
    branch = trimesh.creation.cylinder(BRANCH, 0.3, sections=SEGMENTS)
    branch.apply_translation([0.0, 0.0, 0.15])
    return trimesh.boolean.union([main, branch], engine="manifold")


def sheet(slope: float = 0.0, size: float = 0.2, cells: int = 7) -> trimesh.Trimesh:
    """Return a square sheet of triangles about the origin, facing up, that rises along y by an angle (rad)."""
    grid = np.linspace(-0.5 * size, 0.5 * size, cells + 1)
    x, v = (one.ravel() for one in np.meshgrid(grid, grid, indexing="ij"))
    corners = np.stack([x, v * np.cos(slope), v * np.sin(slope)], axis=1)
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    next_x = first + cells + 1
    triangles = np.concatenate(
        [np.stack([first, next_x, next_x + 1], axis=1), np.stack([first, next_x + 1, first + 1], axis=1)]
    )
    return trimesh.Trimesh(corners, triangles, process=False)
