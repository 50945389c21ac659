"""The search of a ladder against all ways, by a table of every step in plain Python."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray
from virtualrobot_kernel.numeric.ladder import cheapest_way, turns_of

Floats = NDArray[np.float64]
TURN = 2.0 * np.pi
LIMITS = np.array([[-3.0, -5.0, -7.0], [3.0, 5.5, 7.5]])


def ladder(seed: int, rungs: int = 9, combinations: int = 4, branches: int = 2) -> dict[str, NDArray]:
    """Return a ladder of three joints that go on from rung to rung, more or less; a tenth of it is missing."""
    rng = np.random.default_rng(seed)
    q = np.cumsum(rng.normal(0.0, 0.6, (rungs, combinations, branches, 3)), axis=0)
    q += rng.uniform(-1.5, 1.5, (1, 1, branches, 3))
    q = q - TURN * np.round(q / TURN)
    q[rng.random(q.shape[:3]) < 0.1] = np.nan
    places = np.arange(combinations)[:, None] + (-1, 0, 1)
    return {
        "q": q,
        "wrist": rng.uniform(0.1, 1.0, q.shape[:3]),
        "blocked": (rng.random(q.shape[:3]) < 0.05).astype(np.int8),
        "limits": LIMITS,
        "most": rng.uniform(1.5, 2.8, (rungs - 1, 3)),
        "neighbours": np.where((places >= 0) & (places < combinations), places, -1),
        "changes": np.array([0.1, 0.0, 0.1]),
        "wish": rng.uniform(0.0, 0.1, combinations),
    }


def searched(given: dict[str, NDArray]) -> tuple[int, NDArray[np.int64], Floats]:
    n, g, b, k = given["q"].shape
    back = np.empty((n, g * b * int(np.prod(turns_of(given["limits"])))), np.int32)
    way, joints = np.zeros((n, 2), np.int64), np.zeros((n, k))
    return cheapest_way(*given.values(), back, way, joints), way, joints


def postures(given: dict[str, NDArray], rung: int) -> list[tuple[int, int, tuple[float, ...]]]:
    """Return all postures on a rung, each joint at each turn that its limits allow."""
    found = []
    for g, b in np.ndindex(given["q"].shape[1:3]):
        q = given["q"][rung, g, b]
        if given["blocked"][rung, g, b] or np.isnan(q).any():
            continue
        at = [
            [v + TURN * t for t in range(-2, 3) if lo <= v + TURN * t <= hi]
            for v, lo, hi in zip(q, *LIMITS, strict=True)
        ]
        found += [(g, b, turned) for turned in product(*at)]
    return found


def step_cost(given: dict[str, NDArray], rung: int, one: tuple, other: tuple) -> float:
    """Return what it costs to come from a posture to one on a rung; inf where that can't be."""
    if one[1] != other[1] or abs(one[0] - other[0]) > 1:
        return np.inf
    shares = np.abs(np.subtract(one[2], other[2])) / given["most"][rung - 1]
    return np.inf if shares.max() > 1.0 else float((shares**2).sum()) + 0.1 * abs(one[0] - other[0])


def own_cost(given: dict[str, NDArray], rung: int, one: tuple) -> float:
    """Return what a posture costs, by the formula of the search."""
    lower, upper = LIMITS
    near = 0.2 * (((2.0 * np.array(one[2]) - lower - upper) / (upper - lower)) ** 6).sum()
    return float(given["wish"][one[0]] + 0.02 / (0.02 + given["wrist"][rung, one[0], one[1]] ** 2) + near)


def cheapest(given: dict[str, NDArray]) -> tuple[int, float]:
    """Return how many rungs any way reaches, and what the cheapest one costs."""
    costs: dict[tuple, float] = {one: own_cost(given, 0, one) for one in postures(given, 0)}
    for rung in range(1, len(given["q"])):
        after = {
            one: min((cost + step_cost(given, rung, one, other) for other, cost in costs.items()), default=np.inf)
            + own_cost(given, rung, one)
            for one in postures(given, rung)
        }
        costs = {one: cost for one, cost in after.items() if cost < np.inf}
        if not costs:
            return rung, np.inf
    return len(given["q"]), min(costs.values())


@pytest.mark.parametrize("number", range(12))
def test_the_way_is_the_cheapest_of_all_and_continuous_within_limits(number: int) -> None:
    given = ladder(number)
    reached, way, joints = searched(given)
    wanted, cost = cheapest(given)
    assert reached == wanted
    if reached < len(way):
        return
    ones = [(int(g), int(b), tuple(q)) for (g, b), q in zip(way, joints, strict=True)]
    total = sum(own_cost(given, rung, one) for rung, one in enumerate(ones))
    total += sum(step_cost(given, rung, ones[rung], ones[rung - 1]) for rung in range(1, len(ones)))
    assert total == pytest.approx(cost)
    assert ((LIMITS[0] <= joints) & (joints <= LIMITS[1])).all()


def test_a_joint_without_limits_turns_on_and_one_with_limits_ends() -> None:
    """A joint that turns by 1 rad from rung to rung for three turns: ±7 rad is too little for it, no limit is not."""
    given = ladder(0, rungs=20, combinations=1, branches=1)
    given["q"] = np.zeros((20, 1, 1, 3))
    given["q"][:, 0, 0, 2] = np.arange(20.0) - TURN * np.round(np.arange(20.0) / TURN)
    given |= {"blocked": np.zeros((20, 1, 1), np.int8), "wrist": np.ones((20, 1, 1)), "most": np.full((19, 3), 1.5)}
    given |= {"neighbours": np.array([[-1, 0, -1]]), "wish": np.zeros(1)}
    # From -7 rad it is 14 rad to 7: fourteen steps.
    assert searched(given)[0] < 16
    reached, _, joints = searched(given | {"limits": np.array([[-3.0, -5.0, -np.inf], [3.0, 5.5, np.inf]])})
    assert reached == 20
    np.testing.assert_allclose(np.diff(joints[:, 2]), 1.0)
