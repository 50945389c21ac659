"""Runs that are extended as they go: the same up to the cut, all limits kept after it, as fast as planned at once."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.planning.blending import PlannedRun, alone_run, join_steps, open_run
from virtualrobot_kernel.planning.extend_run import Extension, extended
from virtualrobot_kernel.planning.program import MoveStep, Zone
from virtualrobot_kernel.planning.steps import plan_steps
from virtualrobot_kernel.world.state import Snapshot

from tests.tiers import Draws, every_fifth
from tests.unit.planning.runs import KINDS, cell_of, random_move, random_steps, solver
from tests.unit.planning.test_blending import check_law

ARMS = ["puma560", "iiwa", "panda", "xarm6"]


def limits_of(snapshot: Snapshot, run: PlannedRun) -> np.ndarray:
    """Return velocity, acceleration and jerk limits of a run's joints, (3, n)."""
    joints = {joint.name: joint.limits for joint in snapshot.structure.robot("arm0")[1].joints}
    return np.array(
        [[getattr(joints[name], f) for _, name in run.joints] for f in ("velocity", "acceleration", "jerk")]
    )


def check_extension(snapshot: Snapshot, before: PlannedRun, found: Extension, now: float) -> None:
    """Check that an extended run is the one before up to the cut, and keeps the limits from there to its end."""
    after, cut = found.run.plan, found.cut
    (law,) = (track.time_law for track in after.tracks)
    assert now - 1e-12 <= cut <= before.plan.duration and law.start <= max(now, 0.0)
    taus = np.linspace(law.start, cut, 300)[1:-1]
    was, now_is = before.plan.derivatives(taus), after.derivatives(taus)
    limits = limits_of(snapshot, before)
    assert np.abs(was[0] - now_is[0][:, : was.shape[2]]).max() < 1e-9
    for derivative in (0, 1, 2):
        off = np.abs(was[derivative + 1] - now_is[derivative + 1][:, : was.shape[2]]) / limits[derivative]
        assert off.max() < 1e-5
    check_law(after, *limits_of(snapshot, found.run))
    assert [number for _, number in found.run.steps] == list(range(len(found.run.steps)))
    assert all(np.diff([time for time, _ in found.run.steps]) > 0.0)


@pytest.mark.parametrize("last", every_fifth(KINDS))
def test_a_run_that_goes_is_the_same_until_the_cut_and_keeps_all_limits(
    rng: np.random.Generator, draws: Draws, last: str
) -> None:
    joined = 0
    for _ in range(draws(15)):
        kinds = [str(kind) for kind in rng.choice(KINDS, 2)]
        snapshot, steps = random_steps(rng, str(rng.choice(ARMS)), [*kinds, last], Zone(percent=30.0))
        first, *others = plan_steps(snapshot, steps, solver)
        run, now = alone_run(first), 0.0
        for step in others:
            now += float(rng.uniform(0.0, 0.6)) * (run.plan.duration - now)
            found = extended(run, step, now, now)
            if isinstance(found, str):
                break
            check_extension(snapshot, run, found, now)
            joined += 1
            run = found.run
    assert joined


@pytest.mark.long
def test_a_run_that_is_extended_early_is_that_of_all_steps_at_once(rng: np.random.Generator, draws: Draws) -> None:
    equal = 0
    for _ in range(draws(20)):
        snapshot, steps = random_steps(rng, str(rng.choice(ARMS)), ["joints", "line", "joints"], Zone(percent=30.0))
        planned = plan_steps(snapshot, steps, solver)
        runs, _ = join_steps(planned)
        run = alone_run(planned[0])
        for step in planned[1:]:
            if isinstance(found := extended(run, step, 0.0, 0.0), str):
                break
            run = found.run
        if len(runs) > 1 or len(run.steps) < len(planned):
            continue
        (whole,) = runs
        assert run.plan.duration < 1.1 * whole.plan.duration
        if abs(run.plan.duration - whole.plan.duration) < 0.004:
            equal += 1
            at = np.linspace(0.0, 1.0, 200)
            one, other = (plan.derivatives(at * plan.duration)[0] for plan in (run.plan, whole.plan))
            assert np.abs(one - other).max() < 0.01
    assert equal


def test_time_optimal_runs_are_extended_before_they_start(rng: np.random.Generator) -> None:
    joined = 0
    for _ in range(5):
        snapshot, steps = random_steps(rng, "iiwa", ["joints", "joints"], Zone(percent=40.0), TimeLaw.TIME_OPTIMAL)
        first, second = plan_steps(snapshot, steps, solver)
        runs, _ = join_steps([first, second])
        found = extended(alone_run(first), second, 0.0, 0.0)
        if not isinstance(found, str):
            joined += 1
            assert found.run.plan.duration == pytest.approx(runs[0].plan.duration, rel=0.1)
        late = 0.5 * first.plan.duration
        if not isinstance(found := extended(alone_run(first), second, late, late), str):
            assert late <= found.cut and found.run.plan.duration < first.plan.duration + second.plan.duration
    assert joined


def test_moves_that_go_together_get_one_law_so_that_more_can_be_joined(rng: np.random.Generator) -> None:
    snapshot = cell_of(rng, "iiwa", "panda")
    zone = Zone(percent=30.0)
    steps = [
        MoveStep(tuple(random_move(rng, snapshot, f"arm{place}", "joints") for place in range(2)), zone)
        for _ in range(2)
    ]
    first, second = plan_steps(snapshot, steps, solver)
    assert alone_run(first).tail is None
    assert extended(alone_run(first), second, 0.0, 0.0) == "it has been planned as an end"
    found = extended(open_run(alone_run(first), first), second, 0.0, 0.0)
    assert isinstance(found, Extension)
    assert found.run.plan.duration < first.plan.duration + second.plan.duration
