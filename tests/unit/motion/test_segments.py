"""Segments of trajectories: against the formulas of ros2_control, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.motion import plan_execution
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.segments import JointMotion, TrajectoryPoints, plan_points, points

from tests import ros2_control

LIMITS = JointLimits(
    ("a", "b", "c"), np.full(3, -10.0), np.full(3, 10.0), np.full(3, 50.0), np.full(3, 8.0), np.full(3, 1e3)
)
AT_REST = JointMotion(np.zeros(3), np.zeros(3), np.zeros(3))
TICK = 0.004


def drawn(rng: np.random.Generator, count: int, degree: int) -> tuple[np.ndarray, ...]:
    """Return times, positions, velocities and accelerations; of the last two as many as a degree of 1, 3 or 5 wants."""
    times = np.cumsum(rng.uniform(0.05, 0.5, count))
    rows = [rng.uniform(-1.0, 1.0, (count, 3)) for _ in range(3)]
    rows[1][-1] = rows[2][-1] = 0.0
    return times, *rows[: (degree + 1) // 2]


def made(given: tuple[np.ndarray, ...]) -> TrajectoryPoints:
    v, a = (given[place] if place < len(given) else None for place in (2, 3))
    return points(given[0], given[1], v, a, LIMITS)


def rows_of(given: tuple[np.ndarray, ...]) -> list[ros2_control.Point]:
    times, *rows = given
    each = [[row.tolist() for row in values] for values in rows] + [[[]] * len(times)] * (3 - len(rows))
    return list(zip(times.tolist(), *each, strict=True))


def ticked(plan: object, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and velocities (n, 3) after each of some ticks of 4 ms."""
    run, found = plan_execution.start(plan, 1.0), []  # pyright: ignore[reportArgumentType]
    for _ in range(count):
        run = run.advance(TICK, 1.0)
        found.append(run.sample()[:2])
    q, v = zip(*found, strict=True)
    return np.array(q), np.array(v)


@pytest.mark.parametrize("degree", [1, 3, 5])
@pytest.mark.parametrize("moves", [False, True])
def test_each_tick_is_where_ros2_control_has_it(degree: int, moves: bool, rng: np.random.Generator) -> None:
    here = JointMotion(*rng.uniform(-0.5, 0.5, (3, 3))) if moves else AT_REST
    given = drawn(rng, 7, degree)
    asked = made(given)
    plan = plan_points(asked, here, 0.0, LIMITS)
    before = (0.0, *(list(map(float, one)) for one in (here.positions, here.velocities, here.accelerations)))
    count = int(given[0][-1] / TICK) + 20
    q, v = ticked(plan, count)
    for tick in range(count):
        wanted = ros2_control.sample(rows_of(given), before, 0.0, (tick + 1) * TICK)  # pyright: ignore[reportArgumentType]
        np.testing.assert_allclose(q[tick], wanted[0], atol=1e-9)
        if (tick + 1) * TICK < given[0][-1]:
            np.testing.assert_allclose(v[tick], wanted[1], atol=1e-7)
    np.testing.assert_array_equal(q[-1], given[1][-1])


def test_points_that_are_past_are_left_out(rng: np.random.Generator) -> None:
    given = drawn(rng, 5, 5)
    asked = made(given)
    middle = 0.5 * (given[0][1] + given[0][2])
    late = plan_points(asked, AT_REST, middle, LIMITS)
    assert late.duration == pytest.approx(given[0][-1] - middle)
    rest = given[0][2] - middle
    first = ros2_control.sample(rows_of(given), (0.0, [], [], []), 0.0, given[0][2] + 0.01)[0]
    run = plan_execution.start(late, 1.0).advance(rest + 0.01, 1.0)
    np.testing.assert_allclose(run.sample()[0], first, atol=1e-9)


