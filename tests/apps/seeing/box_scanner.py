"""A range sensor of three dimensions among boxes, by formula: what its rays meet first, with noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from virtualrobot_apps.seeing.changes.scan import Floats, Scan

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Lowest and highest corner (m)."""


def met(boxes: Sequence[Box], origin: Floats, along: Floats) -> Floats:
    """Return how far rays (n, 3) of length 1 go from a place (3,) to the first box (Kay and Kajiya 1986); inf: none."""
    along = np.where(np.abs(along) < 1e-12, 1e-12, along)
    nearest = np.full(len(along), np.inf)
    for low, high in boxes:
        first, second = (np.array(low) - origin) / along, (np.array(high) - origin) / along
        near, far = np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)
        nearest = np.where((near <= far) & (near > 0.0), np.minimum(near, nearest), nearest)
    return nearest


def rays(across: float, high: float, step: float) -> Floats:
    """Return rays (n, 3) about x of a field of view (rad), so far apart (rad)."""
    u = np.arange(-0.5 * across, 0.5 * across, step)
    v = np.arange(-0.5 * high, 0.5 * high, step)
    turn, tilt = (one.ravel() for one in np.meshgrid(u, v))
    return np.column_stack([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)])


def scan_of(
    boxes: Sequence[Box], pose: Floats, along: Floats, rng: np.random.Generator, sigma: float, told: Floats
) -> Scan:
    """Return the scan from a pose (4, 4) where the robot says another one; noise has a deviation (m) along rays."""
    lengths = met(boxes, pose[:3, 3], along @ pose[:3, :3].T)
    seen = np.isfinite(lengths)
    lengths = lengths[seen] + rng.normal(0.0, sigma, int(seen.sum()))
    return Scan(along[seen] * lengths[:, None], told)


def room(wide: float, deep: float, high: float) -> list[Box]:
    """Return floor, ceiling and walls of a room whose lowest inner corner is at 0."""
    t = 0.1
    return [
        ((-t, -t, -t), (wide + t, deep + t, 0.0)),
        ((-t, -t, high), (wide + t, deep + t, high + t)),
        ((-t, -t, 0.0), (0.0, deep + t, high)),
        ((wide, -t, 0.0), (wide + t, deep + t, high)),
        ((-t, -t, 0.0), (wide + t, 0.0, high)),
        ((-t, deep, 0.0), (wide + t, deep + t, high)),
    ]
