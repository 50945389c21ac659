"""Box, Sphere, Cylinder, Cone and Extrusion as triangles; y is their axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_plugins.importers.glb import Piece, unit
from virtualrobot_plugins.importers.polygons import triangulate_one
from virtualrobot_plugins.importers.vrml.fields import Bound
from virtualrobot_plugins.importers.vrml.transforms import rotation

SIDES = 48
"""Sides of a circle: a chord is 0.2 % of the radius off its arc."""

MAX_EXTRUSION = 5_000_000


def box(node: Bound) -> Piece:
    """Return a Box (ISO/IEC 14772-1, 6.6)."""
    size = node.numbers("size", (2.0, 2.0, 2.0), 3)
    _check(node, size=float(size.min()))
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return Piece(corners * size, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def sphere(node: Bound) -> Piece:
    """Return a Sphere (ISO/IEC 14772-1, 6.42)."""
    radius = node.number("radius", 1.0)
    _check(node, radius=radius)
    angles = np.linspace(-np.pi / 2.0, np.pi / 2.0, SIDES // 2 + 1)
    return _turned(radius * np.cos(angles), radius * np.sin(angles))


def cylinder(node: Bound) -> Piece:
    """Return a Cylinder (ISO/IEC 14772-1, 6.14), of which parts may be missing."""
    radius, height = node.number("radius", 1.0), node.number("height", 2.0)
    _check(node, radius=radius, height=height)
    bottom, side, top = (node.truth(name, True) for name in ("bottom", "side", "top"))
    radii = np.array([0.0, radius, radius, 0.0])
    heights = np.array([-0.5, -0.5, 0.5, 0.5]) * height
    return _turned(radii, heights, [bottom, side, top])


def cone(node: Bound) -> Piece:
    """Return a Cone (ISO/IEC 14772-1, 6.10), of which parts may be missing."""
    radius, height = node.number("bottomRadius", 1.0), node.number("height", 2.0)
    _check(node, bottomRadius=radius, height=height)
    bottom, side = node.truth("bottom", True), node.truth("side", True)
    return _turned(np.array([0.0, radius, 0.0]), np.array([-0.5, -0.5, 0.5]) * height, [bottom, side])


def extrusion(node: Bound) -> Piece | None:
    """Return an Extrusion (ISO/IEC 14772-1, 6.18); None for one without extent."""
    section = node.rows("crossSection", 2)
    section = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1], [1, 1]], np.float64) if section is None else section
    spine = node.rows("spine", 3)
    spine = np.array([[0, 0, 0], [0, 1, 0]], np.float64) if spine is None else spine
    count, around = len(spine), len(section)
    if count < 2 or around < 2:
        return None
    if count * around > MAX_EXTRUSION:
        raise node.error(f"{count} points of the spine by {around} of the cross section are too many")
    scales = _one_each(node, "scale", (1.0, 1.0), count)
    turns = _one_each(node, "orientation", (0.0, 0.0, 1.0, 0.0), count)
    frames = _spine_frames(spine)
    points = np.empty((count, around, 3))
    for number in range(count):
        flat = np.zeros((around, 3))
        flat[:, [0, 2]] = section * scales[number]
        points[number] = spine[number] + flat @ (frames[number] @ rotation(turns[number])).T
    numbers = np.arange(count * around).reshape(count, around)
    low, high = numbers[:-1], numbers[1:]
    quads = np.stack([low[:, :-1], low[:, 1:], high[:, 1:], high[:, :-1]], axis=-1).reshape(-1, 4)
    faces = [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    closed = np.array_equal(section[0], section[-1])
    ring = numbers[:, :-1] if closed else numbers
    if ring.shape[1] >= 3:
        flat = np.column_stack([section[:, 0], np.zeros(around), section[:, 1]])[: ring.shape[1]]
        cap = triangulate_one(flat)
        if node.truth("beginCap", True):
            faces.append(ring[0][cap[:, ::-1]])
        if node.truth("endCap", True):
            faces.append(ring[-1][cap])
    joined = np.concatenate(faces)
    return Piece(points.reshape(-1, 3), joined if node.truth("ccw", True) else joined[:, ::-1])


def _one_each(node: Bound, name: str, default: tuple[float, ...], count: int) -> NDArray[np.float64]:
    """Return a row for each point of the spine; one row counts for all."""
    rows = node.rows(name, len(default))
    rows = np.array([default]) if rows is None or len(rows) == 0 else rows
    if len(rows) == 1:
        return np.repeat(rows, count, axis=0)
    if len(rows) < count:
        raise node.error(f"{name} has {len(rows)} entries for {count} points of the spine")
    return rows[:count]


def _spine_frames(spine: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the frames (n, 3, 3) of the planes of the cross sections, as 6.18.3 has them."""
    count = len(spine)
    closed = count > 2 and np.array_equal(spine[0], spine[-1])
    steps = np.diff(spine, axis=0)
    ahead = np.concatenate([steps, steps[:1] if closed else steps[-1:]])
    behind = np.concatenate([steps[-1:] if closed else steps[:1], steps])
    y_axes = _filled(unit(ahead + behind))
    z_axes = np.cross(ahead, -behind)
    z_axes[np.linalg.norm(z_axes, axis=1) < 1e-9 * np.linalg.norm(steps, axis=1).max() ** 2] = 0.0
    z_axes = _filled(unit(z_axes))
    if not z_axes.any():  # a straight spine: turn the y axis onto it the shortest way
        return np.repeat(_onto(y_axes[0])[None], count, axis=0)
    for number in range(1, count):
        if z_axes[number] @ z_axes[number - 1] < 0.0:
            z_axes[number] = -z_axes[number]
    x_axes = unit(np.cross(y_axes, z_axes))
    return np.stack([x_axes, y_axes, z_axes], axis=-1)