def test_it_begins_at_a_point_that_is_due_now(rng: np.random.Generator) -> None:
    given = drawn(rng, 4, 3)
    asked = points(given[0], given[1], given[2], None, LIMITS)
    there = JointMotion(given[1][1], np.zeros(3), np.zeros(3))
    plan = plan_points(asked, there, float(given[0][1]), LIMITS)
    np.testing.assert_allclose(plan.sample(0.0, 1.0, 0.0)[1], given[2][1])
    with pytest.raises(KernelError, match="the joint is at"):
        plan_points(asked, AT_REST, float(given[0][1]), LIMITS)
    only_the_last = plan_points(asked, JointMotion(given[1][-1], *2 * [np.zeros(3)]), float(given[0][-1]), LIMITS)
    assert only_the_last.duration == 0.0


def test_a_last_point_with_a_velocity_is_passed_and_it_brakes_evenly() -> None:
    asked = points([0.5], [[0.2, 0.0, 0.0]], [[0.4, -0.8, 0.0]], None, LIMITS)
    plan = plan_points(asked, AT_REST, 0.0, LIMITS)
    # The joint whose speed takes longest brakes with the greatest acceleration: 0.8 / 8 s = 0.1 s, over v t / 2.
    assert plan.duration == pytest.approx(0.6)
    np.testing.assert_allclose(plan.goal, [0.2 + 0.4 * 0.1 / 2, -0.8 * 0.1 / 2, 0.0])
    np.testing.assert_allclose(plan.sample(0.5, 1.0, 0.0)[1], [0.4, -0.8, 0.0], atol=1e-12)
    np.testing.assert_allclose(plan.sample(0.55, 1.0, 0.0)[2], [-4.0, 8.0, 0.0], atol=1e-9)


def test_one_that_is_cancelled_brakes_on_its_way(rng: np.random.Generator) -> None:
    given = drawn(rng, 6, 5)
    here = JointMotion(*rng.uniform(-0.5, 0.5, (3, 3)))
    plan = plan_points(made(given), here, 0.0, LIMITS)
    run = plan_execution.start(plan, 1.0).advance(0.1, 1.0).cancel()
    for _ in range(2000):
        run = run.advance(TICK, 1.0)
    assert run.ended
    times = np.linspace(0.0, plan.duration, 20_000)
    way = plan.derivatives(times)[0]
    assert np.abs(way - run.sample()[0]).max(axis=1).min() < 1e-3


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (([-0.1], [[0.0] * 3], None, None), "0 or later"),
        (([0.1], [[0.0] * 3], None, [[0.0] * 3]), "needs velocities"),
        (([0.2, 0.1], [[0.0] * 3] * 2, None, None), "increase strictly"),
        (([], np.zeros((0, 3)), None, None), "at least 1 time"),
        (([0.1], [[0.0] * 3], [[0.0] * 2], None), "velocities of a trajectory have shape"),
        (([0.1], [[0.0, np.nan, 0.0]], None, None), "must be finite"),
    ],
)
def test_what_is_no_trajectory_is_refused(given: tuple[object, ...], told: str) -> None:
    with pytest.raises(KernelError, match=told):
        points(*given, LIMITS)  # pyright: ignore[reportArgumentType, reportCallIssue]


def test_limits_are_kept_between_the_points_and_on_the_way_to_the_first() -> None:
    with pytest.raises(LimitError, match="joint 'b' would be at 11"):
        points([0.1], [[0.0, 11.0, 0.0]], None, None, LIMITS)
    with pytest.raises(LimitError, match="too fast"):
        points([0.1, 0.2], [[0.0] * 3, [6.0, 0.0, 0.0]], None, None, LIMITS)
    far = points([0.1], [[6.0, 0.0, 0.0]], None, None, LIMITS)
    with pytest.raises(LimitError, match="joint 'a' has velocity 60, its limit is 50"):
        plan_points(far, AT_REST, 0.0, LIMITS)
    with pytest.raises(KernelError, match=r"due 0\.4 s ago"):
        plan_points(far, AT_REST, 0.5, LIMITS)
