"""What programs that see look at: a platform with a yellow valve wheel, and a floor with a black line."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import virtualrobot

WHEEL_RADIUS, WHEEL_TUBE = 0.20, 0.018
"""Of the valve's wheel, meters: to the middle of the rim, and of the rim's tube."""


def wheel(path: Path, around: int = 96, tube: int = 16) -> Path:
    """Write a hand wheel about z as an OBJ file: a rim and three spokes."""
    angle, turn = np.meshgrid(
        np.linspace(0, 2 * np.pi, around, endpoint=False),
        np.linspace(0, 2 * np.pi, tube, endpoint=False),
        indexing="ij",
    )
    radius = WHEEL_RADIUS + WHEEL_TUBE * np.cos(turn)
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), WHEEL_TUBE * np.sin(turn)], axis=-1)
    vertices: list[np.ndarray] = [rim.reshape(-1, 3)]
    index = np.arange(around * tube).reshape(around, tube)
    a, b = index, np.roll(index, -1, 0)
    c, d = np.roll(b, -1, 1), np.roll(a, -1, 1)
    faces = [np.stack([a, b, c, d], axis=-1).reshape(-1, 4)]
    for spoke in range(3):
        along = np.array([np.cos(2 * np.pi * spoke / 3), np.sin(2 * np.pi * spoke / 3), 0.0])
        across, up = 0.012 * np.cross([0, 0, 1], along), np.array([0, 0, 0.008])
        ends = [place + side * across + lift * up for place in (0 * along, WHEEL_RADIUS * along)
                for side, lift in ((-1, -1), (1, -1), (1, 1), (-1, 1))]  # fmt: skip
        first = sum(len(one) for one in vertices)
        vertices.append(np.array(ends))
        sides = [[i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4] for i in range(4)]
        faces.append(np.array(sides) + first)
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in np.concatenate(vertices)]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in np.concatenate(faces)]
    path.write_text("\n".join(lines) + "\n")
    return path


def build_platform(client: virtualrobot.Client, folder: Path, world_t_wheel: np.ndarray) -> None:
    """Make a wall with pipes, tanks and a yellow wheel whose axis is z of `world_t_wheel`, under two lamps."""
    scene = client.scene
    scene.add_object("deck", virtualrobot.box(8, 8, 0.1, color="#6b7d6a"), pose=virtualrobot.pose(z=-0.05))
    scene.add_object("wall", virtualrobot.box(0.1, 8, 4, color="#9aa3ad"), pose=virtualrobot.pose(2.0, 0, 2.0))
    lying = virtualrobot.pose(roll=np.pi / 2)
    for number, (height, color) in enumerate([(0.5, "#7a8790"), (1.4, "red"), (2.0, "#c9ced3"), (2.5, "blue")]):
        pipe = virtualrobot.cylinder(0.09, 7.0, color=color)
        scene.add_object(f"pipe-{number}", pipe, pose=virtualrobot.pose(1.7, 0, height) @ lying)
    tank = virtualrobot.cylinder(0.5, 1.6, color="#d8d8cc")
    scene.add_object("tank", tank, pose=virtualrobot.pose(1.1, -1.7, 0.8))
    scene.add_part("crate", virtualrobot.box(0.6, 0.5, 0.5, color="orange"), pose=virtualrobot.pose(0.9, 1.5, 0.25))
    figure = client.assets.mesh(str(wheel(folder / "wheel.obj")), color=(0.95, 0.82, 0.05))
    scene.add_object("valve", figure, pose=world_t_wheel)
    stem = virtualrobot.cylinder(0.02, 0.3, color="#555555", pose=virtualrobot.pose(z=0.16))
    scene.add_object("stem", stem, pose=world_t_wheel)
    scene.add_light("lamp", virtualrobot.light(intensity=5.0), pose=virtualrobot.pose(-1.0, 1.5, 3.2))
    scene.add_light("fill", virtualrobot.light(intensity=2.0, shadows=False), pose=virtualrobot.pose(-1.5, -2.5, 2.0))


def line_at(x: np.ndarray) -> np.ndarray:
    """Return y of the line's middle at x, both in meters."""
    return 0.35 * np.sin(1.6 * x) + 0.1 * x


def build_line_floor(client: virtualrobot.Client, folder: Path) -> None:
    """Make a bright floor of 4 m with a black line of 5 cm on it, as a mesh with a picture, and a wall."""
    pixels, meters = 1024, 4.0
    picture = np.full((pixels, pixels, 3), (214, 220, 224), np.uint8)
    x = np.linspace(-2.0, 2.0, 400)
    # The upper left pixel is at x = -2, y = 2.
    places = np.stack([(x + 2.0) / meters, (2.0 - line_at(x)) / meters], axis=1) * pixels
    cv2.polylines(picture, [np.round(places * 16).astype(np.int32)], False, (12, 12, 12), 13, cv2.LINE_AA, 4)
    cv2.imwrite(str(folder / "floor.png"), picture)
    (folder / "floor.mtl").write_text("newmtl floor\nKd 1 1 1\nmap_Kd floor.png\n")
    (folder / "floor.obj").write_text(
        "mtllib floor.mtl\nusemtl floor\nv -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
    )
    client.scene.add_object("floor", client.assets.mesh(str(folder / "floor.obj")))
    client.scene.add_object(
        "wall", virtualrobot.box(0.05, 4, 0.4, color="#b0544a"), pose=virtualrobot.pose(2.0, 0, 0.2)
    )
    client.scene.add_light(
        "sky", virtualrobot.light("directional", intensity=0.75), pose=virtualrobot.looking_at([0, 0, 3], [0.6, 0.4, 0])
    )
