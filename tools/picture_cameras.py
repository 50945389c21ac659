"""Writes the pictures of docs/cameras.md: what cameras of a running kernel see of the demo's cell.

Usage: python tools/picture_cameras.py docs/pictures
"""

from __future__ import annotations

import colorsys
from pathlib import Path

import click
import numpy as np
import virtualrobot
from numpy.typing import ArrayLike, NDArray
from PIL import Image
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.sensors.cameras import CameraReading, CameraSettings
from virtualrobot_apps.demos.palletizing import cell

GAP = 8
"""White between pictures, in pixels."""

Pixels = NDArray[np.uint8]


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
def main(folder: Path) -> None:
    """Write camera-kinds.png, camera-lights.png and camera-lenses.png to FOLDER."""
    folder.mkdir(parents=True, exist_ok=True)
    kernel = KernelProcess("--stepped", str(cell.SCENE), headless=True)
    with kernel, virtualrobot.connect(kernel.address) as client:
        write(folder / "camera-kinds.png", kinds(client))
        write(folder / "camera-lenses.png", lenses(client))
        write(folder / "camera-lights.png", lights(client))


def look(client: virtualrobot.Client, settings: CameraSettings, eye: ArrayLike, target: ArrayLike) -> CameraReading:
    """Return what a camera at `eye` sees that looks at `target`."""
    client.scene.add_camera("eye", settings, pose=virtualrobot.looking_at(eye, target))
    reading = client.sensors["eye"].read(images=["color", "depth", "segmentation", "normals"]).camera
    client.scene.remove("eye")
    return reading


def kinds(client: virtualrobot.Client) -> list[list[Pixels]]:
    """Return colour, depth, segmentation and normals of one picture."""
    seen = look(client, virtualrobot.camera(480, 340), (3.0, -2.2, 1.9), (0.3, 0.3, 0.6))
    assert seen.color is not None and seen.depth is not None
    assert seen.segmentation is not None and seen.normals is not None
    near, far = seen.depth.min(), np.percentile(seen.depth[np.isfinite(seen.depth)], 98)
    grey = np.clip(255.0 * (far - seen.depth) / (far - near), 0.0, 255.0)
    named = np.where((seen.segmentation >= 0)[..., None], hues(seen.element_names)[seen.segmentation], 255)
    facing = np.where(np.isfinite(seen.depth)[..., None], 127.5 - 127.5 * seen.normals, 255.0)
    depth = np.repeat(grey[..., None], 3, axis=2)
    return [[seen.color, depth.astype(np.uint8)], [named.astype(np.uint8), facing.astype(np.uint8)]]


def lenses(client: virtualrobot.Client) -> list[list[Pixels]]:
    """Return what a fisheye over the cell and a spherical camera in it see."""
    fisheye = virtualrobot.camera(340, 340, projection="fisheye", horizontal_field=np.pi)
    spherical = virtualrobot.camera(680, 340, projection="spherical")
    above = look(client, fisheye, (0.2, 0.1, 1.7), (0.2, 0.2, 0.0)).color
    around = look(client, spherical, (0.1, -0.5, 1.1), (0.1, 1.0, 1.1)).color
    assert above is not None and around is not None
    row, column = np.indices((340, 340)) - 169.5
    above = np.where((np.hypot(row, column) < 170)[..., None], above, 255).astype(np.uint8)
    return [[above, around]]


def lights(client: virtualrobot.Client) -> list[list[Pixels]]:
    """Return the cell by daylight and by night, both with shadows."""
    sun = virtualrobot.light("directional", intensity=0.9, color="#fff4e0")
    client.scene.add_light("sun", sun, pose=virtualrobot.looking_at((1.5, -2.0, 4.0), (0.0, 0.0, 0.0)))
    camera, eye, target = virtualrobot.camera(480, 340), (3.0, -2.2, 1.9), (0.3, 0.3, 0.6)
    day = look(client, camera, eye, target).color
    client.scene.remove("sun")
    spot = virtualrobot.light("spot", intensity=6.0, cone_angle=0.5)
    client.scene.add_light("spot", spot, pose=virtualrobot.looking_at((0.2, -1.6, 2.8), (0.5, 0.6, 0.4)))
    lamp = virtualrobot.light(color="#ff9a50", intensity=0.7)
    client.scene.add_light("lamp", lamp, pose=virtualrobot.pose(-1.6, -0.9, 1.4))
    night = look(client, camera, eye, target).color
    assert day is not None and night is not None
    return [[day, night]]


def write(path: Path, rows: list[list[Pixels]]) -> None:
    """Write pictures in rows as one PNG."""
    beside = [_joined(row, 1) for row in rows]
    Image.fromarray(_joined(beside, 0)).save(path, optimize=True)
    click.echo(f"{path}: {path.stat().st_size // 1024} kB")


def _joined(pictures: list[Pixels], axis: int) -> Pixels:
    shape = list(pictures[0].shape)
    shape[axis] = GAP
    parts = [part for picture in pictures for part in (np.full(shape, 255, np.uint8), picture)]
    return np.concatenate(parts[1:], axis=axis)


def hues(names: tuple[str, ...]) -> Pixels:
    """Return a colour for each node, (n, 3): those of one robot have one hue."""
    whole = list(dict.fromkeys(name.partition(".")[0] for name in names))
    # Steps of the golden ratio are apart however many there are.
    colors = [
        colorsys.hsv_to_rgb(0.618 * whole.index(name.partition(".")[0]) % 1.0, 0.55, 0.7 + 0.06 * (number % 6))
        for number, name in enumerate(names)
    ]
    return np.round(255.0 * np.array(colors)).astype(np.uint8)


if __name__ == "__main__":
    main()
