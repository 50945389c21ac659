"""Furnished floors by seed: a corridor with rooms on both sides, doors, and furniture; and what is true of them."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import virtualrobot
from virtualrobot import Client

from virtualrobot_apps.seeing.navigation.grid import MOST, Grid
from virtualrobot_apps.seeing.navigation.poses import Floats

NODE = "building"
"""Node below which walls and furniture hang."""
WIDE, DEEP = 12.0, 9.0
"""Size of a floor, inside (m)."""
CORRIDOR = (3.75, 5.25)
"""Places of the corridor's walls along y (m)."""
DOOR = (0.9, 1.1)
"""Narrowest and widest door (m)."""
WALL = 0.1
START = (0.7, 4.5, 0.0)
"""Pose at which a vehicle begins."""


@dataclass(frozen=True, slots=True)
class Box:
    """Box on the floor: middle (m), size (m) and height (m), parallel to the walls."""

    x: float
    y: float
    wide: float
    deep: float
    high: float
    color: str

    def apart(self, places: Floats) -> Floats:
        """Return how far places (..., 2) are from it (m); 0 inside."""
        dx = np.maximum(np.abs(places[..., 0] - self.x) - 0.5 * self.wide, 0.0)
        dy = np.maximum(np.abs(places[..., 1] - self.y) - 0.5 * self.deep, 0.0)
        return np.hypot(dx, dy)


def floor(seed: int) -> list[Box]:
    """Return walls and furniture of the floor of a seed."""
    rng = np.random.default_rng(seed)
    boxes = [
        Box(0.5 * WIDE, -0.5 * WALL, WIDE + 2 * WALL, WALL, 1.2, "#e9e5dc"),
        Box(0.5 * WIDE, DEEP + 0.5 * WALL, WIDE + 2 * WALL, WALL, 1.2, "#e9e5dc"),
        Box(-0.5 * WALL, 0.5 * DEEP, WALL, DEEP, 1.2, "#e9e5dc"),
        Box(WIDE + 0.5 * WALL, 0.5 * DEEP, WALL, DEEP, 1.2, "#e9e5dc"),
    ]
    doors: list[tuple[float, float]] = []
    for low, high, wall_y in ((0.0, CORRIDOR[0], CORRIDOR[0]), (CORRIDOR[1], DEEP, CORRIDOR[1])):
        ends = [0.0, *(WIDE * (at + rng.uniform(-0.06, 0.06)) for at in (1 / 3, 2 / 3)), WIDE]
        for left, right in itertools.pairwise(ends):
            gap = rng.uniform(*DOOR)
            at = rng.uniform(left + 0.5 + 0.5 * gap, right - 0.5 - 0.5 * gap)
            doors.append((at, wall_y))
            for first, last in ((left, at - 0.5 * gap), (at + 0.5 * gap, right)):
                boxes.append(Box(0.5 * (first + last), wall_y, last - first, WALL, 1.2, "#e9e5dc"))
        between = int(rng.integers(1, 3))  # of the two walls between rooms one has a door: so there are loops
        for number in (1, 2):
            if number != between:
                boxes.append(Box(ends[number], 0.5 * (low + high), WALL, high - low, 1.2, "#e9e5dc"))
                continue
            gap = rng.uniform(*DOOR)
            at = rng.uniform(low + 0.9, high - 0.9)
            doors.append((ends[number], at))
            for first, last in ((low, at - 0.5 * gap), (at + 0.5 * gap, high)):
                boxes.append(Box(ends[number], 0.5 * (first + last), WALL, last - first, 1.2, "#e9e5dc"))
    walls = list(boxes)
    furniture: list[Box] = []
    keep = np.array([*doors, START[:2], (START[0] + 0.5, START[1])])
    colors = ("#a9784a", "#6c7f94", "#8a6f9c", "#b5652f")
    for _ in range(400):
        if len(furniture) == 16:
            break
        box = Box(
            rng.uniform(0.3, WIDE - 0.3),
            rng.uniform(0.3, DEEP - 0.3),
            rng.uniform(0.3, 1.1),
            rng.uniform(0.3, 0.8),
            rng.uniform(0.45, 1.1),
            colors[int(rng.integers(len(colors)))],
        )
        if (box.apart(keep) < 0.9).any() or CORRIDOR[0] - 0.7 < box.y < CORRIDOR[1] + 0.7:
            continue
        edge = _outline(box)
        # What stands against a wall or another piece does so without a gap that only looks like a passage.
        gaps = [other.apart(edge).min() for other in (*walls, *furniture)]
        if all(gap > 0.8 for gap in gaps):
            furniture.append(box)
    return boxes + furniture


def _outline(box: Box) -> Floats:
    u = np.linspace(-0.5, 0.5, 9)
    sides = [np.column_stack([u, np.full(9, side)]) for side in (-0.5, 0.5)]
    square = np.vstack([*sides, *(side[:, ::-1] for side in sides)])
    return np.array([box.x, box.y]) + square * [box.wide, box.deep]


def build(client: Client, boxes: list[Box], size: tuple[float, float] = (WIDE, DEEP)) -> None:
    """Replace the world by a floor of a size (m), which begins at 0, with these boxes on it."""
    wide, deep = size
    client.scene.clear()
    ground = virtualrobot.box(wide + 2.0, deep + 2.0, 0.1, color="#b8bcc0")
    client.scene.add_object("floor", ground, pose=virtualrobot.pose(0.5 * wide, 0.5 * deep, -0.05))
    client.scene.add_object(NODE, ())
    with client.scene.batch() as batch:
        for number, box in enumerate(boxes):
            figure = virtualrobot.box(box.wide, box.deep, box.high, color=box.color)
            batch.add_object(f"box_{number}", figure, parent=NODE, pose=virtualrobot.pose(box.x, box.y, 0.5 * box.high))
    client.view.set_camera(position=(0.5 * wide, -0.5 * deep, 0.9 * wide), target=(0.5 * wide, 0.48 * deep, 0.0))


def true_grid(boxes: list[Box], resolution: float = 0.025, size: tuple[float, float] = (WIDE, DEEP)) -> Grid:
    """Return the true map of a floor of a size (m), as a judge or a plan of the building has it."""
    wide, deep = size
    margin = 4.0 * resolution  # its outer walls' faces are in it
    shape = (round((deep + 2.0 * margin) / resolution), round((wide + 2.0 * margin) / resolution))
    grid = Grid(resolution, np.full(2, -margin), np.zeros(shape))
    places = grid.middles(*np.indices(shape))
    inside = (places > 0.0).all(axis=2) & (places < [wide, deep]).all(axis=2)
    grid.log_odds[inside] = -MOST
    for box in boxes:
        grid.log_odds[box.apart(places) <= 0.0] = MOST
    return grid


def places(boxes: list[Box], count: int, seed: int, clearance: float) -> Floats:
    """Return places (count, 2) by seed that are so far from everything (m), and at least 1.5 m from the one before."""
    rng = np.random.default_rng([seed, 1])
    found: list[Floats] = [np.array(START[:2])]
    for _ in range(10_000):
        place = rng.uniform((0.0, 0.0), (WIDE, DEEP))
        if min(float(box.apart(place)) for box in boxes) > clearance and np.linalg.norm(place - found[-1]) > 1.5:
            found.append(place)
        if len(found) > count:
            break
    return np.array(found[1:])