def _filled(axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return axes where each that is zero is the last one before that is not, or the first one at the start."""
    known = np.flatnonzero(axes.any(axis=1))
    if len(known) == 0:
        return axes
    chosen = np.maximum.accumulate(np.where(axes.any(axis=1), np.arange(len(axes)), known[0]))
    return axes[chosen]


def _onto(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation (3, 3) of least angle that takes y to a unit vector."""
    axis = np.cross([0.0, 1.0, 0.0], direction)
    if not axis.any():
        return np.eye(3) if direction[1] >= 0.0 else np.diag([1.0, -1.0, -1.0])
    return rotation(np.array([*axis, np.arctan2(np.linalg.norm(axis), direction[1])]))


def _turned(radii: NDArray[np.float64], heights: NDArray[np.float64], parts: list[bool] | None = None) -> Piece:
    """Return what a line of radii over heights, upwards, sweeps about y; `parts` says which stretches are there."""
    angles = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    circle = np.column_stack([np.sin(angles), np.zeros(SIDES), np.cos(angles)])
    points = radii[:, None, None] * circle[None] + heights[:, None, None] * np.array([0.0, 1.0, 0.0])
    numbers = np.arange(len(radii) * SIDES).reshape(len(radii), SIDES)
    following = np.roll(numbers, -1, axis=1)
    faces = []
    for number in range(len(radii) - 1):
        if parts is not None and not parts[number]:
            continue
        low, high = numbers[number], numbers[number + 1]
        if radii[number] > 1e-12 * radii.max():
            faces.append(np.column_stack([low, following[number], following[number + 1]]))
        if radii[number + 1] > 1e-12 * radii.max():
            faces.append(np.column_stack([low, following[number + 1], high]))
    # Where the radius is 0 one of the two triangles has no area, and the other one is enough.
    joined = np.concatenate(faces) if faces else np.zeros((0, 3), np.intp)
    return Piece(points.reshape(-1, 3), joined)


def _check(node: Bound, **lengths: float) -> None:
    for name, value in lengths.items():
        if value < 0.0:
            raise node.error(f"{name} is {value:g}; it must not be below 0")
