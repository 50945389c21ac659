"""Ways of joints: where they are, and that no joint goes farther between two times than is told."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.collision.joint_path import (
    JointPath,
    line,
    of_laws,
    of_plan,
    of_program,
    through,
    together,
)
from virtualrobot_kernel.motion import plan_execution
from virtualrobot_kernel.motion.planned import plan_together

from tests.unit.motion.motions import random_ptp, random_trajectory
from tests.unit.motion.test_program import JOINTS, chained

POINTS = 400


def check(path: JointPath, rng: np.random.Generator, slack: float) -> None:
    """Compare the told travel with that between close points: never less, and by at most a share of the whole more."""
    whole = path.travel(path.begin, path.end)
    for begin, end in ((path.begin, path.end), *np.sort(rng.uniform(path.begin, path.end, (3, 2)), axis=1)):
        sampled = np.abs(np.diff([path.at(time) for time in np.linspace(begin, end, POINTS)], axis=0)).sum(axis=0)
        told = path.travel(begin, end)
        assert (told >= sampled - 1e-9).all()
        assert told.sum() <= sampled.sum() + slack * whole.sum() + 1e-6
    middle = 0.3 * path.begin + 0.7 * path.end
    np.testing.assert_allclose(path.travel(path.begin, middle) + path.travel(middle, path.end), whole, atol=1e-9)
    for time in (path.begin - 1.0, path.end + 1.0):
        assert not path.travel(time, time + 0.5 * np.sign(time - path.begin)).any()


def test_lines_and_ways_through_points(rng: np.random.Generator) -> None:
    """Both are exact; the bend between points is A h^2 / 8 for what moves."""
    points = rng.normal(size=(5, 3))
    points[:, 1] = points[0, 1]
    check(line(points[0], points[1], 2.0, 5.0), rng, 1e-9)
    path = through([0.0, 0.5, 0.7, 1.0, 2.0], points, 0.4)
    check(path, rng, 0.1)
    np.testing.assert_allclose([path.at(time) for time in (0.0, 0.5, 2.0)], points[[0, 1, 4]])
    assert path.wobble is not None
    np.testing.assert_allclose(path.wobble, [0.05, 0.0, 0.05])


@pytest.mark.parametrize("kind", ["ptp", "trajectory", "group"])
def test_plans_are_followed_by_their_own_polynomials(kind: str, rng: np.random.Generator) -> None:
    """The places are those of the plan, the travels at most a tenth above the true ones."""
    plan = {
        "ptp": random_ptp,
        "trajectory": lambda rng: random_trajectory(rng)[0],
        "group": lambda rng: plan_together([random_ptp(rng, 6), random_ptp(rng, 2)]),
    }[kind](rng)
    places = rng.permutation(plan.q_count + 2)[: plan.q_count].astype(np.int32)
    q = rng.normal(size=plan.q_count + 2)
    path = of_plan(q, places, plan)
    for tau in rng.uniform(0.0, plan.duration, 5):
        expected = q.copy()
        expected[places] = plan.derivatives(np.array([tau]))[0, 0]
        np.testing.assert_allclose(path.at(tau), expected, atol=1e-9)
    check(path, rng, 0.1)


def test_brakes_are_laws_on_the_paths_of_the_plan(rng: np.random.Generator) -> None:
    """What a cancelled motion does in its ticks lies on the way of its brakes."""
    plan = random_ptp(rng)
    going = plan_execution.start(plan, 1.0).advance(0.4 * plan.duration, 1.0).cancel()
    assert going.brakes
    end = max(brake.end for brake in going.brakes)
    path = of_laws(np.zeros(plan.q_count), np.arange(plan.q_count, dtype=np.int32), plan, going.brakes, 0.0, end)
    check(path, rng, 0.1)
    time = 0.0
    while not going.ended:
        np.testing.assert_allclose(path.at(time), going.sample()[0], atol=1e-9)
        going, time = going.advance(0.004, 1.0), time + 0.004


def test_programs_go_from_stage_to_stage(rng: np.random.Generator) -> None:
    """A joint that a stage doesn't move stands where the stage before has left it."""
    program = chained(rng, "move", "dwell", "move", "set on", "wait", "move")
    q_index = np.arange(JOINTS, dtype=np.int32)[::-1] + 1
    path = of_program(np.full(JOINTS + 2, 7.0), q_index, program)
    assert path.end == program.duration
    check(path, rng, 0.1)
    stands = program.start.copy()
    for begin, stage in zip(program.begins, program.stages, strict=False):
        np.testing.assert_allclose(path.at(begin)[q_index], stands, atol=1e-9)
        if stage.plan is not None:
            stands[list(stage.columns)] = stage.plan.goal
    np.testing.assert_allclose(path.at(path.end)[q_index], stands, atol=1e-9)
    np.testing.assert_array_equal(path.at(0.1)[[0, -1]], 7.0)


def test_several_at_once(rng: np.random.Generator) -> None:
    """Each moves its own joints, from its own begin to its own end."""
    start, goal = np.zeros(4), np.array([1.0, 2.0, 0.0, 0.0])
    first, second = line(start, goal, 0.0, 2.0), line(start, goal[::-1].copy(), 1.0, 3.0)
    both = together([first, second])
    assert (both.begin, both.end) == (0.0, 3.0)
    np.testing.assert_allclose(both.at(2.0), [1.0, 2.0, 1.0, 0.5])
    check(both, rng, 0.05)
