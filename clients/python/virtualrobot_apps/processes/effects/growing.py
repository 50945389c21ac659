"""Effects that grow while a process runs, as coats: film, bead, and how deep a cutter has been."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
import trimesh
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.view.coats import CoatHandle

from virtualrobot_apps.curves.way import Floats
from virtualrobot_apps.processes.effects.chips import Cutter
from virtualrobot_apps.processes.effects.film import Jet, Spraying, sprayed
from virtualrobot_apps.processes.part import divided, part_mesh

OUT = 0.0002
"""Distance (m) of a coat from the surface that it lies on."""
MOST_FACES = 80_000
"""Triangles of a coat at most, by which it gets coarser."""
FINE = 0.06
"""Longest edge of a triangle under a film, in parts of the jet's width; under a cutter, of four diameters."""
AROUND = 12
"""Corners around a bead."""
RING = 0.002
"""Distance (m) between these rings."""
MICRO, MILLI = 1e6, 1e3


@dataclass(frozen=True, slots=True)
class Legend:
    """Legend of an effect: title, unit, and the greatest quantity; the least is 0."""

    title: str
    unit: str
    high: float


class Growth(Protocol):
    """Effect on a part, by its corners."""

    @property
    def legend(self) -> Legend:
        """The legend."""
        ...

    @property
    def skin(self) -> tuple[Floats, NDArray[np.int64]]:
        """Corners (n, 3) in the part's frame and triangles (m, 3) of what is coloured."""
        ...

    def go(self, stretch: int, begin: float, end: float) -> Floats:
        """Go on along a stretch from one time (s) to another; return the quantities (n,), NaN where nothing is."""
        ...


def coat_of(client: Client, name: str, node: str, growth: Growth) -> CoatHandle:
    """Put an effect on a part."""
    legend, (vertices, faces) = growth.legend, growth.skin
    high = float(f"{legend.high:.2g}") or 1.0
    return client.view.add_coat(name, node, vertices, faces, low=0.0, high=high, unit=legend.unit, title=legend.title)


def between(frames: Floats, times: Floats, begin: float, end: float) -> tuple[Floats, Floats]:
    """Return the frames and times of a stretch from one time to another, with those at both ends."""
    begin, end = max(begin, float(times[0])), min(end, float(times[-1]))
    if end <= begin:
        return frames[:0], times[:0]
    inner = (times > begin) & (times < end)
    ends = np.array([_at(frames, times, time) for time in (begin, end)])
    return (
        np.concatenate([ends[:1], frames[inner], ends[1:]]),
        np.concatenate([[begin], times[inner], [end]]),
    )


def _at(frames: Floats, times: Floats, time: float) -> Floats:
    row = int(np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(times) - 2))
    share = (time - times[row]) / max(float(times[row + 1] - times[row]), 1e-12)
    found = (1.0 - share) * frames[row] + share * frames[row + 1]
    found[:3, 2] /= np.linalg.norm(found[:3, 2])
    return found


def fine(mesh: trimesh.Trimesh, longest: float) -> trimesh.Trimesh:
    """Return a mesh with edges of a length (m) at most, and of more where it would have too many triangles."""
    return divided(mesh, max(longest, float(np.sqrt(16.0 * mesh.area / MOST_FACES))))


class FilmGrowth:
    """Film that a gun leaves on parts."""

    def __init__(self, client: Client, parts: Sequence[str], passes: Sequence[tuple[Floats, Floats]], jet: Jet) -> None:
        """Take passes as `sprayed` does, in the frame of the first part."""
        mesh = fine(part_mesh(client, parts), FINE * jet.width)
        self._passes, self._spraying = passes, Spraying(mesh, jet)
        self._rows, self._weights = mesh.faces.reshape(-1), np.repeat(mesh.area_faces, 3)
        self._areas = np.bincount(self._rows, self._weights, len(mesh.vertices))
        self.skin = mesh.vertices + OUT * mesh.vertex_normals, mesh.faces
        self.legend = Legend("Film", "µm", float(MICRO * sprayed(mesh, passes, jet).thickness.max()))

    def go(self, stretch: int, begin: float, end: float) -> Floats:
        """Spray on."""
        self._spraying.go(*between(*self._passes[stretch], begin, end))
        sums = np.bincount(self._rows, np.repeat(self._spraying.film.thickness, 3) * self._weights, len(self._areas))
        thickness = MICRO * sums / np.maximum(self._areas, 1e-300)
        return np.where(thickness > 0.0, thickness, np.nan)


