"""Rasters: ways side by side over a surface, such as spray guns, sanders and scanners go."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.way import Way, above_zero
from virtualrobot_apps.processes.sources.fairing import FAIR, fair
from virtualrobot_apps.processes.sources.sampling import CHORD, STEP, sampled
from virtualrobot_apps.processes.sources.sections import cut, unit
from virtualrobot_apps.processes.sources.surface import Floats, Surface, Whole, surface_of

FACING = np.radians(75.0)
"""Angle (rad) of a surface to the tool up to which it is gone over."""
MOST_PASSES = 10_000
BINS = 4096
"""Parts of a surface's width whose slopes are looked at."""


def raster(
    mesh: trimesh.Trimesh,
    step_over: float,
    direction: ArrayLike,
    *,
    axis: ArrayLike | None = None,
    facing: float = FACING,
    lead_in: float = 0.0,
    lead_out: float = 0.0,
    back_and_forth: bool = True,
    chord: float = CHORD,
    step: float = STEP,
) -> list[Way]:
    """Return ways over what of a surface is seen along an axis, in planes along it and along a direction.

    Where the surface slopes across the ways, planes are nearer to each other, by the cosine of its steepest slope
    there: ways are `step_over` apart on it, or less. The outer ones are as far within the rim on either side, at most
    half of that.

    Args:
        mesh: open or closed (m).
        step_over: the distance of two ways on the surface (m).
        direction: (3,) in which the ways go, as far as it is across the axis.
        axis: (3,) in which the tool points, of any length above 0; by default against the mean normal of an open mesh.
        facing: the angle (rad) between normal and axis up to which triangles are gone over.
        lead_in: how far before the rim each way begins, straight on (m).
        lead_out: how far after the rim each way ends (m).
        back_and_forth: turns every other way.
        chord: as of `sampling.sampled`, like `step`, within which rims of what is hidden are found.
        step: the longest distance of two points of a way (m).

    Raises:
        InvalidArgumentError: for a mesh that `surface_of` refuses, for lengths that make no sense, for a direction
            along the axis, for a closed mesh without an axis, and where nothing faces the tool.
    """
    surface = surface_of(mesh)
    above_zero("step_over", step_over)
    for what, value in (("lead_in", lead_in), ("lead_out", lead_out)):
        if not (np.isfinite(value) and value >= 0.0):
            raise InvalidArgumentError(f"the {what} is {value:g} m; it must be 0 or more")
    up = -unit("axis", axis) if axis is not None else _mean_normal(surface)
    along = unit("direction", direction)
    along = along - (along @ up) * up
    if np.linalg.norm(along) < 1e-6:
        raise InvalidArgumentError("the direction of a raster is along its axis; give one across it")
    along = along / np.linalg.norm(along)
    aside = np.cross(up, along)
    chosen = np.flatnonzero(surface.normals @ up > np.cos(facing))
    if not len(chosen):
        raise InvalidArgumentError(
            f"nothing of the surface faces the tool within {np.degrees(facing):.6g} degrees; turn the axis round, or "
            "give a greater angle"
        )
    heights = surface.corners @ aside
    found: list[Way] = []
    slopes = surface.normals[chosen] @ aside
    for row, plane in enumerate(_planes(heights[surface.triangles[chosen]], slopes, step_over)):
        ways = _seen(surface, heights - plane, chosen, up, along, chord, step)
        ways = sorted(ways, key=lambda way: float(way.points[0] @ along))
        ways = [fair(_led(way, lead_in, lead_out, step), FAIR * chord, step) for way in ways]
        found += [way.reversed() for way in reversed(ways)] if back_and_forth and row % 2 else ways
    if not found:
        raise InvalidArgumentError("nothing of the surface is seen along the axis")
    return found


def _mean_normal(surface: Surface) -> Floats:
    a, b, c = (surface.corners[surface.triangles[:, k]] for k in range(3))
    doubled = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    mean = doubled @ surface.normals / doubled.sum()
    if np.linalg.norm(mean) < 1e-3:
        raise InvalidArgumentError("a closed surface has no mean normal; give the axis in which the tool points")
    return mean / np.linalg.norm(mean)


