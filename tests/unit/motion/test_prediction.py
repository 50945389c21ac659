"""What a program will do, told in advance: what its ticks then do, whatever state it is in when it is asked."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.prediction import predict
from virtualrobot_kernel.motion.program import Program, Stage, Wait
from virtualrobot_kernel.motion.program_run import ProgramRun, start
from virtualrobot_kernel.motion.running_motion import TickContext
from virtualrobot_kernel.motion.signals import Condition

TICK = 0.004
LIMITS = JointLimits(
    ("a", "b"), np.full(2, -3.0), np.full(2, 3.0), np.array([1.0, 2.0]), np.array([4.0, 5.0]), np.array([30.0, 60.0])
)


def program(*stages: Stage | tuple[float, float] | Wait) -> Program:
    """Return moves to places, waits and whole stages, one after the other from (0, 0)."""
    here, made = np.zeros(2), []
    for number, one in enumerate(stages):
        if isinstance(one, Stage):
            made.append(one)
        elif isinstance(one, Wait):
            made.append(Stage(None, (), ((0.0, number),), wait=one))
        else:
            plan = plan_ptp(here, np.array(one), LIMITS)
            made.append(Stage(plan, (0, 1), ((0.0, number),)))
            here = plan.goal
    return Program(tuple(made), np.zeros(2), len(made))


def on(run: ProgramRun, ticks: int, override: float, signals: dict[str, bool] | None = None) -> ProgramRun:
    """Return a program some ticks later."""
    for _ in range(ticks):
        run = run.advance(TICK, override, TickContext(signals or {}))
    return run


def follows(run: ProgramRun, override: float, seconds: float = 60.0) -> float:
    """Check each tick of a program from now on against what was told of it; return how long it was told."""
    told = predict(run, override, {}, seconds)
    assert told is not None and not told.brakes
    at, time = run.at, 0.0
    while time < told.end:
        run, time = on(run, 1, override), time + TICK
        begins = told.program.begins
        if run.at < len(run.program.stages):
            gone = run.running.tau if run.running else min(run.waited, run.program.stages[run.at].duration)
            now = (begins[run.at - at] if run.at - at < len(begins) else begins[-1]) + gone
        else:
            now = begins[-1]
        assert told.nominal(time) == pytest.approx(now, abs=1e-9)
    return told.end


def test_a_program_does_what_was_told(rng: np.random.Generator) -> None:
    """Moves and dwells, at any speed, from any tick of it on."""
    wish = program((1.0, -1.0), Wait(0.3), (0.5, 0.5), (-1.0, 2.0))
    override = float(rng.uniform(0.2, 1.0))
    run = on(start(wish, override), int(rng.integers(1, 400)), override)
    end = follows(run, override)
    late = on(run, int(np.ceil(end / TICK)) + 1, override)
    assert late.ended


def test_a_change_of_the_speed_is_told_by_its_ramp(rng: np.random.Generator) -> None:
    run = on(start(program((2.0, -2.0), (0.0, 0.0)), 1.0), int(rng.integers(100, 300)), 1.0)
    slower = float(rng.uniform(0.3, 0.8))
    run = on(run, 1, slower)
    assert run.running is not None and run.running.ramp.length > 0.0
    follows(run, slower)


def test_a_pause_ends_what_is_told(rng: np.random.Generator) -> None:
    run = on(start(program((2.0, -2.0), (0.0, 0.0)), 1.0), int(rng.integers(100, 300)), 1.0).pause()
    assert run.running is not None
    told = predict(run, 1.0, {}, 60.0)
    assert told is not None and not told.goes_on
    stands = on(run, int(np.ceil(told.end / TICK)) + 1, 1.0)
    assert stands.running is not None
    assert told.nominal(told.end) == pytest.approx(stands.running.tau, abs=1e-9)
    assert predict(stands, 1.0, {}, 60.0) is None


def test_brakes_are_told_as_long_as_they_last(rng: np.random.Generator) -> None:
    run = on(start(program((2.0, -2.0), (0.0, 0.0)), 1.0), int(rng.integers(100, 300)), 1.0).cancel()
    told = predict(run, 1.0, {}, 60.0)
    assert told is not None and told.brakes and told.running is not None
    assert told.when(0.5) == np.inf
    before = on(run, int(told.end / TICK), 1.0)
    assert not before.ended and on(before, 2, 1.0).ended


def test_nothing_is_told_beyond_a_wait_for_a_signal() -> None:
    """Unless the signal has its value already."""
    wish = program((1.0, 0.0), Wait(0.0, Condition("go")), (0.0, 0.0))
    run = start(wish, 1.0)
    told = predict(run, 1.0, {"go": False}, 60.0)
    assert told is not None and not told.goes_on
    assert told.end == pytest.approx(wish.begins[1])
    beyond = predict(run, 1.0, {"go": True}, 60.0)
    assert beyond is not None and beyond.end == pytest.approx(wish.duration)
    waits = on(run, int(wish.begins[1] / TICK) + 2, 1.0, {"go": False})
    assert predict(waits, 1.0, {"go": False}, 60.0) is None


def test_as_much_is_told_as_was_asked_for() -> None:
    wish = program(*((1.0, 0.0), (0.0, 1.0)) * 20)
    told = predict(start(wish, 0.5), 0.5, {}, 3.0)
    assert told is not None and told.goes_on
    assert 3.0 <= told.end <= 3.0 + max(stage.duration for stage in wish.stages) / 0.5
    assert len(told.program.stages) < 10


def test_times_of_nominal_times(rng: np.random.Generator) -> None:
    wish = program((1.0, -1.0), Wait(0.3), (0.5, 0.5))
    told = predict(on(start(wish, 0.5), 50, 0.5), 0.5, {}, 60.0)
    assert told is not None
    for time in rng.uniform(0.0, told.end, 10).tolist():
        assert told.when(told.nominal(time)) == pytest.approx(time, abs=1e-6)
    assert told.when(told.program.duration) == pytest.approx(told.end, abs=1e-6)
    assert told.when(told.program.duration + 1.0) == np.inf
