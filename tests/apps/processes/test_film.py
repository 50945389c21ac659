"""Film of a gun: thickness and spread on a plate by formula, mass at any distance and slant, and what faces away."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from virtualrobot import pose
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix
from virtualrobot_apps.processes.effects.film import Jet, Spraying, sprayed

from tests.apps.processes.slow_film import sprayed_slowly

WIDTH, STANDOFF, FLOW, SPEED = 0.2, 0.25, 2e-6, 0.4
JET = Jet(WIDTH, STANDOFF, FLOW)


def plate(size: float, step: float) -> trimesh.Trimesh:
    """Return a square plate about the z axis, 5 mm up, its normal along z, of squares in two triangles each."""
    count = int(np.ceil(size / step))
    at = np.linspace(-0.5 * size, 0.5 * size, count + 1)
    x, y = np.meshgrid(at, at, indexing="ij")
    corners = np.stack([x, y, np.full_like(x, 0.005)], axis=2).reshape(-1, 3)
    first = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    squares = np.stack([first, first + count + 1, first + count + 2, first + 1], axis=1)
    return trimesh.Trimesh(corners, np.concatenate([squares[:, [0, 1, 2]], squares[:, [0, 2, 3]]]), process=False)


def evenly(frames: Matrix) -> tuple[Matrix, Matrix]:
    """Return a pass with the times at which a gun of an even speed is at its frames."""
    steps = np.linalg.norm(np.diff(frames[:, :3, 3], axis=0), axis=1)
    return frames, np.concatenate([[0.0], np.cumsum(steps)]) / SPEED


def passes(step_over: float, reach: float, height: float = STANDOFF, count: int = 41) -> list[tuple[Matrix, Matrix]]:
    """Return passes along x, a step over apart in y, that point downward from a height over z = 0.005."""
    rows = np.arange(-reach, reach + 1e-9, step_over)
    ways = np.linspace(-reach, reach, count)
    return [evenly(np.array([pose(x, y, 0.005 + height, roll=np.pi) for x in ways])) for y in rows]


@pytest.mark.parametrize("overlap", [0.5, 0.69])
def test_the_film_on_a_plate_is_what_passes_add_up_to(overlap: float) -> None:
    """A disc's parabola that goes by leaves 8 / (3 pi r) (1 - (y / r)^2)^1.5 of the flow by speed at a distance y."""
    step_over, radius = (1.0 - overlap) * WIDTH, 0.5 * WIDTH
    mesh = plate(0.3, 0.015)
    film = sprayed(mesh, passes(step_over, 0.4), JET)
    y = mesh.triangles_center[:, 1]
    rows = np.arange(-0.4, 0.4 + 1e-9, step_over)
    share = np.maximum(1.0 - ((y[:, None] - rows) / radius) ** 2, 0.0) ** 1.5
    wanted = FLOW / SPEED * 8.0 / (3.0 * np.pi * radius) * share.sum(axis=1)
    up = mesh.face_normals[:, 2] > 0.5
    np.testing.assert_allclose(film.thickness[up], wanted[up], rtol=0.01)
    assert film.mean == pytest.approx(FLOW / SPEED / step_over, rel=0.01)
    by_formula = np.std(wanted[up]) / np.mean(wanted[up])
    assert film.spread == pytest.approx(by_formula, abs=3e-3)
    assert film.thinner(0.5 * film.mean) == 0.0 and film.thinner(2.0 * film.mean) == pytest.approx(1.0)


@pytest.mark.parametrize("height", [0.2, 0.25, 0.32])
@pytest.mark.parametrize("tilt", [0.0, 0.5])
def test_all_that_leaves_the_gun_is_on_a_plate_that_is_large(height: float, tilt: float) -> None:
    frames = np.array([pose(x, 0.0, 0.005 + height, roll=np.pi) @ pose(roll=tilt) for x in (-0.05, 0.0, 0.05)])
    film = sprayed(plate(1.0, 0.012), [evenly(frames)], JET)
    assert film.sprayed == pytest.approx(FLOW * 0.1 / SPEED)
    assert film.overspray == pytest.approx(0.0, abs=1e-3)


