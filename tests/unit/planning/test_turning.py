"""Angular velocity of moves of the tool centre point along a path."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.planning.moves import Linear, Spline
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import MoveStep

from tests.unit.planning.runs import plan_run, solver
from tests.unit.planning.test_parabola import cell, moved, poses


@pytest.mark.parametrize(("given", "fastest"), [(0.0, 2.0), (0.3, 0.3), (0.8, 0.8)])
@pytest.mark.parametrize("way", [0.0, 0.02])
def test_a_tool_turns_no_faster_than_it_may(rng: np.random.Generator, given: float, fastest: float, way: float) -> None:
    """The law is a double S: it gets to its velocity where way and joints allow it, and never beyond."""
    snapshot, at = cell(rng)
    goal = PoseGoal(moved(at, [0.0, way, 0.0], np.array([0.0, 0.0, 1.0])))
    for move in (
        Linear("arm0", goal, max_velocity=1.0, max_acceleration=5.0, max_angular_velocity=given),
        Spline("arm0", (goal,), max_velocity=1.0, max_acceleration=5.0, max_angular_velocity=given),
    ):
        (run,), _ = plan_run(snapshot, [MoveStep((move,))], solver)
        (track,) = run.plan.tracks
        ends = poses(snapshot, run, 2)
        turn = np.arccos((np.trace(ends[0, :3, :3].T @ ends[1, :3, :3]) - 1.0) / 2.0)
        assert turn == pytest.approx(1.0, abs=1e-6)
        law = track.time_law
        shares = law.derivative().evaluate(np.linspace(law.start, law.end, 2001))[:, 0]
        length = track.path.end - track.path.start
        peak = float(shares.max()) / length
        assert peak <= fastest * 1.001
        if given:
            assert peak == pytest.approx(fastest, rel=0.01)
