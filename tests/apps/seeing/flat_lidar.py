"""A lidar in the plane among boxes, by formula: what its rays meet first, and scans of that."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from virtualrobot_apps.seeing.navigation.floors import Box
from virtualrobot_apps.seeing.navigation.matching import normals_of
from virtualrobot_apps.seeing.navigation.poses import Floats
from virtualrobot_apps.seeing.navigation.scans import Scan

COUNT, REACH = 360, 3.5
"""Rays of a turn and how far they see (m): those of the LDS-01."""


def distances(boxes: Sequence[Box], pose: Floats) -> Floats:
    """Return how far rays (COUNT,) from a pose go to the first box (slabs, Kay and Kajiya 1986); inf: none."""
    angles = pose[2] + np.arange(COUNT) * 2.0 * np.pi / COUNT
    along = np.column_stack([np.cos(angles), np.sin(angles)])
    along = np.where(np.abs(along) < 1e-12, 1e-12, along)[:, None]
    middles = np.array([(box.x, box.y) for box in boxes]) - pose[:2]
    halves = 0.5 * np.array([(box.wide, box.deep) for box in boxes])
    first, second = (middles - halves) / along, (middles + halves) / along
    near, far = np.minimum(first, second).max(axis=2), np.maximum(first, second).min(axis=2)
    met = np.where((near <= far) & (near > 0.0), near, np.inf).min(axis=1)
    return np.where(met <= REACH, met, np.inf)


def scan_at(
    boxes: Sequence[Box],
    pose: Floats,
    odometry: Floats | None = None,
    rng: np.random.Generator | None = None,
    time: float = 0.0,
) -> Scan:
    """Return the scan from a pose; with `rng` with the noise of the LDS-01: 5 mm and 1.75% of the distance."""
    lengths = distances(boxes, pose)
    seen = np.isfinite(lengths)
    if rng is not None:
        lengths = lengths + rng.normal(size=COUNT) * np.hypot(0.005, 0.0175 * np.where(seen, lengths, 0.0))
    angles = np.arange(COUNT) * 2.0 * np.pi / COUNT
    along = np.column_stack([np.cos(angles), np.sin(angles)])
    points = along[seen] * lengths[seen, None]
    normals = normals_of(points, np.zeros(2))
    return Scan(time, points, normals, along[~seen] * REACH, np.zeros(2), pose if odometry is None else odometry)
