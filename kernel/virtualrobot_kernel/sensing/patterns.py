"""Beams of range sensors: from a pattern to arrays, in the sensor's frame (x ahead, y left, z up)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.sensing import Fan, FreeBeams, Pattern, Raster, Ring, SingleBeam, Spinning

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Beams:
    """The n = r c beams of a pattern, row by row.

    Attributes:
        shape: (r, c) of a reading.
        origins: (n, 3) where they begin, or (1, 3) where all begin at one place; meters.
        directions: (n, 3) unit vectors.
        before_end: (c,) which part of a turn before the end of a reading each column is measured, where the sensor
            turns or scans; 0 for the last.
    """

    shape: tuple[int, int]
    origins: Floats
    directions: Floats
    before_end: Floats


def beams_of(pattern: Pattern) -> Beams:
    """Return the beams of a pattern."""
    match pattern:
        case SingleBeam():
            return _about_origin(np.zeros(1), np.zeros(1))
        case Fan(count, start, end):
            azimuth = np.linspace(start, end, count)
            return _about_origin(azimuth, np.zeros(1), np.abs(end - azimuth) / (2.0 * np.pi))
        case Spinning(columns, elevations):
            azimuth = 2.0 * np.pi / columns * np.arange(columns, dtype=np.float64) - np.pi
            return _about_origin(azimuth, np.array(elevations, np.float64))
        case Raster(columns, rows, across, upright):
            azimuth, elevation = _middle_out(columns, across), _middle_out(rows, upright)
            return _about_origin(azimuth, elevation)
        case Ring(count, radius, start, end):
            beams = _about_origin(np.linspace(start, end, count), np.zeros(1))
            return Beams(beams.shape, radius * beams.directions, beams.directions, beams.before_end)
        case FreeBeams(directions, origins):
            n = len(directions)
            # The square of a very long one would be too large for a number.
            unit = directions / np.abs(directions).max(axis=1, keepdims=True)
            unit /= np.linalg.norm(unit, axis=1, keepdims=True)
            return Beams((1, n), np.zeros((1, 3)) if origins is None else origins, unit, _evenly(n))
    raise AssertionError(pattern)


def rays_of(directions: Floats, beam: Floats) -> Floats:
    """Return the rays of beams: `directions` (n, 3) of the beams, `beam` (k, 3) the rays of one about x; (n, k, 3).

    Each beam's frame has x along it, y level and z upwards; straight up and down, y is the sensor's y.
    """
    level = np.column_stack((-directions[:, 1], directions[:, 0], np.zeros(len(directions))))
    length = np.linalg.norm(level, axis=1, keepdims=True)
    left = np.where(length > 1e-9, level / np.maximum(length, 1e-9), (0.0, 1.0, 0.0))
    frames = np.stack((directions, left, np.cross(directions, left)), axis=2)  # (n, 3, 3), columns x, y, z
    rays = np.einsum("nij,kj->nki", frames, beam)
    return rays / np.linalg.norm(rays, axis=2, keepdims=True)


def _about_origin(azimuth: Floats, elevation: Floats, before_end: Floats | None = None) -> Beams:
    """Return beams from the origin: a row for each elevation (r,), a column for each azimuth (c,)."""
    flat = np.cos(elevation)[:, None]
    parts = np.broadcast_arrays(flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)[:, None])
    shape = len(elevation), len(azimuth)
    directions = np.stack(parts, axis=2).reshape(-1, 3)
    return Beams(shape, np.zeros((1, 3)), directions, _evenly(len(azimuth)) if before_end is None else before_end)


def _middle_out(count: int, field: float) -> Floats:
    """Return the angles of `count` beams over `field`, the first at its positive end; a single one is in the middle."""
    return np.linspace(field / 2.0, -field / 2.0, count) if count > 1 else np.zeros(1)


def _evenly(columns: int) -> Floats:
    return np.arange(columns - 1, -1, -1) / columns