def _planes(heights: Floats, slopes: Floats, step_over: float) -> Floats:
    """Return where planes are: so many as go in between, evenly within the rims, by the width of the surface itself.

    Args:
        heights: (f, 3) of the corners of triangles (m).
        slopes: (f,) sines of their slopes along the heights.
        step_over: the distance of two planes on the surface (m).
    """
    low, high = float(heights.min()), float(heights.max())
    bins = np.linspace(low, high, BINS + 1)
    first, last = (
        np.clip((one - low) / (high - low) * BINS, 0, BINS - 1).astype(np.int64)
        for one in (heights.min(axis=1), heights.max(axis=1))
    )
    counts = last - first + 1
    ends = np.cumsum(counts)
    within = np.arange(ends[-1]) - np.repeat(ends - counts - first, counts)
    stretch = np.ones(BINS)
    np.maximum.at(stretch, within, np.repeat(1.0 / np.sqrt(np.maximum(1.0 - slopes**2, 1e-6)), counts))
    width = np.concatenate([[0.0], np.cumsum(stretch * np.diff(bins))])
    count = max(1, int(np.ceil(width[-1] / step_over - 1e-9)))
    if count > MOST_PASSES:
        raise InvalidArgumentError(
            f"a surface {width[-1]:.6g} m wide has over {MOST_PASSES:,} ways {step_over:g} m apart; is its unit m?"
        )
    return np.interp(0.5 * width[-1] + step_over * (np.arange(count) - 0.5 * (count - 1)), width, bins)


def _seen(
    surface: Surface, heights: Floats, chosen: Whole, up: Floats, along: Floats, chord: float, step: float
) -> list[Way]:
    """Return the ways of one plane along a direction, without what is below something else."""
    # Above are those of any triangle, also of such as don't face the tool.
    lines = [way.points for way in cut(surface, heights, np.arange(len(surface.triangles)), np.pi)]
    begins, ends = (
        np.concatenate([one[part] for one in lines] or [np.empty((0, 3))]) for part in (np.s_[:-1], np.s_[1:])
    )
    found = []
    for way in cut(surface, heights, chosen, np.pi):
        if (way.points[-1] - way.points[0]) @ along < 0.0:
            way = way.reversed()
        way = sampled(way, chord, step)
        # What is sampled is within the chord of the lines: in a hollow it is below them.
        hidden = _below(way.points, begins, ends, up, along, chord + 1e-6 * surface.size)
        for rows in np.split(np.arange(len(hidden)), np.flatnonzero(np.diff(hidden)) + 1):
            if len(rows) > 1 and not hidden[rows[0]]:
                found.append(Way(way.points[rows], way.normals[rows]))
    return found


def _below(points: Floats, begins: Floats, ends: Floats, up: Floats, along: Floats, least: float) -> np.ndarray:
    """Return whether points (n, 3) are below one of the lines (m, 3) to (m, 3) of their plane, by over `least` (m)."""
    at, high = points @ along, points @ up
    first, last = begins @ along, ends @ along
    hidden = np.zeros(len(points), dtype=bool)
    wide = np.abs(last - first) > 1e-12
    for a, b, low, top in zip(first[wide], last[wide], (begins @ up)[wide], (ends @ up)[wide], strict=True):
        part = (at - a) / (b - a)
        hidden |= (part > 1e-6) & (part < 1.0 - 1e-6) & (low + part * (top - low) > high + least)
    return hidden


def _led(way: Way, lead_in: float, lead_out: float, step: float) -> Way:
    """Return a way that goes straight on before its beginning and after its end, by lengths (m), in steps (m)."""
    points, normals, tangents = way.points, way.normals, way.tangents
    if lead_in:
        points = np.concatenate([points[0] - _along(lead_in, step)[::-1, None] * tangents[0], points])
        normals = np.concatenate([normals[:1].repeat(len(points) - len(normals), axis=0), normals])
    if lead_out:
        points = np.concatenate([points, points[-1] + _along(lead_out, step)[:, None] * tangents[-1]])
        normals = np.concatenate([normals, normals[-1:].repeat(len(points) - len(normals), axis=0)])
    return Way(points, normals)


def _along(length: float, step: float) -> Floats:
    """Return places up to a length (m), at most a step (m) apart, without 0."""
    count = int(np.ceil(length / step - 1e-9))
    return length * np.arange(1, count + 1) / count
