"""The parts of the mapping application: octree, Bayes grid, surfaces by rays; against formulas."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot_apps.demos.mapping import map_cell, octree_map
from virtualrobot_apps.demos.mapping.bayes_grid import BayesGrid, Cone
from virtualrobot_apps.demos.mapping.surface_truth import (
    TOLERANCE,
    compare,
    points_in_voxels,
    seen_from,
    surface_points,
)

BOX = np.array([[0.213, 0.107, 0.011], [0.487, 0.403, 0.319]])
CENTER, RADIUS = np.array([0.71, 0.72, 0.23]), 0.173
LOW, HIGH = np.zeros(3), np.ones(3)


def cast(origins: np.ndarray, directions: np.ndarray, max_range: float) -> tuple[np.ndarray, np.ndarray]:
    """Return how far rays go until a box (slabs) or a sphere (quadratic), from outside or inside."""
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = np.sort((BOX[:, None] - origins) / directions, axis=0)
    enter, leave = np.nanmax(sides[0], axis=1), np.nanmin(sides[1], axis=1)
    beside = (((origins < BOX[0]) | (origins > BOX[1])) & (directions == 0.0)).any(axis=1)
    box = np.where((leave >= enter) & (leave > 0.0) & ~beside, np.where(enter > 0.0, enter, leave), np.inf)
    away = origins - CENTER
    half = (away * directions).sum(axis=1)
    root = half**2 - (away**2).sum(axis=1) + RADIUS**2
    near, far = -half - np.sqrt(np.maximum(root, 0.0)), -half + np.sqrt(np.maximum(root, 0.0))
    sphere = np.where((root > 0.0) & (far > 0.0), np.where(near > 0.0, near, far), np.inf)
    distance = np.minimum(box, sphere)
    return np.where(distance <= max_range, distance, np.inf), np.ones(len(distance), np.bool_)


def test_surfaces_are_found_whole_and_nothing_else() -> None:
    spacing = 0.01
    points = surface_points(cast, LOW, HIGH, spacing)
    on_box = np.abs(np.clip(points, *BOX) - points).max(axis=1) < 1e-9
    depth = np.minimum(points - BOX[0], BOX[1] - points).min(axis=1)
    on_sphere = np.abs(np.linalg.norm(points - CENTER, axis=1) - RADIUS) < 1e-6
    assert ((on_box & (np.abs(depth) < 1e-6)) | on_sphere).all()
    # Front and back along each axis, both ways: twice the shadow on each side of each axis, four times in all.
    shadows = [np.prod(np.delete(BOX[1] - BOX[0], axis)) + math.pi * RADIUS**2 for axis in range(3)]
    assert len(points) * spacing**2 == pytest.approx(4.0 * sum(shadows), rel=0.03)


def test_finer_rays_find_what_a_voxel_holds() -> None:
    points = points_in_voxels(cast, np.array([[4, 4, 2]]), 0.1)  # x and y of the box end in it at 0.487 and 0.403
    assert len(points) and (np.abs(points[:, 0] - 0.487) < 1e-9).sum() == 20  # one row of 20 is below y = 0.403
    assert not len(points_in_voxels(cast, np.array([[9, 0, 9]]), 0.1))


def test_what_is_behind_something_is_not_seen() -> None:
    points = np.array([[0.213, 0.25, 0.1], [0.487, 0.25, 0.1]])  # the box from both sides
    assert seen_from(cast, points, np.array([-1.0, 0.25, 0.1])).tolist() == [True, False]
    assert seen_from(cast, points, np.array([2.0, 0.25, 0.1])).tolist() == [False, True]


def scan(origin: np.ndarray, rng: np.random.Generator, count: int) -> np.ndarray:
    """Return the echoes of random beams from a place."""
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    distance, _ = cast(np.tile(origin, (count, 1)), directions, 5.0)
    hit = np.isfinite(distance)
    return origin + distance[hit, None] * directions[hit]


@pytest.mark.parametrize("resolution", [0.04, 0.05, 0.1])
def test_a_map_of_true_echoes_is_true(resolution: float, rng: np.random.Generator) -> None:
    """An exact echo is on a surface, and its voxel is the one that holds it, or shares a side that it lies on."""
    grown = octree_map.OctreeMap(resolution)
    beams = round(200.0 / resolution**2)  # as many for each voxel; with too few, some of what is seen has no echo
    points = surface_points(cast, LOW, HIGH, 0.5 * resolution)
    visible = np.zeros(len(points), np.bool_)
    for origin in rng.uniform([-0.3, -0.3, 0.6], [1.3, 1.3, 1.2], (6, 3)):
        grown.insert(scan(origin, rng, beams), origin)
        visible |= seen_from(cast, points, origin)
    keys, odds = grown.voxels(LOW, HIGH)
    result = compare(cast, keys[odds > 0.0], resolution, points, visible)
    assert result.occupied > 50 and result.false_rate == 0.0, result
    assert 0.0 <= result.missed_rate < 0.35, result
    # Voxels that are moved aside by two of their edges are hardly on surfaces.
    aside = compare(cast, keys[odds > 0.0] + [0, 0, 2 + int(0.4 / resolution)], resolution, points, visible)
    assert aside.false_rate > 0.5 and aside.missed_rate > 0.5


def test_nothing_mapped_is_all_missed() -> None:
    points = surface_points(cast, LOW, HIGH, 0.05)
    result = compare(cast, np.empty((0, 3), np.int64), 0.1, points, np.ones(len(points), np.bool_))
    assert (result.occupied, result.false_rate, result.missed_rate) == (0, 0.0, 1.0)


def test_voxels_of_an_octree_are_told_one_by_one(tmp_path: Path) -> None:
    """One echo at x = 1.01 seen from 0.01: log(0.7 / 0.3) for its voxel, log(0.4 / 0.6) for those before it."""
    grown = octree_map.OctreeMap(0.1)
    origin = np.array([0.01, 0.05, 0.05])
    grown.insert([[1.01, 0.05, 0.05]], origin)
    keys, odds = grown.voxels([-0.5, -0.5, -0.5], [2.0, 0.5, 0.5])
    found = {tuple(key): value for key, value in zip(keys.tolist(), odds.tolist(), strict=True)}
    assert found[10, 0, 0] == pytest.approx(math.log(0.7 / 0.3), abs=1e-6)
    assert found.keys() == {(x, 0, 0) for x in range(11)}
    assert all(found[x, 0, 0] == pytest.approx(math.log(0.4 / 0.6), abs=1e-6) for x in range(10))
    # Eight voxels that are alike become one in the octree, and are told as eight again.
    corners = np.array([[x, y, z] for x in (0.05, 0.15) for y in (0.05, 0.15) for z in (0.05, 0.15)]) + 1.6
    full = octree_map.OctreeMap(0.1)
    for _ in range(12):
        full.insert(corners, corners.mean(axis=0) + 1e-3)
    keys, odds = full.voxels([1.6, 1.6, 1.6], [1.8, 1.8, 1.8])
    assert sorted(map(tuple, keys.tolist())) == [(x, y, z) for x in (16, 17) for y in (16, 17) for z in (16, 17)]
    assert len(full.voxels([1.6, 1.6, 1.6], [1.7, 1.8, 1.8])[0]) == 4
    for name in ("map.bt", "map.ot"):
        grown.save(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 20


def test_one_ultrasonic_reading_by_the_formula() -> None:
    """Moravec and Elfes' profiles at the axis: empty before the echo, occupied at it, unknown behind and beside."""
    cone, reading = Cone(half_angle=0.3, error=0.1, certainty=0.8), 1.0
    grid = BayesGrid([0.0, -0.5, -0.5], [2.0, 0.5, 0.5], 0.1)
    grid.update([0.0, 0.05, 0.05], [1.0, 0.0, 0.0], reading, cone)
    keys, odds = grid.voxels()
    found = {tuple(key): value for key, value in zip(keys.tolist(), odds.tolist(), strict=True)}

    def logit(p: float) -> float:
        return math.log(p / (1.0 - p))

    for key in range(8):  # at 0.05 to 0.75 m
        distance = 0.1 * key + 0.05
        assert found[key, 0, 0] == pytest.approx(logit(0.5 * (1.0 - 0.8 * (1.0 - (distance / 0.9) ** 2))))
    for key in (9, 10):  # at 0.95 and 1.05 m
        distance = 0.1 * key + 0.05
        assert found[key, 0, 0] == pytest.approx(logit(0.5 * (1.0 + 0.8 * (1.0 - ((distance - 1.0) / 0.1) ** 2))))
    beside = math.hypot(0.95, 0.2), math.atan2(0.2, 0.95)
    p = 0.5 * (1.0 + 0.8 * (1.0 - ((beside[0] - 1.0) / 0.1) ** 2) * (1.0 - (beside[1] / 0.3) ** 2))
    assert found[9, 2, 0] == pytest.approx(logit(p))
    assert (11, 0, 0) not in found and (9, 4, 0) not in found and (0, 1, 0) not in found
    # Readings are independent: two add up, and many stay learnable.
    grid.update([0.0, 0.05, 0.05], [1.0, 0.0, 0.0], reading, cone)
    keys, twice = grid.voxels()
    np.testing.assert_allclose(twice, 2.0 * odds)
    for _ in range(100):
        grid.update([0.0, 0.05, 0.05], [1.0, 0.0, 0.0], reading, cone)
    assert np.abs(grid.log_odds).max() == 8.0