def test_what_faces_away_and_what_is_behind_the_gun_gets_none() -> None:
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    frames = np.array([pose(x, 0.0, 0.05 + STANDOFF, roll=np.pi) for x in (-0.2, 0.2)])
    film = sprayed(box, [evenly(frames)], JET)
    down = box.face_normals[:, 2] < -0.5
    assert not film.thickness[down].any() and film.thickness[box.face_normals[:, 2] > 0.5].all()
    assert 0.2 < film.overspray < 0.9
    away = sprayed(box, [evenly(frames @ pose(roll=np.pi))], JET)
    assert not away.thickness.any() and away.overspray == 1.0
    assert (away.mean, away.spread, away.thinner(1.0)) == (0.0, 0.0, 0.0)


def test_what_is_behind_something_gets_none() -> None:
    """A block of 20 mm, 50 mm over a plate, before a gun that stands 250 mm over it: its shadow is 250 / 190 as wide.

    Its upper face is 60 mm up. Rays go to middles of triangles, so that the shadow's rim is a triangle wide.
    """
    block = trimesh.creation.box((0.02, 0.02, 0.01))
    block.apply_translation([0.0, 0.0, 0.06])
    under = plate(0.2, 0.002)
    both = trimesh.util.concatenate([under, block])
    assert isinstance(both, trimesh.Trimesh)
    frames = np.array([pose(x, 0.0, 0.255, roll=np.pi) for x in (-1e-6, 1e-6)])
    thickness = sprayed(both, [evenly(frames)], JET).thickness[: len(under.faces)]
    reach = np.abs(under.triangles_center[:, :2]).max(axis=1)
    # The nearer face throws the wider shadow: the upper one, 190 mm from the nozzle.
    edge = 0.01 * 0.25 / 0.19
    assert not thickness[reach < edge - 1e-4].any()
    lit = (reach > edge + 2e-3) & (np.linalg.norm(under.triangles_center[:, :2], axis=1) < 0.09)
    assert lit.any() and (thickness[lit] > 0.0).all()


@pytest.mark.parametrize("body", ["ball", "bowl", "two boxes"])
def test_it_is_what_a_place_after_the_other_adds_up_to(body: str, rng: np.random.Generator) -> None:
    """Guns that lean, near and far, over bodies that throw shadows on themselves; the oracle is NumPy and trimesh."""
    if body == "two boxes":
        far = trimesh.creation.box((0.4, 0.3, 0.1), pose(z=-0.1))
        mesh = trimesh.util.concatenate([trimesh.creation.box((0.1, 0.2, 0.05), pose(z=0.05)), far])
    else:
        mesh = trimesh.creation.icosphere(3, 0.2)
        mesh.faces = mesh.faces[mesh.triangles_center[:, 2] < 0.02] if body == "bowl" else mesh.faces
    assert isinstance(mesh, trimesh.Trimesh)
    fine = mesh.subdivide_to_size(0.025, max_iter=20)
    assert isinstance(fine, trimesh.Trimesh)
    passes = []
    for _ in range(3):
        x, y, z = rng.uniform([-0.2, -0.2, 0.2], [0.2, 0.2, 0.4])
        begin = pose(x, y, z, roll=np.pi + rng.uniform(-0.5, 0.5))
        frames = np.array([begin @ pose(x=x, z=0.1 * x) for x in np.linspace(0.0, 0.3, 7)])
        passes.append((frames, np.cumsum(rng.uniform(0.0, 0.3, 7))))
    wanted, found = sprayed_slowly(fine, passes, JET), sprayed(fine, passes, JET)
    np.testing.assert_allclose(found.thickness, wanted.thickness, rtol=1e-9, atol=1e-15)
    assert found.thickness.max() > 0.0
    assert found.sprayed == pytest.approx(wanted.sprayed, rel=1e-12)
    with Spraying(fine, JET) as spraying:
        for frames, times in passes:
            for row in range(1, len(frames)):
                spraying.go(frames[row - 1 : row + 1], times[row - 1 : row + 1])
    np.testing.assert_allclose(spraying.film.thickness, wanted.thickness, rtol=1e-9, atol=1e-15)


def test_a_jet_without_width_is_refused() -> None:
    with pytest.raises(InvalidArgumentError, match="must be above 0"):
        sprayed(plate(0.1, 0.1), passes(0.1, 0.1), Jet(0.0, 0.25, 1e-6))
