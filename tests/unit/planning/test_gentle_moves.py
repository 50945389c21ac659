"""Shares of acceleration and jerk that moves use: peaks of their plans against the joints' limits times the shares."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.circle import Via
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.planning.moves import Circular, Linear, Move, PointToPoint, Spline
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import MoveStep, Zone
from virtualrobot_kernel.world.state import Snapshot

from tests.unit.planning.runs import plan_run, solver
from tests.unit.planning.test_parabola import POSTURE, cell, moved

WAY = np.array([1.2, -0.5, 0.6, 0.4, -0.8, 0.5])
FASTEST = 9.0
"""Speed (m/s) and acceleration (m/s²) of tool centre points that leave the limits of the joints to count."""


def moves_of(snapshot: Snapshot, at: np.ndarray) -> dict[str, Move]:
    """Return a move of each kind that takes shares, from the posture and the place of the tool centre point there."""
    names = [joint.name for joint in snapshot.structure.robot("arm0")[1].joints]
    goal, via = PoseGoal(moved(at, [0.0, 0.2, 0.0])), moved(at, [0.05, 0.1, 0.0])
    rates: dict[str, Any] = {"max_velocity": FASTEST, "max_acceleration": FASTEST}
    return {
        "joints": PointToPoint("arm0", dict(zip(names, (POSTURE + WAY).tolist(), strict=True))),
        "line": Linear("arm0", goal, **rates),
        "arc": Circular("arm0", Via(via[:3, 3]), goal.reference_t_tcp, **rates),
        "spline": Spline("arm0", (PoseGoal(via), goal), **rates),
    }


def used(snapshot: Snapshot, plan: Plan, until: float | None = None) -> tuple[float, float]:
    """Return the greatest shares of the joints' accelerations and jerks that a plan uses, up to a time (s)."""
    limits = [joint.limits for joint in snapshot.structure.robot("arm0")[1].joints]
    _, _, a, j = np.abs(plan.derivatives(np.linspace(0.0, until or plan.duration, 20_001))).max(axis=1)
    return (
        float((a / [one.acceleration for one in limits]).max()),
        float((j / [one.jerk for one in limits]).max()),
    )


@pytest.mark.parametrize("law", TimeLaw)
@pytest.mark.parametrize("kind", ["joints", "line", "arc", "spline"])
def test_a_move_uses_its_shares_of_acceleration_and_jerk_and_no_more(
    kind: str, law: TimeLaw, rng: np.random.Generator
) -> None:
    snapshot, at = cell(rng)
    move = replace(moves_of(snapshot, at)[kind], time_law=law)
    ((free,), _), ((gentle,), _) = (
        plan_run(snapshot, [MoveStep((replace(move, acceleration_factor=a, jerk_factor=j),))], solver)
        for a, j in ((1.0, 1.0), (0.25, 0.1))
    )
    acceleration, jerk = used(snapshot, gentle.plan)
    assert acceleration <= 0.25 * (1.0 + 1e-6)
    assert law is TimeLaw.TIME_OPTIMAL or jerk <= 0.1 * (1.0 + 1e-6)
    assert gentle.plan.duration > 1.3 * free.plan.duration
    np.testing.assert_allclose(gentle.plan.goal, free.plan.goal, atol=1e-9)
    if kind == "joints":
        assert max(acceleration / 0.25, jerk / 0.1) == pytest.approx(1.0, rel=1e-3), "and it reaches one of them"


def test_half_the_acceleration_lets_a_short_joint_move_take_the_root_of_two_longer(rng: np.random.Generator) -> None:
    """A move too short for its greatest speed, with no limit of jerk, takes 2 sqrt(way / acceleration)."""
    snapshot, _ = cell(rng)
    names = [joint.name for joint in snapshot.structure.robot("arm0")[1].joints]
    goal = dict(zip(names, (POSTURE + 0.01).tolist(), strict=True))
    move = PointToPoint("arm0", goal, time_law=TimeLaw.TIME_OPTIMAL)
    free, gentle = (
        plan_run(snapshot, [MoveStep((replace(move, acceleration_factor=share),))], solver)[0][0].plan.duration
        for share in (1.0, 0.5)
    )
    assert gentle == pytest.approx(np.sqrt(2.0) * free, rel=1e-9)


def test_a_line_keeps_shares_of_its_own_acceleration_and_jerk(rng: np.random.Generator) -> None:
    """A slow line of 0.2 m: 1 m/s² and 10 m/s³ without shares; the tool's speed is told by its way."""
    snapshot, at = cell(rng)
    line = Linear("arm0", PoseGoal(moved(at, [0.0, 0.2, 0.0])), max_velocity=0.1, max_acceleration=1.0)
    for shares in ((1.0, 1.0), (0.2, 1.0), (1.0, 0.1)):
        step = MoveStep((replace(line, acceleration_factor=shares[0], jerk_factor=shares[1]),))
        (run,), _ = plan_run(snapshot, [step], solver)
        law = run.plan.tracks[0].time_law
        _, speed, acceleration, jerk = 0.2 * np.abs(law.states(np.linspace(0.0, law.end, 20_001), 3)[:, :, 0]).max(
            axis=1
        )
        assert speed == pytest.approx(0.1, rel=1e-6)
        assert jerk == pytest.approx(10.0 * shares[1], rel=1e-6)
        # 0.1 m/s is reached before the acceleration is where sqrt(speed * jerk) is less.
        assert acceleration == pytest.approx(min(shares[0], np.sqrt(0.1 * 10.0 * shares[1])), rel=1e-3)


def test_moves_that_a_zone_joins_keep_each_its_shares(rng: np.random.Generator) -> None:
    snapshot, at = cell(rng)
    first = moves_of(snapshot, at)["joints"]
    assert isinstance(first, PointToPoint) and isinstance(first.goal, dict)
    second = replace(first, goal={name: value - 0.7 for name, value in first.goal.items()})
    steps = [MoveStep((replace(first, acceleration_factor=0.2),), Zone(percent=20.0)), MoveStep((second,))]
    (run,), _ = plan_run(snapshot, steps, solver)
    (entered, _), _ = run.zones[0], run.steps
    assert used(snapshot, run.plan, entered)[0] <= 0.2 * (1.0 + 1e-3)
    assert used(snapshot, run.plan)[0] > 0.5
