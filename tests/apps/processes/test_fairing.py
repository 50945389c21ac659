"""Fair ways on meshes: curvatures of the surface that triangles stand for, within a chord of them."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_apps.curves.way import Way
from virtualrobot_apps.demos.processes import workpieces
from virtualrobot_apps.processes.sources.fairing import TURN, fair
from virtualrobot_apps.processes.sources.frames import tool_frames
from virtualrobot_apps.processes.sources.raster import raster
from virtualrobot_apps.processes.sources.sampling import sampled

CHORD, STEP = 1e-4, 5e-3


def turning(way: Way) -> np.ndarray:
    """Return by how much the tool turns from frame to frame (rad/m)."""
    axes = tool_frames(way)[:, :3, 2]
    angles = np.linalg.norm(np.diff(axes, axis=0), axis=1)
    return angles / np.linalg.norm(np.diff(way.points, axis=0), axis=1)


def test_a_tool_over_triangles_turns_as_over_the_surface() -> None:
    """On a hood of radii 0.9 and 1.2 m ways along y bend by 1 / 1.2 rad/m in the middle, evenly."""
    way = raster(workpieces.hood(), 0.1, [0, 1, 0], axis=[0, 0, -1], lead_in=0.08, lead_out=0.08)[2]
    here = np.abs(way.points[:-1, 1]) < 0.2
    turns = turning(way)[here]
    np.testing.assert_allclose(turns, 1.0 / 1.2, rtol=0.12)
    # Onto the hood it bends little by little: 0.83 rad/m come on no less than ten steps.
    assert np.abs(np.diff(turning(way))).max() < 0.083
    x, y, z = way.points[np.abs(way.points[:, 1]) < 0.3].T
    assert np.abs(z + x**2 / 1.8 + y**2 / 2.4).max() < CHORD + 5e-5


def test_what_is_fair_stays_within_the_chord_of_what_was_given(rng: np.random.Generator) -> None:
    at = np.arange(0.0, 0.5, 4e-3)
    points = np.stack([at, 0.1 * np.sin(6.0 * at), rng.normal(0.0, 1e-5, len(at))], axis=1)
    way = Way(points, np.tile([0.0, 0.0, 1.0], (len(at), 1, 1)))
    found = fair(way, CHORD, STEP)
    near = np.linalg.norm(points[:, None] - found.points[None], axis=2).min(axis=1)
    assert near.max() <= CHORD + 0.5 * STEP
    assert np.ptp(found.points[:, 2]) < 0.5 * np.ptp(points[:, 2])
    steps = np.linalg.norm(np.diff(found.points, axis=0), axis=1)
    assert steps.max() <= STEP * 1.001 and np.ptp(steps) < 1e-5


def test_loops_stay_loops_and_a_circle_itself() -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 101)
    out = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    found = fair(Way(0.1 * out, out[:, None], True), CHORD, STEP)
    assert found.closed and (found.points[0] == found.points[-1]).all()
    np.testing.assert_allclose(np.linalg.norm(found.points, axis=1), 0.1, atol=CHORD)
    np.testing.assert_allclose(found.outward, found.points / 0.1, atol=TURN)


def test_a_corner_stays_within_the_chord() -> None:
    at = np.arange(0.0, 0.101, 5e-3)
    points = np.concatenate([np.stack([at, 0 * at, 0 * at], axis=1), np.stack([0 * at + 0.1, at, 0 * at], axis=1)[1:]])
    way = Way(points, np.tile([0.0, 0.0, 1.0], (len(points), 1, 1)))
    assert np.linalg.norm(fair(way, CHORD, STEP).points - [0.1, 0.0, 0.0], axis=1).min() < 2 * CHORD
    short = sampled(Way(points[:3], way.normals[:3]), CHORD, 1.0)
    assert fair(short, CHORD, STEP) is short


@pytest.mark.parametrize("direction", [[0, 1, 0], [1, 0, 0]])
def test_ends_of_ways_stay(direction: list[float]) -> None:
    ways = raster(workpieces.hood(), 0.1, direction, axis=[0, 0, -1])
    ends = np.abs(np.concatenate([way.points[[0, -1]] @ direction for way in ways]))
    np.testing.assert_allclose(ends, 0.3 if direction[1] else 0.25, atol=1e-4)
