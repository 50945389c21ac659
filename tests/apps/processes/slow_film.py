"""Film of a gun as NumPy and trimesh tell it, a place of the gun after the other: the oracle of the compiled one."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import KDTree
from virtualrobot_apps.processes.effects.film import GRAZE, SAMPLES, Film, Floats, Jet


def sprayed_slowly(mesh: trimesh.Trimesh, passes: list[tuple[Floats, Floats]], jet: Jet) -> Film:
    """Return the film that a gun leaves on a mesh (m), as `sprayed` does."""
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