class BeadGrowth:
    """Bead along ways: a tube, coloured by when it was laid."""

    def __init__(self, passes: Sequence[tuple[Floats, Floats]], radius: float, standoff: float = 0.0) -> None:
        """Lay a bead of a radius (m) along frames and times of each pass, a standoff (m) before the tool."""
        corners, faces, laid = list[Floats](), list[NDArray[np.int64]](), list[Floats]()
        self._rows, self._times = list[slice](), list[Floats]()
        count, before = 0, 0.0
        for frames, times in passes:
            rings, when = _tube(frames[:, :3, 3] + standoff * frames[:, :3, 2], times, radius)
            grid = count + np.arange(len(rings) * AROUND).reshape(len(rings), AROUND)
            beside = np.roll(grid, -1, axis=1)
            for three in ((grid[:-1], beside[:-1], beside[1:]), (grid[:-1], beside[1:], grid[1:])):
                faces.append(np.stack(three, axis=2).reshape(-1, 3))
            corners.append(rings.reshape(-1, 3))
            self._rows.append(slice(count, count + grid.size))
            self._times.append(np.repeat(when, AROUND))
            laid.append(before + self._times[-1])
            count, before = count + grid.size, before + float(times[-1])
        self.skin = np.concatenate(corners), np.concatenate(faces)
        self.legend = Legend("Bead, laid at", "s", before)
        self._laid, self._shown = np.concatenate(laid), np.full(count, np.nan)

    def go(self, stretch: int, begin: float, end: float) -> Floats:
        """Lay on."""
        rows = self._rows[stretch]
        there = (self._times[stretch] >= begin) & (self._times[stretch] <= end)
        self._shown[rows] = np.where(there, self._laid[rows], self._shown[rows])
        return self._shown


def _tube(points: Floats, times: Floats, radius: float) -> tuple[Floats, Floats]:
    """Return rings (n, AROUND, 3) about a way, which turn about it as little as can be, and when it is at each."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, lengths[-1], max(2, int(np.ceil(lengths[-1] / RING)) + 1))
    middles = np.stack([np.interp(at, lengths, points[:, axis]) for axis in range(3)], axis=1)
    along = np.gradient(middles, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    over = np.empty_like(along)
    last = np.eye(3)[np.abs(along[0]).argmin()]
    for row, direction in enumerate(along):
        last = last - (last @ direction) * direction
        last /= max(float(np.linalg.norm(last)), 1e-12)
        over[row] = last
    angles = 2.0 * np.pi * np.arange(AROUND) / AROUND
    circle = np.cos(angles)[:, None] * over[:, None] + np.sin(angles)[:, None] * np.cross(along, over)[:, None]
    return middles[:, None] + radius * circle, np.interp(at, lengths, times)


class DepthGrowth:
    """Depth under the surface of a part to which a cutter has been."""

    def __init__(
        self, client: Client, parts: Sequence[str], passes: Sequence[tuple[Floats, Floats]], cutter: Cutter
    ) -> None:
        """Take frames and times of the cutter's tip on each pass, in the frame of the first part."""
        mesh = fine(part_mesh(client, parts), 4.0 * FINE * cutter.diameter)
        self._passes, self._cutter, self._points = passes, cutter, mesh.vertices
        self._depth = np.full(len(mesh.vertices), np.nan)
        self.skin = mesh.vertices + OUT * mesh.vertex_normals, mesh.faces
        for row in range(len(passes)):
            deepest = self.go(row, -np.inf, np.inf)
        self.legend = Legend("Depth cut", "mm", float(np.nanmax(deepest, initial=0.0)))
        self._depth = np.full(len(mesh.vertices), np.nan)

    def go(self, stretch: int, begin: float, end: float) -> Floats:
        """Cut on."""
        frames, _ = between(*self._passes[stretch], begin, end)
        radius = 0.5 * self._cutter.diameter
        for before, after in pairwise(frames):
            axis, way = after[:3, 2], after[:3, 3] - before[:3, 3]
            plunge = float(way @ axis)
            flat = way - plunge * axis
            length = float(np.linalg.norm(flat))
            offset = self._points - before[:3, 3]
            over, along = offset @ axis, offset @ flat / max(length, 1e-12)
            beside = offset - over[:, None] * axis - along[:, None] * flat / max(length, 1e-12)
            # While the disc is over a corner, it goes so far.
            half = radius**2 - (beside**2).sum(axis=1)
            reach = np.sqrt(np.maximum(half, 0.0))
            last = np.clip(along + np.copysign(reach, plunge), 0.0, length) / max(length, 1e-12)
            depth = plunge * (last if length > 1e-9 else float(plunge > 0.0)) - over
            there = (half >= 0.0) & (along + reach >= 0.0) & (along - reach <= length)
            there &= (depth > 0.0) & (depth <= self._cutter.length)
            self._depth[there] = np.fmax(self._depth[there], MILLI * depth[there])
        return self._depth
