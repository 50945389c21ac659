"""Tolerances by the laws of Rayleigh and Maxwell, and intervals of quantiles by the binomial law."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray
from virtualrobot.geometry import turn_between
from virtualrobot_apps.studies import summary
from virtualrobot_apps.studies.parameters import generator
from virtualrobot_apps.studies.tolerance import displacement, hit
from virtualrobot_apps.studies.work import Cell

Floats = NDArray[np.float64]

DRAWS = 400
FAR = 0.8
"""Distance of the target from the robot's base along x (m)."""


class Gantry:
    """World of a robot with three sliding axes, from 0 to 2 m, at (1, 2, 3), and of a target that is FAR from it.

    It touches something beyond y = 3 m of the world.
    """

    def __init__(self, far: float = FAR) -> None:
        """Put both at their places."""
        base, target = np.eye(4), np.eye(4)
        base[:3, 3] = 1.0, 2.0, 3.0
        target[:3, 3] = 1.0 + far, 2.5, 3.5
        self._begin = {"gantry": base, "part": target}
        self.restore()

    def restore(self) -> None:
        self._poses = {name: pose.copy() for name, pose in self._begin.items()}

    def place(self, node: str, pose: Floats) -> None:
        self._poses[node] = pose

    def pose(self, node: str) -> Floats:
        return self._poses[node].copy()

    parent_pose = pose

    def joint_limits(self, robot: str) -> Floats:
        return np.array([[0.0, 2.0]] * 3)

    def contacts(self, robot: str) -> list[tuple[str, str]]:
        return []

    def postures(self, robot: str, poses: Floats) -> SimpleNamespace:
        positions = (np.linalg.inv(self._poses[robot]) @ poses)[:, :3, 3]
        inside = ((positions >= 0.0) & (positions <= 2.0)).all(axis=1)
        return SimpleNamespace(
            target=np.flatnonzero(inside), positions=positions[inside], free=poses[inside, 1, 3] < 3.0, touching=()
        )

    def kinematic_errors(self, robot: str) -> SimpleNamespace:
        def poses(errors: Floats, postures: Floats) -> Floats:
            found = np.tile(np.eye(4), (len(postures), 1, 1))
            found[:, :3, 3] = postures
            return found

        return SimpleNamespace(count=24, poses=poses)


def drawn(**parameters: float) -> dict[str, Floats]:
    """Return the results of many cells, by name."""
    world, rows = Gantry(), []
    for number in range(DRAWS):
        asked = {"robot": "gantry", "target": "part", **parameters}
        rows.append(hit(Cell(number, asked, generator(5, number), world, Path("gantry.yaml"))))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def is_share(values: Floats, expected: float) -> bool:
    """Return whether a share was seen as often as it is expected, but for four deviations of a binomial."""
    return abs(values.mean() - expected) < 4.0 * math.sqrt(expected * (1.0 - expected) / len(values))


def test_where_nothing_is_off_it_hits() -> None:
    found = drawn(tolerance=1e-9, tolerance_angle=1e-9)
    assert found["hit"].all() and found["free"].all() and found["off"].max() < 1e-12


@pytest.mark.parametrize(
    "parameters", [{"joints": 1e-3}, {"part": 1e-3}, {"base": 1e-3}, {"base": 0.6e-3, "part": 0.8e-3}]
)
def test_lengths_that_are_off_in_each_direction_follow_maxwell(parameters: dict[str, float]) -> None:
    """Within two deviations erf(sqrt 2) - 2 sqrt(2 / pi) e^-2 = 0.7385; squares of deviations add up."""
    found = drawn(**parameters, tolerance=2e-3)
    assert is_share(found["hit"], math.erf(math.sqrt(2.0)) - 2.0 * math.sqrt(2.0 / math.pi) * math.exp(-2.0))
    # Maxwell's mean, 2 sqrt(2 / pi), and deviation, sqrt(3 - 8 / pi), by sigma.
    error = 1e-3 * math.sqrt(3.0 - 8.0 / math.pi) / math.sqrt(DRAWS)
    assert abs(found["off"].mean() - 2e-3 * math.sqrt(2.0 / math.pi)) < 4.0 * error
    assert found["turned"].max() < 1e-9


