"""Chips by solids cut from solids, by Manifold: the oracle of those by columns."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import trimesh
from virtualrobot.geometry import Matrix as Floats
from virtualrobot_apps.processes.effects.chips import Cutter

CORNERS = 64
"""Corners of the circle of a cutter, on a circle a little larger, so that both have one area."""


def taken_off_slowly(part: trimesh.Trimesh, passes: Sequence[Floats], cutter: Cutter) -> float:
    """Return the volume that a cutter takes off a part."""
    swept = [_hull(cutter, pair) for frames in passes for pair in pairwise(frames)]
    whole = trimesh.boolean.union(swept, engine="manifold")
    return float(part.volume - trimesh.boolean.difference([part, whole], engine="manifold").volume)


def _hull(cutter: Cutter, pair: tuple[Floats, Floats]) -> trimesh.Trimesh:
    """Return what a cutter sweeps from one frame to the next: the hull of both its places."""
    angles = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
    radius = 0.5 * cutter.diameter * np.sqrt(2.0 * np.pi / (CORNERS * np.sin(2.0 * np.pi / CORNERS)))
    circle = radius * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    own = np.concatenate([circle, circle - [0.0, 0.0, cutter.length]])
    corners = np.concatenate([own @ frame[:3, :3].T + frame[:3, 3] for frame in pair])
    return trimesh.convex.convex_hull(corners)