def test_points_on_a_side_belong_to_both_voxels() -> None:
    """A wall on the side between two voxels: an echo that single precision puts before or behind it is no error."""

    def wall(origins: np.ndarray, directions: np.ndarray, max_range: float) -> tuple[np.ndarray, np.ndarray]:
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (0.5 - origins[:, 0]) / directions[:, 0]
        ahead = (distance > 0.0) & (distance <= max_range)
        return np.where(ahead, distance, np.inf), np.ones(len(distance), np.bool_)

    points = surface_points(wall, LOW, HIGH, 0.05)
    for side in (-TOLERANCE / 2, TOLERANCE / 2):
        keys = np.unique(octree_map.keys_of(points + np.array([side, 0.0, 0.0]), 0.1), axis=0)
        result = compare(wall, keys, 0.1, points, np.ones(len(points), np.bool_))
        assert (result.false_rate, result.missed) == (0.0, 0)


def test_voxels_outside_of_the_cell_have_colours_too() -> None:
    """The noise of a sensor puts some below the floor or above the walls."""
    colors = map_cell.colors_of(
        np.array([map_cell.LOW[2] - 0.1, map_cell.LOW[2], map_cell.HIGH[2], map_cell.HIGH[2] + 0.1])
    )
    assert ((colors >= 0.0) & (colors <= 1.0)).all()
    assert (colors[0] == colors[1]).all() and (colors[2] == colors[3]).all() and (colors[1] != colors[2]).any()


def test_a_package_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyoctomap", None)
    with pytest.raises(virtualrobot.WrongStateError, match=r"pip install 'virtualrobot\[mapping\]'"):
        octree_map.OctreeMap(0.1)
