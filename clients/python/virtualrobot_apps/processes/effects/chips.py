"""Chips that cutters take off a part: their volume, by what was in columns along the cutter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.processes.effects.cutting import cut, taken
from virtualrobot_apps.processes.leading import Led
from virtualrobot_apps.processes.part import part_mesh
from virtualrobot_apps.processes.sources.surface import solid_of

Floats = NDArray[np.float64]

ACROSS = 128
"""Columns in a diameter of a cutter: a whole number, so that slots along the grid are as wide as they are."""
LEAST_ACROSS = 16
MOST_COLUMNS = 16_000_000
"""Columns at once, where ways that lie together are wide: then there are fewer in a diameter."""
ALONG = 1e-4
"""Turn (rad) from frame to frame up to which a cutter goes without turning its axis."""


@dataclass(frozen=True, slots=True)
class Cutter:
    """Cylinder that cuts all around and at its end, `diameter` wide and `length` long from its tip (m)."""

    diameter: float
    length: float


@dataclass(frozen=True, slots=True)
class Chips:
    """Chips of cutters: their volume (m^3), or what it is at most, since cuts of several axes may cross."""

    volume: float
    at_most: bool = False


def taken_off(part: trimesh.Trimesh, passes: Sequence[Floats], cutter: Cutter) -> Chips:
    """Return what a cutter takes off a part, which is one closed body.

    Passes along one axis are cut together; in a column from the least to the greatest place that the cutter was at.

    Args:
        part: the part (m).
        passes: frames (n, 4, 4) of the cutter's tip on each pass, in the part's frame, z into it and along the cutter;
            from frame to frame it goes straight.
        cutter: the cutter.

    Raises:
        InvalidArgumentError: for a cutter without size, a part that is not closed, and a pass on which its axis turns.
    """
    if min(cutter.diameter, cutter.length) <= 0.0:
        raise InvalidArgumentError("a cutter has a diameter and a length above 0")
    if not passes:
        return Chips(0.0)
    solid_of(part)
    axes = list[Floats]()
    groups = list[list[Floats]]()
    for frames in map(_checked, passes):
        axis = frames[0, :3, 2]
        same = [row for row, other in enumerate(axes) if np.linalg.norm(axis - other) <= ALONG]
        if not same:
            axes.append(axis)
            groups.append([])
        groups[same[0] if same else -1].append(frames[:, :3, 3])
    volume = sum(_along(part, axis, tips, cutter) for axis, tips in zip(axes, groups, strict=True))
    return Chips(volume, len(axes) > 1)


def _along(part: trimesh.Trimesh, axis: Floats, passes: list[Floats], cutter: Cutter) -> float:
    """Return the volume that passes (n, 3) take off along an axis, those together that lie on each other."""
    across = np.eye(3)[np.abs(axis).argmin()]
    x = np.cross(across, axis)
    x /= np.linalg.norm(x)
    turned = np.stack([x, np.cross(axis, x), axis])
    triangles, radius = part.triangles @ turned.T, 0.5 * cutter.diameter
    tips = [one @ turned.T for one in passes]
    boxes = [(one[:, :2].min(axis=0) - radius, one[:, :2].max(axis=0) + radius) for one in tips]
    volume = 0.0
    for rows in _together(boxes):
        low, high = (of([boxes[row][end] for row in rows], axis=0) for end, of in enumerate((np.min, np.max)))
        size = high - low
        fewer = cutter.diameter / np.sqrt(np.prod(size) / MOST_COLUMNS)
        pitch = cutter.diameter / int(np.clip(fewer, LEAST_ACROSS, ACROSS))
        shape = (int(size[1] / pitch) + 2, int(size[0] / pitch) + 2)
        above, below = np.full(shape, np.inf, np.float32), np.full(shape, -np.inf, np.float32)
        # A part of a pitch off, so that no edge of a box lies on a row.
        begin = low[0] - pitch, low[1] - 0.29 * pitch
        for row in rows:
            cut(tips[row], radius, cutter.length, *begin, pitch, above, below)
        before = (triangles[:, :, :2].min(axis=1) < high).all(axis=1)
        near = triangles[before & (triangles[:, :, :2].max(axis=1) > low).all(axis=1)]
        volume += taken(np.ascontiguousarray(near), *begin, pitch, above, below)
    return volume


def _together(boxes: list[tuple[Floats, Floats]]) -> list[list[int]]:
    """Return the rows of boxes (low, high) that overlap, in groups of which no two do."""
    groups = list[tuple[Floats, Floats, list[int]]]()
    for row, (low, high) in enumerate(boxes):
        rows = [row]
        while touched := [one for one in groups if (one[0] < high).all() and (one[1] > low).all()]:
            groups = [one for one in groups if not any(one is other for other in touched)]
            for other in touched:
                low, high, rows = np.minimum(low, other[0]), np.maximum(high, other[1]), [*other[2], *rows]
        groups.append((low, high, rows))
    return [rows for _, _, rows in groups]


def read_cutter(fields: dict[str, Item]) -> Cutter | None:
    """Return the cutter of a file, by its fields `diameter` and `length`; None where it has neither.

    Raises MalformedFileError, with file and line, for one without the other.
    """
    given = [name for name in ("diameter", "length") if name in fields]
    if len(given) == 1:
        raise fields[given[0]].error("a cutter has a `diameter` and a `length` in m: give both, or neither")
    return Cutter(*(fields[name].number(1e-5, 1.0) for name in given)) if given else None


def measures(client: Client, led: Led, cutter: Cutter | None) -> tuple[str, ...]:
    """Return a line about the chips of each part; none without a cutter."""
    if cutter is None:
        return ()
    found = []
    for parts, stretches in led.by_parts().items():
        chips = taken_off(part_mesh(client, parts), [one.frames for one in stretches], cutter)
        bound = "at most " if chips.at_most else ""
        found.append(f"{bound}{1e6 * chips.volume:.4g} cm^3 are taken off {', '.join(parts)}")
    return tuple(found)


def _checked(frames: Floats) -> Floats:
    axes = frames[:, :3, 2]
    turned = np.linalg.norm(np.cross(axes[:-1], axes[1:]), axis=1)
    if len(turned) and turned.max() > ALONG:
        row = int(turned.argmax())
        raise InvalidArgumentError(
            f"the cutter's axis turns by {np.degrees(turned[row]):.3g} degrees after frames[{row}]; give it one "
            "heading and one normal"
        )
    return frames
