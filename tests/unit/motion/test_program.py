"""Programs that run: stages in order, signals at marks, waits, dwells, searches; paused and cancelled anywhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion import program_run
from virtualrobot_kernel.motion.plan import Plan, plan_ptp
from virtualrobot_kernel.motion.program import Program, Stage, Wait
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import Phase, TickContext
from virtualrobot_kernel.motion.signals import Condition, SignalValue

from .motions import TICK, random_limits

JOINTS = 3


def ptp(rng: np.random.Generator, start: np.ndarray) -> Plan:
    """Return a random motion of some joints from where they are, within ±2 rad, which all random limits hold."""
    goal = rng.uniform(np.maximum(start - 0.5, -2.0), np.minimum(start + 0.5, 2.0))
    return plan_ptp(start, goal, random_limits(rng, len(start)))


def chained(rng: np.random.Generator, *stages: str) -> Program:
    """Return a program: `move`, `wait`, `dwell`, or `set NAME`, `clear NAME`; each move has a mark half way."""
    at = np.zeros(JOINTS)
    made = []
    for step, what in enumerate(stages):
        kind, _, name = what.partition(" ")
        if kind == "move":
            columns = sorted(rng.choice(JOINTS, int(rng.integers(1, JOINTS + 1)), replace=False).tolist())
            plan = ptp(rng, at[columns])
            at[columns] = plan.goal
            half = (0.5 * plan.duration, f"half{step}", True)
            made.append(Stage(plan, tuple(columns), ((0.0, step),), (half,)))
        elif kind == "wait":
            made.append(Stage(None, (), ((0.0, step),), wait=Wait(0.1, Condition(name or "go"))))
        elif kind == "dwell":
            made.append(Stage(None, (), ((0.0, step),), wait=Wait(float(rng.uniform(0.01, 0.1)))))
        else:
            made.append(Stage(None, (), ((0.0, step),), ((0.0, name, kind == "set"),)))
    return Program(tuple(made), np.zeros(JOINTS), len(stages))


def run(
    program: Program,
    signals: Mapping[str, bool] | None = None,
    override: Callable[[int], float] = lambda tick: 1.0,
    act: Callable[[int, ProgramRun], ProgramRun] = lambda tick, now: now,
) -> tuple[list[ProgramRun], list[tuple[int, str, SignalValue]]]:
    """Return the program at every tick until it has ended, and the signals that it has set with their ticks."""
    known: dict[str, SignalValue] = dict(signals or {})
    now = program_run.start(program, override(0))
    seen, told = [now], []
    while not now.ended:
        tick = len(seen) - 1
        now = act(tick, now)
        if now.ended:
            seen.append(now)
            break
        now = now.advance(TICK, override(tick), TickContext(dict(known)))
        seen.append(now)
        known.update(now.signals)
        told += [(tick + 1, name, value) for name, value in now.signals.items()]
        assert len(seen) < 200_000
    return seen, told


def test_stages_take_as_long_as_they_are_planned(rng: np.random.Generator) -> None:
    """What remains of the tick in which a stage ends is the next one's: no time is lost between them."""
    program = chained(rng, *["move", "dwell"] * 20)
    seen, _ = run(program)
    assert seen[-1].phase is Phase.SUCCEEDED
    assert len(seen) - 1 == int(np.ceil(program.duration / TICK - 1e-6))
    np.testing.assert_array_equal(seen[-1].sample()[0][list(program.stages[-2].columns)], program.stages[-2].plan.goal)  # pyright: ignore
    progress = [now.progress for now in seen]
    assert all(before <= after for before, after in pairwise(progress))
    assert progress[-1] == pytest.approx(1.0, abs=1e-9)
    steps = [now.steps_done for now in seen]
    assert steps == sorted(steps) and (steps[0], steps[-1]) == (0, 40)
    within_a_tick = {step for step, stage in enumerate(program.stages) if stage.duration < TICK}
    assert set(range(41)) - set(steps) <= within_a_tick