@pytest.mark.long
def test_a_base_that_is_turned_misses_by_its_distance() -> None:
    """At a distance L from it, by sigma L in both directions across: Rayleigh's law, 1 - e^-2 within two of these."""
    world, sigma, length = Gantry(), 1e-4, math.sqrt(FAR**2 + 0.5)
    rows = [
        hit(
            Cell(
                number,
                {"robot": "gantry", "target": "part", "base_angle": sigma, "tolerance": 2.0 * sigma * length},
                generator(6, number),
                world,
                None,
            )
        )
        for number in range(DRAWS)
    ]
    assert is_share(np.array([float(row["hit"]) for row in rows]), 1.0 - math.exp(-2.0))
    # The angle has three normal components.
    error = sigma * math.sqrt(3.0 - 8.0 / math.pi) / math.sqrt(DRAWS)
    assert abs(np.mean([row["turned"] for row in rows]) - 2.0 * sigma * math.sqrt(2.0 / math.pi)) < 4.0 * error
    angled = drawn(part_angle=1e-3, tolerance=1.0, tolerance_angle=2e-3)
    assert is_share(angled["hit"], 0.7385) and angled["off"].max() < 1e-12


def test_a_posture_that_touches_is_told() -> None:
    """The part lies half a metre before what is touched, at a normal law: 1 - Phi(0.5 / 0.4) is beyond it."""
    found = drawn(base=0.4, tolerance=9.0)
    beyond = 0.5 * (1.0 - math.erf(0.5 / 0.4 / math.sqrt(2.0)))
    assert is_share(found["free"], 1.0 - beyond)


def test_a_target_without_a_free_posture_is_told() -> None:
    cell = Cell(0, {"robot": "gantry", "target": "part", "tolerance": 1.0}, generator(1, 0), Gantry(2.5), None)
    with pytest.raises(ValueError, match="no posture of 'gantry' for 'part' is free, even where nothing is off"):
        hit(cell)


def test_a_displacement_turns_by_its_vector(rng: np.random.Generator) -> None:
    for angle in (1e-9, 1e-3, 1.0):
        moved = displacement(rng, 0.1, angle)
        assert np.abs(moved[:3, :3] @ moved[:3, :3].T - np.eye(3)).max() < 1e-14
        assert np.linalg.det(moved[:3, :3]) == pytest.approx(1.0)
    near = displacement(np.random.default_rng(1), 0.0, 1e-7)
    vector = np.random.default_rng(1).normal(size=3) * 1e-7
    assert turn_between(np.eye(4), near) == pytest.approx(float(np.linalg.norm(vector)), rel=1e-6)


def test_quantiles_have_the_intervals_of_the_binomial_law(rng: np.random.Generator) -> None:
    """The median of ten lies between the second and the ninth of them (any table of the sign test)."""
    ten = rng.permutation(np.arange(1.0, 11.0))
    assert summary.quantile_interval(ten, 0.5) == (2.0, 9.0)
    assert summary.quantile_interval(ten, 0.95) is None
    covered = 0
    for _ in range(400):
        low, high = summary.quantile_interval(rng.exponential(size=300), 0.95) or (0.0, 0.0)
        covered += low <= -math.log(0.05) <= high
    # At least 95%, since whole values are taken; four deviations of a binomial below it is too few.
    assert covered > 400 * 0.95 - 4.0 * math.sqrt(400 * 0.95 * 0.05)
    found = summary.summarize(np.arange(1000.0))
    assert found.nearly_most == pytest.approx(949.05)
    assert found.nearly_most_interval is not None
    assert found.nearly_most_interval[0] < 949.0 < found.nearly_most_interval[1]
    assert summary.summarize(np.arange(1000.0), independent=False).nearly_most_interval is None


@pytest.mark.parametrize("name", ["joints", "base", "part", "base_angle", "part_angle", "tolerance", "tolerance_angle"])
def test_what_is_below_0_is_refused(name: str) -> None:
    parameters = {"robot": "gantry", "target": "part", "tolerance": 1.0} | {name: -1e-3}
    with pytest.raises(ValueError, match=f"{name} is 0 or more, not -0.001"):
        hit(Cell(0, parameters, generator(1, 0), Gantry(0.0), None))
