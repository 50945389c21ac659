"""Grasps from straight above on a map of heights, as a scanner over a bin sees it.

Y. Domae et al., Fast Graspability Evaluation on Single Depth Maps for Bin Picking with General Grippers, IEEE ICRA
2014: a grasp is where the outlines of open fingers meet nothing above their tips, and something is between them.
Parts need no model, and none is told from the next one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.seeing.given import finite
from virtualrobot_apps.seeing.grasping.jaw import Jaw

Floats = NDArray[np.float64]

CELL = 0.003
"""Edge (m) of a cell."""
TURNS = 16
"""Directions of closing that are tried, over half a turn."""
KEPT = 0.002
"""Distance (m) that open fingers keep from what is beside and below them, unless another one is told."""
SHALLOWEST, DEEPEST = 0.014, 0.03
"""Depth (m) of tips below the top of what is gripped: at least, and at most."""
UNEVEN = 0.006
"""Distance (m) by which edges between fingers may be off from parallel to these, and their middle from the jaw's."""
THINNEST = 0.008
"""Width (m) of the thinnest thing that is gripped."""
APART = 0.02
"""Distance (m) between grasps that are told."""
_SPACING = 0.002


@dataclass(frozen=True, slots=True, eq=False)
class Heights:
    """Map of heights: (rows, columns) along y and x (m), and the lowest corner (2,)."""

    low: Floats
    heights: Floats

    @classmethod
    def of(cls, points: Floats, low: ArrayLike, high: ArrayLike) -> Heights:
        """Return the highest points (n, 3) in cells between corners (2,) x, y (m); unseen ones as the highest beside.

        Raises:
            InvalidArgumentError: where no point is between them.
        """
        points, corner = finite(points, 3, "points of a bin"), np.asarray(low, np.float64)
        columns, rows = np.ceil((np.asarray(high, np.float64) - corner) / CELL - 1e-9).astype(int)
        at = np.floor((points[:, :2] - corner) / CELL).astype(int)
        inside = ((at >= 0) & (at < (columns, rows))).all(axis=1)
        if not inside.any():
            raise InvalidArgumentError(f"none of {len(points)} echoes is between {low} and {high}")
        heights = np.full((rows, columns), -np.inf)
        np.maximum.at(heights, (at[inside, 1], at[inside, 0]), points[inside, 2])
        while not np.isfinite(heights).all():
            wide = np.pad(heights, 1, constant_values=-np.inf)
            beside = np.max([wide[:-2, 1:-1], wide[2:, 1:-1], wide[1:-1, :-2], wide[1:-1, 2:]], axis=0)
            heights = np.where(np.isfinite(heights), heights, beside)
        return cls(corner, heights)

    def at(self, places: Floats) -> Floats:
        """Return the heights at places (..., 2) (m); beyond the map they are those at its edge."""
        found = ((places - self.low) / CELL).astype(np.int64)
        rows, columns = self.heights.shape
        return self.heights[np.clip(found[..., 1], 0, rows - 1), np.clip(found[..., 0], 0, columns - 1)]


@dataclass(frozen=True, slots=True, eq=False)
class FromAbove:
    """Grasp from above: pose (4, 4) of the tool centre point, width of what is held, and how deep tips are (m)."""

    pose: Floats
    width: float
    depth: float


def grasps_from_above(
    heights: Heights, jaw: Jaw, floor: float, low: Floats, high: Floats, clear: float = KEPT
) -> list[FromAbove]:
    """Return grasps of what lies between corners (2,) x, y, higher than a floor (m).

    The deepest of the highest come first; they are APART from each other. What is beyond the corners, such as walls of
    a bin, is only kept clear of, by a distance (m) that is below 0 where fingers may push it aside: above minus half of
    their thickness.
    """
    rows, columns = np.nonzero(heights.heights > floor + SHALLOWEST)
    middles = heights.low + (np.column_stack([columns, rows]) + 0.5) * CELL
    middles = middles[((middles > low) & (middles < high)).all(axis=1)]
    found: list[tuple[float, FromAbove]] = []
    for turn in np.arange(TURNS) * np.pi / TURNS:
        found += _along(heights, jaw, floor, middles, np.array([np.cos(turn), np.sin(turn)]), clear)
    chosen: list[FromAbove] = []
    for _, one in sorted(found, key=lambda rated: -rated[0]):
        if all(np.linalg.norm(one.pose[:3, 3] - other.pose[:3, 3]) > APART for other in chosen):
            chosen.append(one)
    return chosen


def _along(
    heights: Heights, jaw: Jaw, floor: float, middles: Floats, axis: Floats, clear: float
) -> list[tuple[float, FromAbove]]:
    """Return grasps about places (n, 2) by fingers that close along an axis (2,), each with how good it is."""
    side = np.array([-axis[1], axis[0]])
    half, wide = 0.5 * jaw.opening, 0.5 * jaw.wide
    lines = np.array([-wide, 0.0, wide])
    beyond = np.arange(half - clear, half + jaw.thick + clear + 1e-9, _SPACING)
    across = np.arange(-wide - clear, wide + clear + 1e-9, _SPACING)
    fingers = _grid(np.concatenate([-beyond, beyond]), across, axis, side)
    under = heights.at(middles[:, None] + fingers).max(axis=1)
    top = heights.at(middles)
    tips = np.maximum(np.maximum(under, floor) + KEPT, top - DEEPEST)
    kept = top - tips >= SHALLOWEST
    middles, top, tips = middles[kept], top[kept], tips[kept]
    if not len(middles):
        return []
    marks = np.arange(-half + KEPT, half - KEPT + 1e-9, _SPACING)
    between = heights.at(middles[:, None] + _grid(marks, lines, axis, side)).reshape(-1, len(marks), len(lines))
    body = between > (tips + 0.5 * SHALLOWEST)[:, None, None]
    first, last = marks[body.argmax(axis=1)], marks[len(marks) - 1 - body[:, ::-1].argmax(axis=1)]
    low, high = first.min(axis=1), last.max(axis=1)
    slant = np.maximum(np.ptp(first, axis=1), np.ptp(last, axis=1))
    off = np.abs(low + high) * 0.5
    known = np.asarray(body.any(axis=1), bool)
    good = known.all(axis=1) & (slant <= UNEVEN) & (off <= UNEVEN) & (high - low >= THINNEST)
    ratings = top + (top - tips) - 2.0 * slant - off
    return [
        (
            float(ratings[at]),
            FromAbove(
                _pose(middles[at], float(tips[at]) + jaw.tip, axis),
                float(high[at] - low[at]),
                float(top[at] - tips[at]),
            ),
        )
        for at in np.flatnonzero(good)
    ]


def _grid(along: Floats, across: Floats, axis: Floats, side: Floats) -> Floats:
    """Return places (n, 2) so far along an axis and across it."""
    return (along[:, None, None] * axis + across[None, :, None] * side).reshape(-1, 2)


def _pose(middle: Floats, height: float, axis: Floats) -> Floats:
    """Return the pose (4, 4) of a tool that looks down, its y along an axis: of both ways round that along y."""
    y = np.array([*axis, 0.0]) * (1.0 if axis[1] >= 0.0 else -1.0)
    pose = np.eye(4)
    pose[:3, 1], pose[:3, 2] = y, (0.0, 0.0, -1.0)
    pose[:3, 0] = np.cross(pose[:3, 1], pose[:3, 2])
    pose[:3, 3] = *middle, height
    return pose