def test_joints_never_jump_and_keep_their_limits(rng: np.random.Generator) -> None:
    """Between two ticks no joint moves farther than at its greatest planned speed."""
    program = chained(rng, *["move", "move", "dwell", "move"] * 3)
    fastest = np.zeros(JOINTS)
    for stage in program.stages:
        if stage.plan is not None:
            columns = list(stage.columns)
            fastest[columns] = np.maximum(fastest[columns], stage.plan.max_velocity)
    override = float(rng.uniform(0.01, 1.0))
    seen, _ = run(program, override=lambda tick: override)
    for before, after in pairwise(seen):
        assert (np.abs(after.sample()[0] - before.sample()[0]) <= fastest * TICK + 1e-12).all()


def test_all_limits_hold_between_the_ticks_too(rng: np.random.Generator) -> None:
    """At ten points of each tick velocities and accelerations keep the limits, and a tick is the sum of its parts."""
    program = chained(rng, "move", "move", "dwell", "set a", "move", "move")
    limits = np.zeros((2, JOINTS))
    for stage in program.stages:
        if stage.plan is not None:
            bounds = np.stack([stage.plan.max_velocity, stage.plan.max_acceleration])
            limits[:, list(stage.columns)] = np.maximum(limits[:, list(stage.columns)], bounds)
    override = float(rng.uniform(0.2, 1.0))
    whole = parts = program_run.start(program, override)
    while not whole.ended:
        whole = whole.advance(TICK, override)
        for _ in range(10):
            parts = parts.advance(TICK / 10, override)
            _, velocity, acceleration = parts.sample()
            assert (np.abs([velocity, acceleration]) <= limits * (1 + 1e-6) + 1e-9).all()
        np.testing.assert_allclose(parts.sample()[0], whole.sample()[0], atol=1e-9)
    assert parts.ended


@pytest.mark.parametrize("slow", [1.0, 0.37, 0.01])
def test_marks_are_set_once_in_order_at_any_override(rng: np.random.Generator, slow: float) -> None:
    program = chained(rng, "set a", "move", "clear a", "move", "set b", "move")
    _, told = run(program, override=lambda tick: slow)
    assert [(name, value) for _, name, value in told] == [
        ("a", True),
        ("half1", True),
        ("a", False),
        ("half3", True),
        ("b", True),
        ("half5", True),
    ]


def test_a_mark_is_set_with_the_tick_in_which_it_is_passed(rng: np.random.Generator) -> None:
    program = chained(rng, "move")
    stage = program.stages[0]
    _, told = run(program)
    assert told == [(int(np.ceil(stage.marks[0][0] / TICK - 1e-6)), "half0", True)]


def test_every_value_of_a_signal_holds_for_a_tick(rng: np.random.Generator) -> None:
    """Set and cleared and set at once: three ticks; what is set of others meanwhile waits for its turn."""
    program = chained(rng, "set a", "clear a", "set b", "set a", "wait b", "set c")
    seen, told = run(program)
    assert told == [(1, "a", True), (2, "a", False), (2, "b", True), (3, "a", True), (3, "c", True)]
    assert seen[-1].phase is Phase.SUCCEEDED
    plan = ptp(rng, np.zeros(2))
    both = tuple((0.5 * plan.duration + 1e-5 * n, "x", bool(n % 2)) for n in range(3))
    moving = Program((Stage(plan, (0, 1), ((0.0, 0),), both),), np.zeros(2), 1)
    seen, told = run(moving, {"x": True})
    first = told[0][0]
    assert told == [(first, "x", False), (first + 1, "x", True), (first + 2, "x", False)]


def test_a_wait_ends_with_the_value_and_stands_still_before(rng: np.random.Generator) -> None:
    program = chained(rng, "move", "wait", "move")
    known = {"go": False}
    now, waited = program_run.start(program, 1.0), 0
    while not now.ended:
        now = now.advance(TICK, 1.0, TickContext(known))
        if now.phase is Phase.WAITING:
            waited += 1
            np.testing.assert_array_equal(now.sample()[1], 0.0)
            assert now.steps_done == 1
        if waited == 10:
            known = {"go": True}
    assert (now.phase, now.fault, waited) == (Phase.SUCCEEDED, None, 10)


def test_a_signal_that_has_its_value_already_is_not_waited_for(rng: np.random.Generator) -> None:
    seen, _ = run(chained(rng, "wait", "set a"), {"go": True})
    assert [now.phase for now in seen] == [Phase.RUNNING, Phase.SUCCEEDED]


