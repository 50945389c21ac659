"""Sections of a part by a plane."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.way import Way
from virtualrobot_apps.processes.sources.sampling import CORNER, ways_of
from virtualrobot_apps.processes.sources.surface import Floats, Surface, Whole, surface_of


def section(mesh: trimesh.Trimesh, origin: ArrayLike, normal: ArrayLike, *, corner: float = CORNER) -> list[Way]:
    """Return where a plane cuts a mesh, as ways with the surface's normals, longest first.

    Loops go round the material counter-clockwise, seen from where the plane's normal points to.

    Args:
        mesh: open or closed (m).
        origin: (3,) a point of the plane (m).
        normal: (3,) of the plane, of any length above 0.
        corner: the turn (rad) from which on ways are split.

    Raises:
        InvalidArgumentError: for a mesh that `surface_of` refuses, for a normal without length, and where the plane
            doesn't cut it.
    """
    surface = surface_of(mesh)
    at, up = finite("origin", origin), unit("normal", normal)
    heights = (surface.corners - at) @ up
    if heights.min() >= 0.0 or heights.max() < 0.0:
        raise InvalidArgumentError(
            f"the plane doesn't cut the mesh, which is from {1e3 * heights.min():.6g} to {1e3 * heights.max():.6g} mm "
            "along its normal"
        )
    found = cut(surface, heights, np.arange(len(surface.triangles)), corner)
    return sorted(found, key=lambda way: (-round(way.length, 9), *np.round(way.points[0], 9).tolist()))


def cut(surface: Surface, heights: Floats, chosen: Whole, corner: float = CORNER) -> list[Way]:
    """Return the ways on chosen triangles where heights (v,) of the corners pass 0, the higher side on the right.

    A corner at 0 counts as just above, so each triangle is cut in one line or not at all, and lines hang together by
    the edges that they end on, whatever the distances.
    """
    above = heights >= 0.0
    cut_here = above[surface.triangles[chosen]]
    chosen = chosen[cut_here.any(axis=1) & ~cut_here.all(axis=1)]
    # The edges of a triangle as they go round it; the line goes in where one falls and out where one rises.
    begin = surface.triangles[chosen]
    end = np.roll(begin, -1, axis=1)
    keys = surface.edges.min(axis=1) * len(heights) + surface.edges.max(axis=1)
    order = np.argsort(keys)
    edge = order[np.searchsorted(keys, np.minimum(begin, end) * len(heights) + np.maximum(begin, end), sorter=order)]
    entries, exits = edge[above[begin] & ~above[end]], edge[~above[begin] & above[end]]
    following = dict(zip(entries.tolist(), zip(exits.tolist(), chosen.tolist(), strict=True), strict=True))
    ways = []
    entered = {edge for edge, _ in following.values()}
    for start in [*(edge for edge in following if edge not in entered), *list(following)]:
        row, faces = [start], []
        while row[-1] in following:
            edge, triangle = following.pop(row[-1])
            row.append(edge)
            faces.append(triangle)
        if faces:
            a, b = surface.edges[row].T
            part = (heights[a] / (heights[a] - heights[b]))[:, None]
            points = surface.corners[a] + part * (surface.corners[b] - surface.corners[a])
            ways += _ways(points, surface.normals[faces], row[0] == row[-1], corner)
    return ways


def _ways(places: Floats, normals: Floats, closed: bool, corner: float) -> list[Way]:
    """Return ways of lines, without those that have no length: where a plane goes through a corner of the mesh."""
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    long = steps > 1e-9
    if not long.any():
        return []
    kept = np.concatenate([places[:-1][long], places[-1:]])
    if closed:
        kept[-1] = kept[0]
    return ways_of(kept, normals[long][:, None], closed and long.sum() > 2, corner)


def finite(what: str, value: ArrayLike) -> Floats:
    """Return a vector (3,); raise InvalidArgumentError for another shape, and for what isn't finite."""
    vector = np.array(value, dtype=np.float64)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise InvalidArgumentError(f"the {what} is {np.asarray(value).tolist()}; it must be three finite numbers")
    return vector


def unit(what: str, value: ArrayLike) -> Floats:
    """Return a vector (3,) of length 1 along another; raise InvalidArgumentError where that has none."""
    vector = finite(what, value)
    size = float(np.linalg.norm(vector))
    if not size:
        raise InvalidArgumentError(f"the {what} has no length")
    return vector / size
