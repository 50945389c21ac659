"""Rooms with dividing walls, corridors, niches and furniture, and what a vehicle can see of them at all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from virtualrobot_apps.seeing.navigation.floors import Box, true_grid
from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.planning import MARGIN
from virtualrobot_apps.seeing.navigation.poses import Floats
from virtualrobot_apps.seeing.navigation.regions import apart, parts

from tests.apps.seeing.flat_lidar import COUNT, REACH, distances
from tests.apps.seeing.flat_vehicles import room

Size = tuple[float, float]


def box(left: float, low: float, right: float, high: float) -> Box:
    """Return the box between two corners."""
    return Box(0.5 * (left + right), 0.5 * (low + high), right - left, high - low, 1.0, "brown")


def divided() -> tuple[list[Box], Size]:
    """Return two rooms with a door of 1 m at the far end of the wall between them."""
    return [*room(6.0, 5.0), box(2.95, 0.0, 3.05, 4.0), box(4.4, 1.2, 5.4, 1.9)], (6.0, 5.0)


def angled() -> tuple[list[Box], Size]:
    """Return a room like an L, with a shelf in its far leg."""
    return [*room(6.0, 6.0), box(2.4, 2.4, 6.0, 6.0), box(4.6, 2.1, 5.4, 2.4)], (6.0, 6.0)


def corridors() -> tuple[list[Box], Size]:
    """Return corridors of 1 m that turn twice."""
    return [*room(6.0, 5.0), box(1.0, 0.0, 5.0, 2.0), box(1.0, 3.0, 6.0, 5.0), box(0.0, 4.0, 0.2, 5.0)], (6.0, 5.0)


def niches() -> tuple[list[Box], Size]:
    """Return a room with niches of 0.5 m, 0.4 m and 0.9 m in a thick wall."""
    wall = [box(0.0, 3.0, 0.8, 4.2), box(1.3, 3.0, 2.2, 4.2), box(2.6, 3.0, 3.6, 4.2), box(4.5, 3.0, 5.0, 4.2)]
    return [*room(5.0, 4.2), *wall, box(2.0, 1.2, 3.0, 1.7)], (5.0, 4.2)


def three_rooms() -> tuple[list[Box], Size]:
    """Return three rooms in a row, with doors of 1 m at opposite ends."""
    walls = [box(2.6, 1.0, 2.7, 4.0), box(5.3, 0.0, 5.4, 3.0)]
    return [*room(8.0, 4.0), *walls, box(3.6, 1.4, 4.5, 2.2), box(6.6, 0.0, 7.4, 0.6)], (8.0, 4.0)


def furnished() -> tuple[list[Box], Size]:
    """Return a room full of furniture, with a wall that ends before the other side."""
    tables = [box(1.6, 1.5, 2.6, 2.1), box(4.6, 0.6, 5.4, 1.8), box(0.0, 3.4, 0.5, 4.6), box(2.2, 4.3, 3.4, 4.8)]
    return [*room(6.5, 5.5), box(3.6, 1.0, 3.7, 4.2), *tables, box(5.6, 3.6, 6.5, 4.1)], (6.5, 5.5)


def spiral() -> tuple[list[Box], Size]:
    """Return a way round into the middle."""
    return [*room(5.0, 5.0), box(1.2, 1.2, 5.0, 1.3), box(1.2, 1.2, 1.3, 3.8), box(1.2, 3.7, 3.8, 3.8)], (5.0, 5.0)


def split(rng: np.random.Generator) -> tuple[list[Box], Size]:
    """Return a drawn room: walls with doors of 1 m, and furniture that leaves the doors and a corner free."""
    wide, deep = rng.uniform(5.0, 8.0), rng.uniform(4.0, 6.0)
    boxes, doors = room(wide, deep), [np.array([0.6, 0.6])]
    for x in np.linspace(0.0, wide, int(rng.integers(3, 5)))[1:-1]:
        door = rng.uniform(0.0, deep - 1.0)
        boxes += [box(x, 0.0, x + 0.1, door), box(x, door + 1.0, x + 0.1, deep)]
        doors.append(np.array([x, door + 0.5]))
    boxes = [one for one in boxes if one.deep > 0.02]
    for _ in range(6):
        x, y, along, across = rng.uniform((0.0, 0.0, 0.3, 0.3), (wide, deep, 1.1, 1.1))
        one = Box(x, y, along, across, 1.0, "brown")
        if all(one.apart(door) > 0.7 for door in doors):
            boxes.append(one)
    return boxes, (wide, deep)


ROOMS = (divided, angled, corridors, niches, three_rooms, furnished, spiral)
START = np.array([0.6, 0.6, 0.0])


def coverable(boxes: Sequence[Box], size: Size, start: Floats, footprint: Footprint) -> tuple[Grid, NDArray[np.bool_]]:
    """Return the true map, and which of its free cells rays meet from places that a footprint comes to from a start.

    The places are those of a flood fill of the true free space.
    """
    grid = true_grid(list(boxes), 0.05, size)
    clearance = apart(~grid.free) * grid.resolution - 0.5 * grid.resolution
    labels, _ = parts(clearance >= footprint.inner + MARGIN)
    flooded = labels == labels[grid.cells(start[:2])]
    seen = np.zeros(flooded.shape, bool)
    marks = np.arange(0.0, REACH, 0.03)
    angles = np.arange(COUNT) * 2.0 * np.pi / COUNT
    along = np.column_stack([np.cos(angles), np.sin(angles)])
    rows, columns = np.nonzero(flooded)
    for place in grid.middles(rows, columns)[(rows % 3 == 0) & (columns % 3 == 0)]:
        rays, steps = np.nonzero(marks < (np.minimum(distances(boxes, np.array([*place, 0.0])), REACH) - 0.03)[:, None])
        seen[grid.cells(place + along[rays] * marks[steps, None])] = True
    return grid, seen & grid.free


def missing(found: Grid, true: Grid, seen: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the share of cells that can be seen and aren't on a map, and the greatest patch of them (m2)."""
    places = true.middles(*np.nonzero(seen))
    told = np.zeros(len(places), bool)
    inside = found.has(places)
    told[inside] = (found.free | found.occupied)[found.cells(places[inside])]
    patches = np.zeros(seen.shape, bool)
    patches[np.nonzero(seen)] = ~told
    labels, count = parts(patches)
    greatest = np.bincount(labels.ravel())[1:].max() if count else 0
    return float((~told).mean()), float(greatest) * true.resolution**2