def test_a_wait_that_takes_too_long_fails_at_its_tick(rng: np.random.Generator) -> None:
    """0.1 s are 25 ticks; the fault names step, signal and time."""
    seen, told = run(chained(rng, "set a", "wait", "set b"))
    assert len(seen) - 1 == 25
    assert seen[-1].phase is Phase.CANCELLED
    assert seen[-1].fault == ("SIGNAL_TIMEOUT", "step 1: the signal 'go' was not on within 0.1 s")
    assert told == [(1, "a", True)]


def test_time_that_stands_paused_counts_for_no_wait(rng: np.random.Generator) -> None:
    def act(tick: int, now: ProgramRun) -> ProgramRun:
        if tick == 10:
            now = now.pause()
            assert now.phase is Phase.PAUSED
        return now.resume() if tick == 110 else now

    seen, _ = run(chained(rng, "wait"), act=act)
    assert len(seen) - 1 == 125
    assert seen[10].phase is Phase.WAITING
    assert seen[11].phase is Phase.PAUSED
    assert seen[111].phase is Phase.WAITING


def test_a_wait_is_cancelled_at_once(rng: np.random.Generator) -> None:
    seen, _ = run(chained(rng, "wait", "move"), act=lambda tick, now: now.cancel() if tick == 5 else now)
    assert (len(seen), seen[-1].phase, seen[-1].fault) == (7, Phase.CANCELLED, None)


def test_pause_and_cancel_at_any_tick_end_well(rng: np.random.Generator) -> None:
    """A cancelled program sets no signal that it has not reached, and stands on its path; a paused one goes on."""
    program = chained(rng, "move", "set a", "dwell", "move", "move", "set b", "dwell", "move")
    whole, every = run(program)
    for _ in range(12):
        when, back = int(rng.integers(1, len(whole))), int(rng.integers(1, 300))

        def pausing(tick: int, now: ProgramRun, when: int = when, back: int = back) -> ProgramRun:
            if now.phase is Phase.STOPPING:
                return now
            return now.pause() if tick == when else now.resume() if tick == when + back else now

        seen, told = run(program, act=pausing)
        assert seen[-1].phase is Phase.SUCCEEDED
        assert [one[1:] for one in told] == [one[1:] for one in every]
        np.testing.assert_array_equal(seen[-1].sample()[0], whole[-1].sample()[0])
        seen, told = run(program, act=lambda tick, now, when=when: now.cancel() if tick == when else now)
        assert seen[-1].phase in (Phase.CANCELLED, Phase.SUCCEEDED)
        assert [one[1:] for one in told] == [one[1:] for one in every][: len(told)]
        np.testing.assert_allclose(seen[-1].sample()[1], 0.0, atol=1e-12)
        for tick, name, _ in told:
            if name.startswith("half"):
                stage = next(stage for stage in program.stages if stage.marks and stage.marks[0][1] == name)
                assert stage.plan is not None
                reached = seen[tick]
                assert reached.at > program.stages.index(stage) or reached.running.tau >= stage.marks[0][0] - 1e-9  # pyright: ignore


def test_a_pause_that_meets_a_corner_stops_there(rng: np.random.Generator) -> None:
    """Too late to stop on the way, the motion runs to its goal; the next one does not begin before the resume."""
    program = chained(rng, "move", "move")
    plan = program.stages[0].plan
    assert plan is not None
    last = int(plan.duration / TICK) - 1
    seen, _ = run(
        program,
        act=lambda tick, now: now.pause() if tick == last else now.resume() if tick == last + 100 else now,
    )
    assert seen[last + 50].phase is Phase.PAUSED
    assert seen[last + 50].at == 1
    np.testing.assert_array_equal(seen[last + 50].sample()[0][list(program.stages[0].columns)], plan.goal)
    assert seen[-1].phase is Phase.SUCCEEDED


def searching(rng: np.random.Generator) -> Program:
    """Return a search of two joints by the signal `touch`."""
    plan = ptp(rng, np.zeros(2))
    return Program((Stage(plan, (0, 1), ((0.0, 0),), until=Condition("touch")),), np.zeros(2), 1)


