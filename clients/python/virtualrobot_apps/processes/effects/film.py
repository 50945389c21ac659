"""Film of paint that guns leave on a surface: how thick it is on each triangle, how even, and what goes beside it.

A gun's jet is a cone. In a plane across it the paint falls on a disc, as a parabola over its diameter: most in the
middle, nothing at the rim. Where a triangle is nearer or farther than the standoff, the disc is as much smaller or
larger, and a triangle at a slant takes as much less as it is slanted against the ray: so all that leaves the gun
arrives somewhere. What faces away from the gun gets none, and neither does what is behind something else: a ray goes to
the middle of each triangle.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from itertools import pairwise

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import KDTree
from virtualrobot.errors import InvalidArgumentError, WrongStateError

Floats = NDArray[np.float64]

GRAZE = 1e-3
"""Part of a ray's length before its end from which on what is met is what it goes to."""
SAMPLES = 8
"""Places of a gun on its way while it goes by a radius of its disc."""


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


def sprayed(mesh: trimesh.Trimesh, passes: list[tuple[Floats, Floats]], jet: Jet) -> Film:
    """Return the film that a gun leaves on a mesh (m).

    Triangles have one thickness each: of those that are large beside the disc it is that in their middle.

    Args:
        mesh: open or closed, its normals outward.
        passes: frames (n, 4, 4) of the gun's tip, z along the jet, at the distance `standoff` before it from its disc,
            and when it is there (n,) in s, of each pass.
        jet: what leaves the gun.

    Raises:
        InvalidArgumentError: for a jet without width, standoff or flow, and for times that run back.
        WrongStateError: where embreex, by which rays are traced, is not installed.
    """
    if find_spec("embreex") is None:
        raise WrongStateError("films need embreex: pip install 'virtualrobot[processes]'")
    if min(jet.width, jet.standoff, jet.flow) <= 0.0:
        raise InvalidArgumentError("width, standoff and flow of a jet must be above 0")
    if any(np.diff(times).min(initial=0.0) < 0.0 for _, times in passes):
        raise InvalidArgumentError("the times of a gun on its way must not run back")
    centres, normals, areas = mesh.triangles_center, mesh.face_normals, mesh.area_faces
    tree, thickness, volume = KDTree(centres), np.zeros(len(areas)), 0.0
    slope = 0.5 * jet.width / jet.standoff
    # What is deeper than twice the standoff gets a quarter at most; it counts up to there, in a ball about that cone.
    deepest = 2.0 * jet.standoff
    middle = min(0.5 * deepest * (1.0 + slope**2), deepest)
    ball = max(middle, np.hypot(deepest - middle, slope * deepest))
    for frames, times in passes:
        places, seconds = _places(frames, times, 0.5 * jet.width / SAMPLES)
        for place, time in zip(places, seconds, strict=True):
            volume += jet.flow * time
            near = np.array(tree.query_ball_point(place[:3, 3] + middle * place[:3, 2], ball), np.int64)
            if not len(near):
                continue
            rays = centres[near] - place[:3, 3]
            depth = rays @ place[:3, 2]
            facing = -np.einsum("ij,ij->i", rays, normals[near])
            radius = slope * np.maximum(depth, 1e-9)
            off = np.linalg.norm(rays - depth[:, None] * place[:3, 2], axis=1) / radius
            hit = (depth > 1e-3 * jet.standoff) & (depth < deepest) & (facing > 0.0) & (off < 1.0)
            hit[hit] = _is_seen(mesh, place[:3, 3], rays[hit])
            share = 2.0 / (np.pi * radius[hit] ** 2) * (1.0 - off[hit] ** 2)
            # Of a plane across the jet's axis a triangle takes as much more as it faces the ray than that plane does.
            thickness[near[hit]] += jet.flow * time * share * facing[hit] / depth[hit]
    return Film(thickness, areas, volume)


def _is_seen(mesh: trimesh.Trimesh, origin: Floats, rays: Floats) -> NDArray[np.bool_]:
    """Return whether nothing of a mesh is before the ends of rays (m, 3) from an origin: (m,)."""
    if not len(rays):
        return np.empty(0, np.bool_)
    lengths = np.linalg.norm(rays, axis=1)
    first = mesh.ray.intersects_first(np.tile(origin, (len(rays), 1)), rays / lengths[:, None])
    normals, corners = mesh.face_normals[first], mesh.triangles[first, 0]
    share = np.einsum("ij,ij->i", corners - origin, normals) / np.einsum("ij,ij->i", rays, normals)
    return (first < 0) | (share > 1.0 - GRAZE)


def _places(frames: Floats, times: Floats, step: float) -> tuple[Floats, Floats]:
    """Return frames (m, 4, 4), at most a step (m) apart, along others, and how long each one stands for (s)."""
    found, seconds = list[Floats](), list[float]()
    for (before, after), duration in zip(pairwise(frames), np.diff(times).tolist(), strict=True):
        length = float(np.linalg.norm(after[:3, 3] - before[:3, 3]))
        count = max(1, int(np.ceil(length / step)))
        for share in (np.arange(count) + 0.5) / count:
            place = (1.0 - share) * before + share * after
            place[:3, 2] /= np.linalg.norm(place[:3, 2])
            found.append(place)
            seconds.append(duration / count)
    return np.array(found).reshape(-1, 4, 4), np.array(seconds)
