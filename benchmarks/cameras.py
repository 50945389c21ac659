"""Cameras against PyBullet's software renderer and VTK: 640 x 480 pixels, 200 objects and a moving arm, on one core.

PyBullet draws colour, depth and segmentation, VTK colour with one light without shadows and depth. The budgets are so
many pictures a second.
"""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Iterator

import numpy as np
import pybullet
from PIL import Image
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.sensing.camera_reader import CameraReader
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.sensing import CameraSensor, ImageKind, Intrinsics, Light, LightKind
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from benchmarks.camera_peers import FIELD, HEIGHT, TARGET, WIDTH, BulletCamera, VtkCamera
from benchmarks.ray_cell import SENSOR, RayCell, ray_cell
from benchmarks.ray_world import ray_world, snapshots
from benchmarks.rays import WARM, Scan, in_turn
from benchmarks.rows import Row, row

ROUNDS = 15
PLAIN, SHADED = 28.0, 16.0
"""Pictures a second that shall be taken: by a head light, and with textures and a light that casts shadows."""


def run() -> list[Row]:
    """Measure."""
    with one_core():
        cell = ray_cell()
        client = pybullet.connect(pybullet.DIRECT)
        bullet, vtk = BulletCamera(cell, client), VtkCamera(cell)
        plain = pictures(cell, (ImageKind.COLOR, ImageKind.DEPTH, ImageKind.SEGMENTATION, ImageKind.NORMALS))
        measured = pictures(cell, (ImageKind.DEPTH, ImageKind.SEGMENTATION, ImageKind.NORMALS))
        shaded = pictures(cell, (ImageKind.COLOR, ImageKind.DEPTH, ImageKind.SEGMENTATION), texture=checker(), lit=True)
        all_four = "colour by a head light, depth, segmentation, normals"
        best = "textures, a light with shadows, depth, segmentation"
        rows = [
            *compared(all_four, plain, "PyBullet", lambda _: bullet.take(False), PLAIN),
            *compared(best, shaded, "PyBullet, with shadows", lambda _: bullet.take(True), SHADED),
            *compared(all_four, plain, "VTK", lambda _: vtk.take()),
            *compared("depth, segmentation, normals", measured, "VTK", lambda _: vtk.take()),
        ]
        pybullet.disconnect(client)
    return rows


def compared(what: str, ours: Scan, name: str, peer: Scan, wanted: float | None = None) -> list[Row]:
    """Measure both in turn and return rows of their medians, and of the pictures a second that are `wanted`."""
    mine, others = in_turn(ours, peer, ROUNDS)
    rows = [row(what, 1e3 * mine, 1e3 * others, name, "ms", None)]
    if wanted:
        rows.append(
            row(what, 1e3 * mine, 1e3 / wanted, f"{wanted:g} a second", "ms", 1.0, f"{1.0 / mine:.0f} a second")
        )
    return rows


def pictures(cell: RayCell, kinds: tuple[ImageKind, ...], texture: bytes | None = None, lit: bool = False) -> Scan:
    """Return what takes pictures of the scene with the kernel's own reader, the arm elsewhere each time."""
    focal = HEIGHT / 2.0 / np.tan(FIELD / 2.0)
    middle = Intrinsics(focal, focal, (WIDTH - 1) / 2.0, (HEIGHT - 1) / 2.0)
    settings = CameraSensor(WIDTH, HEIGHT, intrinsics=middle, images=kinds, near_meters=0.05, far_meters=30.0)
    world = ray_world(cell, settings, Kind.CAMERA_SENSOR, looking(), texture)
    if lit:
        light = NodeSpec("light", Kind.LIGHT, parent_t_node=above(), data=Light(LightKind.POINT, intensity=4.0))
        world.do(CreateNodes((light,)))
    worlds = snapshots(world, cell, ROUNDS + WARM)
    node = world.snapshot.structure.node("sensor")
    reader = CameraReader(node, ShapeLibrary(world.meshes), AppearanceLibrary(world.meshes))
    return lambda number: reader.read(Moment(worlds[number], (), number + 1, np.random.default_rng(number)))


def looking() -> np.ndarray:
    """Return the pose of a camera at SENSOR that looks at TARGET: z forward, y down."""
    forward = (TARGET - SENSOR) / np.linalg.norm(TARGET - SENSOR)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = SENSOR
    return pose


def above() -> np.ndarray:
    """Return the place of the light."""
    pose = np.eye(4)
    pose[:3, 3] = (1.0, 1.0, 2.8)
    return pose


def checker() -> bytes:
    """Return a texture of squares as PNG."""
    squares = (np.indices((256, 256)) // 32).sum(axis=0) % 2
    pixels = np.where(squares[..., None] == 1, (220, 170, 40), (40, 60, 90)).astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    return file.getvalue()


@contextlib.contextmanager
def one_core() -> Iterator[None]:
    """Keep this thread, and those that it starts, on one core."""
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)
