"""Rooms of a patrol: the one that is watched with what changes in it, and another one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import virtualrobot
from virtualrobot import Client

from virtualrobot_apps.seeing.navigation import floors
from virtualrobot_apps.seeing.navigation.floors import Box
from virtualrobot_apps.seeing.navigation.poses import Floats, planar

ROBOT, SCANNER = "ugv", "watcher"
SIZE = (7.0, 5.0)
"""Of the room, inside (m)."""
START = (0.8, 0.8, 0.0)
STOPS = ((1.0, 2.5, 0.0), (3.5, 0.7, 1.3), (6.2, 2.6, 2.9))
"""Poses from which the vehicle looks: x, y (m) and heading (rad)."""
DEVIATION = 0.005
"""Of a distance that the scanner tells (m, 1 sigma)."""
FIELD = np.radians(120.0), np.radians(50.0)
"""Horizontal and vertical field of the scanner."""
NEAREST, FURTHEST = 1.6, 4.0
"""Distances (m) of a change from the stop that it is seen from."""
CRATE, STOOL = (0.3, 0.3, 0.3), (0.3, 0.3, 0.5)
"""Sizes of what comes and of what goes (m)."""
_WALL, _HIGH = 0.1, 2.0


@dataclass(frozen=True, slots=True)
class Plot:
    """Changes between two rounds: a crate that comes, and a stool that goes."""

    crate: Box
    stool: Box


def walls(wide: float, deep: float) -> list[Box]:
    """Return the walls of a room of a size (m) whose corner is at 0."""
    along, across = wide + 2.0 * _WALL, deep
    return [
        *(Box(0.5 * wide, y, along, _WALL, _HIGH, "#e9e5dc") for y in (-0.5 * _WALL, deep + 0.5 * _WALL)),
        *(Box(x, 0.5 * deep, _WALL, across, _HIGH, "#e9e5dc") for x in (-0.5 * _WALL, wide + 0.5 * _WALL)),
    ]


ROOM = [
    *walls(*SIZE),
    Box(5.6, 0.5, 1.4, 0.8, 0.8, "#a9784a"),
    Box(3.2, 4.6, 1.4, 0.7, 1.6, "#6c7f94"),
    Box(0.4, 4.2, 0.6, 0.9, 1.1, "#8a6f9c"),
]
"""Walls and furniture, as the plan of the building has them."""
OTHER = [*walls(4.5, 7.5), Box(2.4, 4.0, 0.6, 1.0, 1.2, "#b5652f"), Box(3.9, 1.5, 0.8, 1.2, 0.9, "#6c7f94")]
"""Another room."""


def plot_of(seed: int) -> Plot:
    """Return what changes, by seed: in sight of a stop, and apart from furniture, stops and each other."""
    rng = np.random.default_rng(seed)
    found: list[Box] = []
    for wide, deep, high in (CRATE, STOOL):
        while True:
            place = rng.uniform((0.4, 0.4), np.array(SIZE) - 0.4)
            clear = min(float(one.apart(place)) for one in (*ROOM, *found)) > 0.45
            clear = clear and min(np.linalg.norm(place - stop[:2]) for stop in (START, *STOPS)) > 0.7
            if clear and any(in_sight(np.array(stop), place) for stop in STOPS):
                found.append(Box(float(place[0]), float(place[1]), wide, deep, high, "#c0392b"))
                break
    return Plot(*found)


def in_sight(stop: Floats, place: Floats) -> bool:
    """Return whether a place (2,) is well within the field of the scanner at a stop (3,), with nothing between."""
    away = place - stop[:2]
    angle = np.arctan2(away[1], away[0]) - stop[2]
    ahead = abs((angle + np.pi) % (2.0 * np.pi) - np.pi) < 0.4 * FIELD[0]
    between = stop[:2] + np.linspace(0.0, 1.0, 40)[:, None] * away
    free = all(float(one.apart(between).min()) > 0.25 for one in ROOM)
    return bool(ahead and NEAREST < np.linalg.norm(away) < FURTHEST and free)


def build(client: Client, boxes: list[Box], size: tuple[float, float] = SIZE) -> Floats:
    """Replace the world by a room with a vehicle in it; return the scanner's pose (4, 4) in the vehicle's frame."""
    floors.build(client, boxes, size)
    client.load_robot(f"model://{ROBOT}", name=ROBOT, base="planar", pose=pose_of(np.array(START)))
    pattern = virtualrobot.raster(200, 84, *FIELD)
    looks = virtualrobot.range_sensor(
        pattern=pattern, sensor_model="laser", sensor_model_settings={"deviation_meters": DEVIATION}, max_range=12.0
    )
    base = f"{ROBOT}.base"
    client.scene.add_range_sensor(SCANNER, looks, parent=base, pose=virtualrobot.pose(z=1.2, pitch=0.2))
    return np.linalg.inv(pose_of(planar(client.scene.pose(base)))) @ client.scene.pose(SCANNER)


def add(client: Client, name: str, box: Box) -> None:
    """Put a box into the room."""
    figure = virtualrobot.box(box.wide, box.deep, box.high, color=box.color)
    client.scene.add_object(name, figure, pose=virtualrobot.pose(box.x, box.y, 0.5 * box.high))


def pose_of(pose: Floats) -> Floats:
    """Return the pose (4, 4) of one in the plane (3,)."""
    return virtualrobot.pose(float(pose[0]), float(pose[1]), yaw=float(pose[2]))
