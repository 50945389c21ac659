"""Displays: walls, what of a picture each eye has, and the observer that stands before them.

Frames: the room's, in which walls, heads and trackers are, z up from the floor; the head's, between the eyes, x ahead,
y to the left, z up. The observer's pose says where the room is in the world: whoever flies moves it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from virtualrobot.geometry import Matrix, pose

from virtualrobot_apps.walls.frustum import Frustum, Wall, frustum

Floats = NDArray[np.float64]

ONE_CORNER, NEAR_CORNER = 1e-4, 0.05
"""Distance (m) up to which two corners are one, and that up to which they are likely meant to be."""

EYES = {"left": 0.5, "middle": 0.0, "right": -0.5}
"""Place of each eye along y of the head, in distances of eyes."""

STEREO: dict[str, tuple[tuple[str, tuple[float, float, float, float]], ...]] = {
    "none": (("middle", (0.0, 0.0, 1.0, 1.0)),),
    "left": (("left", (0.0, 0.0, 1.0, 1.0)),),
    "right": (("right", (0.0, 0.0, 1.0, 1.0)),),
    "side_by_side": (("left", (0.0, 0.0, 0.5, 1.0)), ("right", (0.5, 0.0, 0.5, 1.0))),
    "top_bottom": (("left", (0.0, 0.0, 1.0, 0.5)), ("right", (0.0, 0.5, 1.0, 0.5))),
}
"""Eyes and the part of the picture that each has, x, y, width, height from the upper left corner, by kind of stereo."""


@dataclass(frozen=True, slots=True, eq=False)
class Output:
    """Wall with what shows it: pixels in all, and a kind of stereo of `STEREO`."""

    wall: Wall
    pixels: tuple[int, int]
    stereo: str


@dataclass(frozen=True, slots=True, eq=False)
class Tracker:
    """Source of heads: `room_t_tracker` (4, 4), with the axis that is up in it, and `body_t_head` (4, 4).

    The tracked body is whatever the tracker tells of; the head's frame is between the eyes.
    """

    room_t_tracker: Matrix
    body_t_head: Matrix


@dataclass(frozen=True, slots=True, eq=False)
class Display:
    """Display of a world.

    Attributes:
        near: distance from an eye before which nothing is seen, m.
        far: distance behind which nothing is, m.
        outputs: walls.
        world_t_room: (4, 4) where the room stands in the world.
        height: of the eyes over the floor while no head is tracked, m.
        speed: by which the room is flown, m/s, and turned, rad/s.
        eyes: distance of the eyes, m.
        tracker: where heads come from.
    """

    near: float
    far: float
    outputs: tuple[Output, ...]
    world_t_room: Matrix
    height: float
    speed: float
    eyes: float
    tracker: Tracker

    @property
    def standing(self) -> Matrix:
        """`room_t_head` (4, 4) while no head is tracked: over the room's origin, looking along x."""
        return pose(z=self.height)


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Picture of one eye on a wall.

    Attributes:
        wall: its name.
        eye: `left`, `middle` or `right`.
        viewport: x, y, width, height in the wall's pixels, from the upper left corner.
        frustum: what the eye sees through the wall, in the room's frame.
    """

    wall: str
    eye: str
    viewport: tuple[int, int, int, int]
    frustum: Frustum


def eye_place(room_t_head: Matrix, eye: str, apart: float) -> Floats:
    """Return where an eye (3,) is in the room, whose distance from the other one is `apart` (m)."""
    return room_t_head[:3, 3] + room_t_head[:3, 1] * (EYES[eye] * apart)


def views(display: Display, room_t_head: Matrix) -> list[View]:
    """Return the pictures of all walls for a head at a pose (4, 4).

    Raises:
        InvalidArgumentError: for an eye on a wall or behind it.
    """
    found = list[View]()
    for output in display.outputs:
        width, height = output.pixels
        for eye, (x, y, across, down) in STEREO[output.stereo]:
            seen = frustum(output.wall, eye_place(room_t_head, eye, display.eyes), display.near, display.far)
            viewport = (round(x * width), round(y * height), round(across * width), round(down * height))
            found.append(View(output.wall.name, eye, viewport, seen))
    return found


def gaps(display: Display) -> list[str]:
    """Return which walls have corners that are almost one, in words: there their pictures don't meet to a pixel."""
    found = list[str]()
    for first, second in combinations((output.wall for output in display.outputs), 2):
        apart = np.linalg.norm(first.corners[:, None] - second.corners[None], axis=2)
        almost = apart[(apart > ONE_CORNER) & (apart < NEAR_CORNER)]
        if almost.size:
            found.append(
                f"the walls {first.name!r} and {second.name!r} have corners that are {1e3 * almost.max():.1f} mm "
                "apart: measure them again if they meet there"
            )
    return found


def flown(world_t_room: Matrix, axes: Sequence[float], speed: float, seconds: float) -> Matrix:
    """Return where a room is that was flown for some time: `axes` ahead, left, up and turn, each from -1 to 1.

    It goes along its own axes, and turns about what is up through its origin, exactly: at a constant turn on an arc.
    """
    ahead, left, up, turn = (float(np.clip(one, -1.0, 1.0)) for one in axes)
    angle = turn * speed * seconds
    # Of the integral of the turn over the time: sin x / x, and (1 - cos x) / x.
    along = np.sinc(angle / math.pi)
    aside = math.sin(angle / 2.0) * np.sinc(angle / (2.0 * math.pi))
    way = speed * seconds * np.array([along * ahead - aside * left, aside * ahead + along * left, up])
    return world_t_room @ pose(*way.tolist(), yaw=math.remainder(angle, math.tau))