def test_a_program_that_begins_where_it_stands_can_be_paused_before_its_first_tick(rng: np.random.Generator) -> None:
    """Its first motion has no length and is over at once, the program is not."""
    here = np.zeros(JOINTS)
    nothing = Stage(plan_ptp(here, here, random_limits(rng, JOINTS)), (0, 1, 2), ((0.0, 0),), ((0.0, "first", True),))
    then = Stage(None, (), ((0.0, 1),), wait=Wait(3 * TICK))
    paused = program_run.start(Program((nothing, then), here, 2), 1.0).pause()
    for _ in range(5):
        assert paused.phase is Phase.PAUSED and not paused.signals
        paused = paused.advance(TICK, 1.0, TickContext({}))
    now = paused.resume().advance(TICK, 1.0, TickContext({}))
    assert dict(now.signals) == {"first": True}
    for _ in range(2):
        assert now.phase is Phase.WAITING
        now = now.advance(TICK, 1.0, TickContext({}))
    assert now.phase is Phase.SUCCEEDED
    assert paused.cancel().phase is Phase.CANCELLED


def test_a_search_brakes_where_it_finds_its_signal(rng: np.random.Generator) -> None:
    program = searching(rng)
    ticks = int(program.duration / TICK)
    when = int(rng.integers(1, max(2, ticks // 5)))
    now = program_run.start(program, 1.0)
    found_at = None
    while not now.ended:
        known = {"touch": found_at is None and now.progress * ticks >= when}
        if known["touch"]:
            found_at = now.sample()[0]
        now = now.advance(TICK, 1.0, TickContext(known))
        if now.phase is Phase.STOPPING:
            with pytest.raises(KernelError) as refused:
                now.pause()
            assert refused.value.reason is Reason.WRONG_STATE
    assert (now.phase, now.found, now.steps_done) == (Phase.SUCCEEDED, True, 1)
    assert found_at is not None
    goal = program.stages[0].plan.goal  # pyright: ignore[reportOptionalMemberAccess]
    end = now.sample()[0]
    # Straight in joint space: where it stands is on its way between where it was found and the goal.
    along = (end - found_at) @ (goal - found_at) / ((goal - found_at) @ (goal - found_at))
    assert 0.0 <= along <= 1.0
    np.testing.assert_allclose(end, found_at + along * (goal - found_at), atol=1e-9)


def test_a_search_that_finds_nothing_ends_at_its_goal(rng: np.random.Generator) -> None:
    program = searching(rng)
    seen, _ = run(program, {"touch": False})
    assert (seen[-1].phase, seen[-1].found) == (Phase.SUCCEEDED, False)
    np.testing.assert_array_equal(seen[-1].sample()[0], program.stages[0].plan.goal)  # pyright: ignore


def test_a_search_whose_signal_is_there_does_not_move(rng: np.random.Generator) -> None:
    seen, _ = run(searching(rng), {"touch": True})
    assert (seen[-1].phase, seen[-1].found) == (Phase.SUCCEEDED, True)
    np.testing.assert_allclose(seen[-1].sample()[0], 0.0, atol=1e-9)


@pytest.mark.parametrize("touch", [True, False])
def test_a_search_without_length_looks_once(rng: np.random.Generator, touch: bool) -> None:
    """It stands at its goal already: what it comes to is told with its first tick."""
    limits = random_limits(rng, 1)
    still = Stage(plan_ptp(np.zeros(1), np.zeros(1), limits), (0,), ((0.0, 0),), until=Condition("touch"))
    seen, _ = run(Program((still,), np.zeros(1), 1), {"touch": touch})
    assert [now.phase for now in seen] == [Phase.RUNNING, Phase.SUCCEEDED]
    assert seen[-1].found is touch


def test_a_search_that_is_cancelled_has_found_nothing(rng: np.random.Generator) -> None:
    seen, _ = run(searching(rng), {"touch": False}, act=lambda tick, now: now.cancel() if tick == 2 else now)
    if seen[-1].phase is Phase.CANCELLED:
        assert seen[-1].found is None


def test_a_tick_ends_only_so_many_stages(rng: np.random.Generator) -> None:
    program = chained(rng, *(f"set s{n}" for n in range(1000)))
    seen, told = run(program)
    assert len(seen) - 1 == int(np.ceil(1000 / program_run.MOST_STAGES))
    assert len(told) == 1000
