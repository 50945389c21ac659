"""Programs in the world: replayed from the journal bit for bit, whatever happens to them, however time is stepped."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.program import Program, Stage, Wait
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.motion.signals import Condition, SignalValue
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import (
    CancelMotion,
    Command,
    CreateNodes,
    CreateSignal,
    GoOn,
    PauseMotion,
    PickPart,
    PlacePart,
    RemoveSignal,
    ResumeMotion,
    SetSignal,
    SetSpeedFactor,
    StartMotion,
)
from virtualrobot_kernel.world.journal import MemoryJournal, replay
from virtualrobot_kernel.world.state import EndCause, Signal, State
from virtualrobot_kernel.world.store import World

from tests.unit.journals import entries_of
from tests.unit.world.builders import TICK, arm, part, shifted

GUARD = 30.0
NAMES = ("a", "b", "c")


@pytest.fixture
def world() -> Iterator[World]:
    made = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, round(TICK * 1e9)))
    made.start()
    yield made
    made.close()


def program(rng: np.random.Generator, state: State, joint: str, column: int) -> StartMotion:
    """Return a program of one joint of the arm: moves with a mark, sets, waits and dwells in any order."""
    one = (-2.0, 2.0, 1.0, 4.0, 40.0)
    limits = JointLimits((joint,), *(np.array([value]) for value in one))
    at = start = float(state.q[column])
    stages = []
    for step in range(int(rng.integers(1, 8))):
        here, name, value = ((0.0, step),), str(rng.choice(NAMES)), bool(rng.integers(2))
        kind = rng.integers(5)
        if kind < 2:
            goal = float(rng.uniform(-1.0, 1.0))
            plan = plan_ptp([at], [goal], limits)
            mark = (float(rng.uniform(0.0, plan.duration)), name, value)
            stages.append(Stage(plan, (0,), here, (mark,)))
            at = goal
        elif kind == 2:
            stages.append(Stage(None, (), here, ((0.0, name, value),)))
        else:
            wait = Wait(float(rng.uniform(0.01, 0.2)), Condition(name, value) if kind == 3 else None)
            stages.append(Stage(None, (), here, wait=wait))
    return StartMotion((("arm", joint),), Program(tuple(stages), np.array([start]), len(stages)))


def steered(rng: np.random.Generator, state: State) -> Command:
    """Return something that anyone may do while programs run."""
    ended_or_none = f"motion-{int(rng.integers(1, state.motion_count + 2))}"
    id = str(rng.choice([*(motion.id for motion in state.motions), ended_or_none]))
    choices: list[Command] = [
        PauseMotion(id),
        ResumeMotion(id),
        ResumeMotion(id),
        CancelMotion(id),
        SetSignal(str(rng.choice(NAMES)), bool(rng.integers(2))),
        SetSpeedFactor("", float(rng.uniform(0.05, 1.0))),
        RemoveSignal("none"),
    ]
    return choices[int(rng.integers(len(choices)))]


@pytest.mark.long
def test_a_run_is_replayed_bit_for_bit(world: World, rng: np.random.Generator) -> None:
    first = world.snapshot
    world.submit([arm(), *(CreateSignal(Signal(name, False)) for name in NAMES)]).result(GUARD)
    seen: list[State] = []
    world.listen(lambda: seen.append(world.snapshot.state))
    in_vain = Stage(None, (), ((0.0, 0),), wait=Wait(0.1, Condition("a")))
    world.submit([StartMotion((("arm", "a"),), Program((in_vain,), np.zeros(1), 1))]).result(GUARD)
    world.step(50).result(GUARD)
    for _ in range(200):
        state = world.snapshot.state
        moving = {name for motion in state.motions for _, name in motion.joints}
        free = [(name, column) for column, name in enumerate("ab") if name not in moving]
        if free and rng.random() < 0.5:
            world.submit([program(rng, state, *free[0])]).result(GUARD)
        else:
            world.submit([steered(rng, state)]).exception(GUARD)
        world.step(int(rng.integers(1, 80))).result(GUARD)
    last = world.snapshot.state
    again = replay(first.structure, first.state, entries_of(world), last.tick, TICK, world_poses).state
    np.testing.assert_array_equal(again.q, last.q)
    np.testing.assert_array_equal(again.v, last.v)
    assert dict(again.signals) == dict(last.signals)
    assert ends(again) == ends(last)
    assert {one.cancellation.cause.name for one in last.ended if one.cancellation} >= {"CALL", "SIGNAL_TIMEOUT"}
    # Whoever listens has seen every value of every signal, though most ticks were steps of many: alone or together,
    # the ticks give the same.
    told = [dict(one.signals) for one in seen]
    slowly = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, round(TICK * 1e9)))
    slowly.start()
    every = []
    slowly.listen(lambda: every.append(dict(slowly.snapshot.state.signals)))
    for entry in entries_of(world):
        while slowly.snapshot.state.tick < entry.tick:
            slowly.step(1).result(GUARD)
        slowly.submit(entry.commands).result(GUARD)
    while slowly.snapshot.state.tick < last.tick:
        slowly.step(1).result(GUARD)
    slowly.close()
    assert changes(told) == changes(every)


def ends(state: State) -> list[tuple[object, ...]]:
    """Return how each motion is doing, or how it ended."""
    return [(one.id, one.running.phase, one.end_tick, one.cancellation) for one in (*state.ended, *state.motions)]


def changes(values: list[dict[str, Signal]]) -> list[dict[str, SignalValue]]:
    """Return the values of the signals without those that are the same as before."""
    plain = [{name: signal.value for name, signal in one.items()} for one in values if len(one) == len(NAMES)]
    return [now for place, now in enumerate(plain) if place == 0 or now != plain[place - 1]]


def test_limits_that_have_shrunk_since_the_planning_refuse_every_stop(world: World, rng: np.random.Generator) -> None:
    """A goal in the middle of the program counts, not the last one only."""
    world.submit([arm()]).result(GUARD)
    one = (-9.0, 9.0, 1.0, 4.0, 40.0)
    limits = JointLimits(("a",), *(np.array([value]) for value in one))
    there, back = plan_ptp([0.0], [2.5], limits), plan_ptp([2.5], [0.0], limits)
    stages = tuple(Stage(plan, (0,), ((0.0, step),)) for step, plan in enumerate((there, back)))
    refused = world.submit([StartMotion((("arm", "a"),), Program(stages, np.zeros(1), 2))]).exception(GUARD)
    assert isinstance(refused, KernelError)
    assert (refused.metadata["joint"], refused.metadata["value"]) == ("a", "2.5")


def test_orders_are_journalled_and_replayed_bit_for_bit(world: World) -> None:
    """A program picks, carries and places between two ticks each; one that finds nothing is aborted."""
    first = world.snapshot
    world.submit([arm(), CreateNodes((part("box", shifted(x=1.0)),))]).result(GUARD)
    one = (-2.0, 2.0, 1.0, 4.0, 40.0)
    there = plan_ptp([0.0], [0.3], JointLimits(("a",), *(np.array([value]) for value in one)))
    stages = [
        Stage(None, (), ((0.0, 0),), orders=(PickPart("arm", "box"),)),
        Stage(there, (0,), ((0.0, 1),)),
        Stage(None, (), ((0.0, 2),), orders=(PlacePart("arm"),)),
        Stage(None, (), ((0.0, 3),), orders=(PlacePart("arm"),)),
    ]
    world.submit([StartMotion((("arm", "a"),), Program(tuple(stages), np.zeros(1), 4))]).result(GUARD)
    world.step(1000).result(GUARD)
    last = world.snapshot
    (motion,) = last.state.ended
    assert motion.cancellation is not None
    assert (motion.phase, motion.cancellation.cause) == (Phase.ABORTED, EndCause.STEP_REFUSED)
    assert motion.cancellation.reason.startswith("step 3: the tool 'arm_gripper' holds")
    assert [entry.author for entry in entries_of(world)[2:]] == ["motion-1"] * 3
    # It was carried: as far about the arm's axis as the arm has gone.
    np.testing.assert_allclose(
        last.world_t(last.structure.node("box").uid)[:2, 3], [np.cos(0.3), np.sin(0.3)], atol=1e-9
    )
    again = replay(first.structure, first.state, entries_of(world), last.state.tick, TICK, world_poses)
    np.testing.assert_array_equal(again.state.q, last.state.q)
    np.testing.assert_array_equal(again.state.parent_t_node, last.state.parent_t_node)
    assert again.structure.node("box").parent == last.structure.node("box").parent
    assert ends(again.state) == ends(last.state)


def test_orders_of_one_tick_are_done_in_turn_and_each_by_itself(world: World) -> None:
    """The second one asks for what the first has taken, and is aborted; nobody else lets a motion go on."""
    world.submit([arm(), arm("other"), CreateNodes((part("box", shifted(x=1.0)),))]).result(GUARD)
    for name in ("arm", "other"):
        stages = (
            Stage(None, (), ((0.0, 0),), wait=Wait(0.1)),
            Stage(None, (), ((0.0, 1),), orders=(PickPart(name, "box"),)),
        )
        world.submit([StartMotion(((name, "a"),), Program(stages, np.zeros(1), 2))]).result(GUARD)
    refused = world.submit([GoOn("motion-1")]).exception(GUARD)
    assert isinstance(refused, KernelError)
    assert "waits for no order" in str(refused)
    world.step(100).result(GUARD)
    first, second = sorted(world.snapshot.state.ended, key=lambda motion: motion.id)
    assert (first.phase, second.phase) == (Phase.SUCCEEDED, Phase.ABORTED)
    assert second.cancellation is not None
    assert second.cancellation.reason.startswith("step 1: the part 'box' is held by the tool 'arm_gripper'")
