"""Grasps of boxes in a bin by two fingers from above, of which the freest comes first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_apps.demos.bins.cell import EDGE, INSIDE

Floats = NDArray[np.float64]

LEVEL = 0.35
"""Sine of the slope up to which an edge counts as level, so that fingers close along it."""
OPEN = 0.056
"""Width (m) to which fingers open."""
FINGER_AT, FINGER_THICK, FINGER_WIDE = 0.5 * OPEN, 0.01, 0.025
"""Of an open finger: its inner face (m) from the middle, its thickness along the way on which it closes, its width."""
LIFT = 0.005
"""Height (m) of the tool over the middle of a box, so that fingers, 20 mm longer, stay off the bin."""


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """Grasp of a part: world_t_tcp (4, 4), and the room (m) that its fingers have; below 0 they hit something."""

    part: str
    world_t_tcp: Floats
    room: float


def grasps(world_t_part: Mapping[str, Floats], bin_at: tuple[float, float]) -> list[Grasp]:
    """Return the grasps of boxes of EDGE in a bin: those with room first, and of these the highest."""
    found = [one for name in world_t_part for one in _of(name, world_t_part, bin_at)]
    return sorted(found, key=lambda one: (one.room < 0.0, -round(one.world_t_tcp[2, 3], 2), -one.room))


def _of(name: str, world_t_part: Mapping[str, Floats], bin_at: tuple[float, float]) -> Iterator[Grasp]:
    """Yield a grasp along each edge of a box that is level; the tool looks straight down."""
    pose = world_t_part[name]
    others = [other[:3, 3] for key, other in world_t_part.items() if key != name]
    for axis in pose[:3, :3].T:
        if abs(axis[2]) > LEVEL:
            continue
        along = np.array([axis[0], axis[1], 0.0]) / np.hypot(axis[0], axis[1])
        # Of both ways round, the one that turns the wrist less.
        along *= 1.0 if along[1] >= 0.0 else -1.0
        tcp = np.eye(4)
        tcp[:3, 1], tcp[:3, 2] = along, (0.0, 0.0, -1.0)
        tcp[:3, 0] = np.cross(tcp[:3, 1], tcp[:3, 2])
        tcp[:3, 3] = pose[:3, 3] + (0.0, 0.0, LIFT)
        yield Grasp(name, tcp, min(_room(tcp, others), _room_to_walls(tcp, bin_at)))


def _room(tcp: Floats, others: list[Floats]) -> float:
    """Return the room (m) of open fingers among other boxes, as balls of half their face's diagonal."""
    least, ball = np.inf, EDGE / np.sqrt(2.0)
    for other in others:
        across, along, down = tcp[:3, :3].T @ (other - tcp[:3, 3])
        if down > EDGE:
            continue
        beside = max(abs(across) - 0.5 * FINGER_WIDE, 0.0)
        before = max(FINGER_AT - abs(along), abs(along) - FINGER_AT - FINGER_THICK, 0.0)
        least = min(least, float(np.hypot(beside, before)) - ball)
    return least


def _room_to_walls(tcp: Floats, bin_at: tuple[float, float]) -> float:
    """Return the room (m) of open fingers to the walls of a bin."""
    reach = np.abs(tcp[:2, 1]) * (FINGER_AT + FINGER_THICK) + np.abs(tcp[:2, 0]) * 0.5 * FINGER_WIDE
    return float((0.5 * INSIDE - np.abs(tcp[:2, 3] - bin_at) - reach).min())
