"""Film of paint that guns leave on a surface: how thick it is on each triangle, how even, and what goes beside it.

A gun's jet is a cone. In a plane across it the paint falls on a disc, as a parabola over its diameter: most in the
middle, nothing at the rim. Where a triangle is nearer or farther than the standoff, the disc is as much smaller or
larger, and a triangle at a slant takes as much less as it is slanted against the ray: so all that leaves the gun
arrives somewhere. What faces away from the gun gets none, and neither does what is behind something else: a ray goes to
the middle of each triangle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError, WrongStateError
from virtualrobot_sdk.embree import TopScene, unavailable
from virtualrobot_sdk.rays import make_shape

from virtualrobot_apps.processes.effects.spraying import add, cells_of, meet

Floats = NDArray[np.float64]

GRAZE = 1e-3
"""Part of a ray's length before its end from which on what is met is what it goes to."""
SAMPLES = 8
"""Places of a gun on its way while it goes by a radius of its disc."""
AT_ONCE = 1 << 18
"""Triangles whose rays are traced at once, at least."""
CELLS = 4.0
"""Cells of the grid of triangles in a diameter of the disc."""
NEAREST, DEEPEST = 1e-3, 2.0
"""Distances, in standoffs, between which paint counts: what is deeper gets a quarter at most."""


@dataclass(frozen=True, slots=True)
class Jet:
    """Jet of a gun.

    Attributes:
        width: the diameter (m) of its disc at the standoff.
        standoff: the distance (m) of the nozzle from the surface that it is for.
        flow: the volume of solids that leaves it (m^3/s).
    """

    width: float
    standoff: float
    flow: float


@dataclass(frozen=True, slots=True, eq=False)
class Film:
    """Film on the triangles of a mesh.

    Attributes:
        thickness: (f,) in m.
        areas: (f,) of the triangles (m^2).
        sprayed: the volume of solids that left the gun (m^3).
    """

    thickness: Floats
    areas: Floats
    sprayed: float

    @property
    def mean(self) -> float:
        """Mean thickness (m) by area, where there is any."""
        there = self.thickness > 0.0
        return float(np.average(self.thickness[there], weights=self.areas[there])) if there.any() else 0.0

    @property
    def spread(self) -> float:
        """Standard deviation of the thickness by area, where there is any, in parts of the mean."""
        there = self.thickness > 0.0
        if not there.any():
            return 0.0
        squares = np.average((self.thickness[there] - self.mean) ** 2, weights=self.areas[there])
        return float(np.sqrt(squares)) / self.mean

    @property
    def overspray(self) -> float:
        """Part of what was sprayed that is not on the mesh."""
        return 1.0 - float(self.thickness @ self.areas) / self.sprayed

    def thinner(self, least: float) -> float:
        """Return the part of the area, of what has any film, that has less of it than `least` (m)."""
        there = self.thickness > 0.0
        thin = there & (self.thickness < least)
        return float(self.areas[thin].sum() / self.areas[there].sum()) if there.any() else 0.0


def sprayed(mesh: trimesh.Trimesh, passes: Sequence[tuple[Floats, Floats]], jet: Jet) -> Film:
    """Return the film that a gun leaves on a mesh (m).

    Triangles have one thickness each: of those that are large beside the disc it is that in their middle.

    Args:
        mesh: open or closed, its normals outward.
        passes: frames (n, 4, 4) of the gun's tip, z along the jet, at the distance `standoff` before it from its disc,
            and when it is there (n,) in s, of each pass.
        jet: what leaves the gun.

    Raises:
        InvalidArgumentError: for a jet without width, standoff or flow, and for times that run back.
        WrongStateError: where Embree, by which rays are traced, is not installed.
    """
    with Spraying(mesh, jet) as spraying:
        for frames, times in passes:
            spraying.go(frames, times)
        return spraying.film


class Spraying:
    """Film that grows on a mesh; a context manager, which frees the rays."""

    def __init__(self, mesh: trimesh.Trimesh, jet: Jet) -> None:
        """Begin with a bare mesh; raises as `sprayed` does."""
        if reason := unavailable():
            raise WrongStateError(f"films need Embree: {reason} (pip install 'virtualrobot[processes]')")
        if min(jet.width, jet.standoff, jet.flow) <= 0.0:
            raise InvalidArgumentError("width, standoff and flow of a jet must be above 0")
        self._jet = jet
        self.film = Film(np.zeros(len(mesh.faces)), mesh.area_faces, 0.0)
        self._edge = jet.width / CELLS
        self._triangles = np.ascontiguousarray(mesh.triangles_center), np.ascontiguousarray(mesh.face_normals)
        self._cells = cells_of(self._triangles[0], self._edge)
        self._scene = TopScene()
        self._scene.place((make_shape(mesh.vertices, mesh.faces),), np.eye(4)[None])
        room = max(AT_ONCE, len(mesh.faces))
        self._met, self._thickness = np.empty(room, np.int64), np.empty(room)
        self._eyes, self._rays = np.empty((room, 3), np.float32), np.empty((room, 3), np.float32)
        self._lengths = np.empty(room, np.float32)

    def __enter__(self) -> Spraying:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Free the rays."""
        self._scene.close()

    def go(self, frames: Floats, times: Floats) -> None:
        """Add what a gun leaves on its way along frames (n, 4, 4) at times (n,); raises for times that run back."""
        if np.diff(times).min(initial=0.0) < 0.0:
            raise InvalidArgumentError("the times of a gun on its way must not run back")
        jet = self._jet
        places, seconds = _places(frames, times, 0.5 * jet.width / SAMPLES)
        volumes, slope, row = jet.flow * seconds, 0.5 * jet.width / jet.standoff, 0
        while row < len(places):
            count, row = meet(
                *(places, volumes, row, *self._triangles, *self._cells, self._edge, slope),
                *(NEAREST * jet.standoff, DEEPEST * jet.standoff),
                *(self._met, self._thickness, self._eyes, self._rays, self._lengths),
            )
            ends = np.float32(1.0 - GRAZE) * self._lengths[:count]
            hidden = self._scene.occluded(self._eyes[:count], self._rays[:count], ends)
            add(self.film.thickness, count, self._met, self._thickness, hidden)
        self.film = Film(self.film.thickness, self.film.areas, self.film.sprayed + float(volumes.sum()))


def _places(frames: Floats, times: Floats, step: float) -> tuple[Floats, Floats]:
    """Return frames (m, 4, 4), at most a step (m) apart, along others, and how long each one stands for (s)."""
    if len(frames) < 2:
        return np.empty((0, 4, 4)), np.empty(0)
    lengths = np.linalg.norm(np.diff(frames[:, :3, 3], axis=0), axis=1)
    counts = np.maximum(1, np.ceil(lengths / step)).astype(np.int64)
    rows = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
    shares = ((within + 0.5) / counts[rows])[:, None, None]
    places = (1.0 - shares) * frames[rows] + shares * frames[rows + 1]
    places[:, :3, 2] /= np.linalg.norm(places[:, :3, 2], axis=1, keepdims=True)
    return places, (np.diff(times) / counts)[rows]
