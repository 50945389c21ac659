"""Chips that cutters take off a part: their volume, and what is left of the part, by solids cut from solids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import pairwise

import numpy as np
import trimesh
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, WrongStateError

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.processes.leading import Led
from virtualrobot_apps.processes.part import part_mesh

Floats = NDArray[np.float64]

CORNERS = 128
"""Corners of the circle of a cutter, on it, four of them on the axes: a round hole comes out 0.04% too small."""
ALONG = 1e-4
"""Turn (rad) from frame to frame up to which a cutter goes without turning its axis."""


@dataclass(frozen=True, slots=True)
class Cutter:
    """Cylinder that cuts all around and at its end, `diameter` wide and `length` long from its tip (m)."""

    diameter: float
    length: float


@dataclass(frozen=True, slots=True, eq=False)
class Chips:
    """Chips of cutters, and the part without them.

    Attributes:
        volume: of the chips (m^3).
        left: what is left of the part.
    """

    volume: float
    left: trimesh.Trimesh


def taken_off(part: trimesh.Trimesh, passes: Sequence[Floats], cutter: Cutter) -> Chips:
    """Return what a cutter takes off a part, which is one closed body.

    Args:
        part: the part (m).
        passes: frames (n, 4, 4) of the cutter's tip on each pass, in the part's frame, z into it and along the cutter;
            from frame to frame it goes straight.
        cutter: the cutter.

    Raises:
        InvalidArgumentError: for a cutter without size, and for a pass on which its axis turns: what it sweeps then is
            no convex solid from frame to frame.
    """
    if min(cutter.diameter, cutter.length) <= 0.0:
        raise InvalidArgumentError("a cutter has a diameter and a length above 0")
    swept = [_hull(cutter, pair) for frames in passes for pair in pairwise(_checked(frames))]
    if not swept:
        return Chips(0.0, part)
    whole = trimesh.boolean.union(swept, engine="manifold") if len(swept) > 1 else swept[0]
    left = trimesh.boolean.difference([part, whole], engine="manifold")
    return Chips(float(part.volume - left.volume), left)


def read_cutter(fields: dict[str, Item]) -> Cutter | None:
    """Return the cutter of a file, by its fields `diameter` and `length`; None where it has neither.

    Raises MalformedFileError, with file and line, for one without the other.
    """
    given = [name for name in ("diameter", "length") if name in fields]
    if len(given) == 1:
        raise fields[given[0]].error("a cutter has a `diameter` and a `length` in m: give both, or neither")
    return Cutter(*(fields[name].number(1e-5, 1.0) for name in given)) if given else None


def measures(client: Client, led: Led, cutter: Cutter | None) -> tuple[str, ...]:
    """Return a line about the chips of each part; none without a cutter.

    Raises WrongStateError where manifold3d, by which solids are cut, is not installed.
    """
    if cutter is None:
        return ()
    if find_spec("manifold3d") is None:
        raise WrongStateError("chips need manifold3d: pip install 'virtualrobot[processes]'")
    found = []
    for parts, stretches in led.by_parts().items():
        chips = taken_off(part_mesh(client, parts), [one.frames for one in stretches], cutter)
        found.append(f"{1e6 * chips.volume:.4g} cm^3 are taken off {', '.join(parts)}")
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


def _hull(cutter: Cutter, pair: tuple[Floats, Floats]) -> trimesh.Trimesh:
    """Return what a cutter sweeps from one frame to the next: the hull of both its places."""
    angles = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
    circle = 0.5 * cutter.diameter * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    own = np.concatenate([circle, circle - [0.0, 0.0, cutter.length]])
    corners = np.concatenate([own @ frame[:3, :3].T + frame[:3, 3] for frame in pair])
    return trimesh.convex.convex_hull(corners)
