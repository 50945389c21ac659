"""Small scenes for cameras, without a world: figures at their places, and a camera that looks at them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike, NDArray
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.sensing.elements import Elements
from virtualrobot_kernel.sensing.lights import NONE, Lights, light_row
from virtualrobot_kernel.sensing.picture import Subject
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Figure, Geometry, Material, Mesh
from virtualrobot_kernel.world.sensing import Light
from virtualrobot_sdk.embree import TopScene

Rgba = tuple[float, float, float, float]
Thing = tuple[Geometry, NDArray[np.float64], Rgba | None]
"""A geometry, where it is (4, 4), and its material's colour."""


def at(*place: float, turn: ArrayLike | None = None) -> NDArray[np.float64]:
    """Return a pose at `place`, turned by a matrix (3, 3)."""
    pose = np.eye(4)
    pose[:3, 3] = place
    if turn is not None:
        pose[:3, :3] = turn
    return pose


def looking(eye: ArrayLike, target: ArrayLike) -> NDArray[np.float64]:
    """Return the pose of a camera at `eye` that looks at `target`, upright (or with its x along the world's)."""
    place = np.asarray(eye, float)
    z = np.asarray(target, float) - place
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x = np.array([1.0, 0.0, 0.0]) if np.linalg.norm(x) < 1e-9 else x / np.linalg.norm(x)
    return at(*place, turn=np.stack([x, np.cross(z, x), z], axis=1))


def lit_by(*lights: tuple[Light, NDArray[np.float64]]) -> Lights:
    """Return lights at their places."""
    rows = [light_row(light, pose) for light, pose in lights]
    return Lights(np.array(rows, np.float32), np.array([not light.shadowless for light, _ in lights]))


@contextmanager
def studio(
    things: Sequence[Thing],
    lights: Lights = NONE,
    meshes: Mapping[str, tuple[Submesh, ...]] | None = None,
    background: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Iterator[tuple[TopScene, Subject]]:
    """Give a scene of things and what is to be seen of them; `meshes` are by SHA-256."""

    def load(mesh: Mesh) -> tuple[Submesh, ...]:
        return (meshes or {})[mesh.sha256]

    library = ShapeLibrary(load)
    figures = tuple(Figure(geometry, material=color and Material(color)) for geometry, _, color in things)
    shapes = [library.get(figure.geometry) for figure in figures]
    count = len(figures)
    elements = Elements(
        shapes=tuple(shape for shape in shapes if shape is not None),
        figures=figures,
        uids=np.arange(count),
        rows=np.arange(count),
        node_t_element=np.tile(np.eye(4), (count, 1, 1)),
        reflectance=np.full(count, 0.5),
        made_of=None,  # type: ignore[arg-type]  there is no world
    )
    poses = np.array([pose for _, pose, _ in things]).reshape(-1, 4, 4)
    with TopScene() as scene:
        scene.place(elements.shapes, poses)
        places = np.arange(count, dtype=np.int32)
        yield scene, Subject(poses, places, AppearanceLibrary(load).of(elements), lights, background)
