"""A furnished room for vehicles: walls, a table with chairs, sofa, shelf, cupboard and plant. All sizes are ours."""

from __future__ import annotations

import numpy as np
import virtualrobot
from virtualrobot import Client, Figure

Place = tuple[float, float, float]

FURNITURE = "furniture"
"""Node below which all of it hangs."""
ROUTE = ((4.8, 0.0), (4.8, 3.3), (0.0, 3.3), (0.0, 0.0))
"""Waypoints (m) around the table, from the origin on."""

LOW, HIGH, TALL, WALL = (-1.0, -0.9), (6.0, 4.9), 1.2, 0.1
"""Corners of the room, inside (m), height of its walls, which are cut low to be looked over, and their thickness."""
DOOR = 0.9
"""Width of the opening in the wall where y is least (m)."""
WOOD, CLOTH, WHITE, GREEN, CLAY = "#a9784a", "#6c7f94", "#e9e5dc", "#4f8a4b", "#b5652f"


def furnish(client: Client) -> None:
    """Put walls and furniture onto a floor whose top is at the height 0."""
    scene = client.scene
    scene.add_object(FURNITURE, ())
    for name, figures, (x, y, yaw) in pieces():
        scene.add_object(name, figures, parent=FURNITURE, pose=virtualrobot.pose(x, y, yaw=yaw))
    client.view.set_camera(position=(2.5, -3.4, 6.2), target=(2.5, 1.7, 0.0))


def pieces() -> list[tuple[str, list[Figure], Place]]:
    """Return the pieces: names, figures about a point of the floor, and where that is: x, y (m) and heading (rad)."""
    middle = (2.4, 1.65)
    chairs = [((-0.35, -0.55), 0.0), ((0.35, -0.55), 0.0), ((-0.35, 0.55), np.pi), ((0.35, 0.55), np.pi)]
    return [
        ("walls", walls(), (0.0, 0.0, 0.0)),
        ("table", [block((1.4, 0.8, 0.04), (0.0, 0.0, 0.72), WOOD), *legs(1.3, 0.7, 0.7)], (*middle, 0.0)),
        *((f"chair_{at + 1}", chair(), (middle[0] + x, middle[1] + y, yaw)) for at, ((x, y), yaw) in enumerate(chairs)),
        ("sofa", sofa(), (2.4, 4.45, np.pi)),
        ("shelf", [block((0.3, 1.6, 1.1), (0.0, 0.0, 0.55), WOOD)], (-0.84, 1.65, 0.0)),
        ("cupboard", [block((0.5, 1.2, 0.9), (0.0, 0.0, 0.45), WHITE)], (5.74, 1.65, 0.0)),
        ("plant", plant(), (5.65, 4.5, 0.0)),
    ]


def block(size: Place, middle: Place, color: str) -> Figure:
    """Return a box with its middle at a place."""
    return virtualrobot.box(*size, color=color, pose=virtualrobot.pose(*middle))


def walls() -> list[Figure]:
    """Return the walls of the room, one of them with a door's opening."""
    (left, near), (right, far) = LOW, HIGH
    wide, deep, half = right - left, far - near, 0.5 * WALL
    z, x, y = 0.5 * TALL, 0.5 * (left + right), 0.5 * (near + far)
    beside = 0.5 * (wide - DOOR)
    return [
        block((WALL, deep + 2.0 * WALL, TALL), (left - half, y, z), WHITE),
        block((WALL, deep + 2.0 * WALL, TALL), (right + half, y, z), WHITE),
        block((wide, WALL, TALL), (x, far + half, z), WHITE),
        block((beside, WALL, TALL), (left + 0.5 * beside, near - half, z), WHITE),
        block((beside, WALL, TALL), (right - 0.5 * beside, near - half, z), WHITE),
    ]


def legs(length: float, width: float, height: float) -> list[Figure]:
    """Return four legs at the corners of a rectangle."""
    corners = [(x, y) for x in (-0.5 * length, 0.5 * length) for y in (-0.5 * width, 0.5 * width)]
    return [block((0.05, 0.05, height), (x, y, 0.5 * height), WOOD) for x, y in corners]


def chair() -> list[Figure]:
    """Return a chair that looks along y."""
    back = block((0.4, 0.04, 0.45), (0.0, -0.19, 0.65), WOOD)
    return [block((0.42, 0.42, 0.04), (0.0, 0.0, 0.44), CLOTH), back, *legs(0.36, 0.36, 0.42)]


def sofa() -> list[Figure]:
    """Return a sofa that looks along y."""
    arms = [block((0.15, 0.8, 0.6), (x, 0.0, 0.3), CLOTH) for x in (-0.9, 0.9)]
    return [
        block((1.9, 0.8, 0.4), (0.0, 0.0, 0.2), CLOTH),
        block((1.9, 0.2, 0.8), (0.0, -0.3, 0.4), CLOTH),
        *arms,
    ]


def plant() -> list[Figure]:
    """Return a plant in its pot."""
    return [
        virtualrobot.cylinder(0.16, 0.3, color=CLAY, pose=virtualrobot.pose(z=0.15)),
        virtualrobot.sphere(0.28, color=GREEN, pose=virtualrobot.pose(z=0.6)),
    ]
