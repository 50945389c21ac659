"""Programs from wishes: each step from where the last one ends, signals in their places, errors that name the step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.signals import Condition
from virtualrobot_kernel.planning.moves import Linear, PointToPoint, ToolStateMove
from virtualrobot_kernel.planning.notes import NoteKind
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import (
    DwellStep,
    MotionSpec,
    MoveStep,
    SetSignalStep,
    SpeedStep,
    Step,
    WaitSignalStep,
    Zone,
)
from virtualrobot_kernel.world.affected_robots import affected_robots
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import CreateSignal, RemoveSignal, StartMotion
from virtualrobot_kernel.world.state import EndCause, Signal
from virtualrobot_sdk.poses import inverse

from tests.unit.planning.cell import READY, cell, chain, pictured, tcp
from tests.unit.world.builders import after, shifted, ticked


def world() -> Change:
    """Return the cell with three signals that are off."""
    return after(cell(), *(CreateSignal(Signal(name, False)) for name in ("grip", "part", "touch")))


def planned(change: Change, *steps: Step) -> StartMotion:
    """Return the command that starts a program."""
    return plan_motion(pictured(change), MotionSpec(steps=steps), chain).command


def line(change: Change, x: float = 0.0, z: float = 0.0, until: Condition | None = None) -> Linear:
    """Return a line of the arm's tip from where it is at the start, by x and z in the world."""
    goal = tcp(change)
    goal[:3, 3] += x, 0.0, z
    return Linear("arm", PoseGoal(goal), until=until)


def belt(position: float) -> PointToPoint:
    return PointToPoint("belt", {"slide": position})


def step(*moves: Linear | PointToPoint | ToolStateMove, zone: Zone | None = None) -> MoveStep:
    return MoveStep(moves, zone)


def to_end(change: Change, ticks: int = 5000) -> Change:
    """Return the world after its motions have ended."""
    for _ in range(ticks):
        if not change.state.motions:
            return change
        change = ticked(change)
    raise AssertionError("the motions don't end")


def test_each_step_begins_where_the_last_one_ends() -> None:
    """Down, along and up again, with a tray that carries the goal of the last line: the tip is where the goals are."""
    change = world()
    tray = pictured(change).world_t(change.structure.node("belt.tray").uid)
    above = inverse(tray) @ tcp(change)
    steps = (
        step(line(change, z=-0.1)),
        step(line(change, x=0.1, z=-0.1)),
        step(belt(0.1)),
        step(Linear("arm", PoseGoal(above, "belt.tray"))),
    )
    command = planned(change, *steps)
    assert command.program.step_count == 4
    assert [stage.steps for stage in command.program.stages] == [((0.0, place),) for place in range(4)]
    end = to_end(after(change, command))
    np.testing.assert_allclose(tcp(end), tcp(change) @ np.eye(4) + shifted(x=0.1) - np.eye(4), atol=1e-6)
    (motion,) = end.state.ended
    assert motion.running.steps_done == 4


def test_signals_between_rounded_moves_are_set_in_the_zone() -> None:
    change = world()
    steps = (
        step(line(change, x=0.15), zone=Zone(percent=50.0)),
        SetSignalStep("grip", True),
        step(line(change, x=0.15, z=-0.15), zone=Zone(percent=50.0)),
        SetSignalStep("grip", False),
        SetSignalStep("part", True),
        step(line(change, z=-0.15)),
        SetSignalStep("touch", True),
    )
    result = plan_motion(pictured(change), MotionSpec(steps=steps), chain)
    moving, touch = result.command.program.stages
    assert [number for _, number in moving.steps] == [0, 2, 5]
    times = {number: time for time, number in moving.steps}
    assert moving.marks == (
        (times[2], "grip", True),
        (times[5], "grip", False),
        (times[5], "part", True),
    )
    assert (touch.plan, touch.marks, touch.steps) == (None, ((0.0, "touch", True),), ((0.0, 6),))
    assert not result.notes
    going = after(change, result.command)
    while going.state.motions:
        on = going.state.signals["grip"].value
        done = going.state.motions[0].running.steps_done
        assert on == (2 <= done < 5)
        going = ticked(going)
    assert going.state.signals["touch"].value


def test_signals_with_a_lead_are_set_before_their_place() -> None:
    """In a zone, at rest and before any way; none before the robot's last standstill."""
    change = world()
    steps = (
        SetSignalStep("part", True, lead=0.5),
        step(line(change, x=0.15), zone=Zone(percent=50.0)),
        SetSignalStep("grip", True),
        SetSignalStep("part", False, lead=0.25),
        step(line(change, x=0.15, z=-0.15)),
        SpeedStep("", 0.5),
        SetSignalStep("touch", True, lead=0.125),
        SetSignalStep("part", True, lead=100.0),
        DwellStep(0.1),
        SetSignalStep("grip", False, lead=0.05),
    )
    at_once, moving, *rest = planned(change, *steps).program.stages
    times, end = {number: time for time, number in moving.steps}, moving.duration
    assert at_once.marks == ((0.0, "part", True),)
    assert moving.marks == (
        (0.0, "part", True),
        (times[4] - 0.25, "part", False),
        (times[4], "grip", True),
        (end - 0.125, "touch", True),
    )
    assert [stage.marks for stage in rest] == [(), (), (), (), ((0.0, "grip", False),)]


@pytest.mark.parametrize(
    ("following", "why"),
    [
        ((), "no moves follow"),
        ((DwellStep(0.1),), "step 1 waits"),
        ((SetSignalStep("grip", True), WaitSignalStep(Condition("part"))), "step 2 waits"),
    ],
)
def test_a_zone_before_nothing_to_go_over_into_is_dropped(following: Sequence[Step], why: str) -> None:
    change = world()
    wish = MotionSpec(steps=(step(line(change, x=0.1), zone=Zone(meters=0.03)), *following))
    (note,) = plan_motion(pictured(change), wish, chain).notes
    assert (note.kind, note.step, note.robot, note.wanted, note.kept) == (NoteKind.ZONE_DROPPED, 0, "arm", 0.03, 0.0)
    assert why in note.message


def test_a_search_is_reached_at_rest() -> None:
    change = world()
    first = step(line(change, x=0.1), zone=Zone(meters=0.03))
    wish = MotionSpec(steps=(first, step(line(change, x=0.1, z=-0.1, until=Condition("touch")))))
    result = plan_motion(pictured(change), wish, chain)
    assert [stage.until for stage in result.command.program.stages] == [None, Condition("touch")]
    assert (result.command.searcher, result.notes[0].kind) == ("arm", NoteKind.ZONE_DROPPED)


def far(change: Change) -> Linear:
    return line(change, x=10.0)


@pytest.mark.parametrize(
    ("make", "reason", "words"),
    [
        (lambda c: (DwellStep(0.1), step(far(c))), Reason.UNREACHABLE, "step 1: "),
        (lambda c: (SetSignalStep("grip", True), SetSignalStep("gripp", True)), Reason.UNKNOWN_NAME, "'gripp'"),
        (lambda c: (DwellStep(0.1), WaitSignalStep(Condition("hello"))), Reason.UNKNOWN_NAME, "'hello'"),
        (
            lambda c: (DwellStep(0.1), step(line(c, x=0.1, until=Condition("nothing")))),
            Reason.UNKNOWN_NAME,
            "'nothing'",
        ),
        (lambda c: (DwellStep(0.1), step(belt(3.0))), Reason.LIMIT_EXCEEDED, "step 1: "),
        (lambda c: (DwellStep(0.1), step(belt(0.1), belt(0.2))), Reason.INVALID_ARGUMENT, "step 1: two moves"),
        (
            lambda c: (DwellStep(0.1), step(line(c, z=-0.1, until=Condition("touch"))), DwellStep(0.1)),
            Reason.INVALID_ARGUMENT,
            "step 1: a program may search in its last step only, which is step 2",
        ),
    ],
)
def test_errors_name_the_step(make: object, reason: Reason, words: str) -> None:
    change = world()
    with pytest.raises(KernelError) as refused:
        planned(change, *make(change))  # pyright: ignore[reportCallIssue]
    assert (refused.value.reason, refused.value.metadata["step"]) == (reason, "1")
    assert str(refused.value).startswith("step 1: ")
    assert words in str(refused.value)


def test_a_program_has_at_most_ten_thousand_steps() -> None:
    change = world()
    assert planned(change, *[SetSignalStep("grip", True)] * 10_000).program.step_count == 10_000
    with pytest.raises(KernelError, match="at most 10000 steps, not 10001"):
        planned(change, *[SetSignalStep("grip", True)] * 10_001)
    with pytest.raises(KernelError, match="either moves or steps"):
        plan_motion(pictured(change), MotionSpec((belt(0.1),), (DwellStep(0.1),)), chain)
    with pytest.raises(KernelError, match="at least one move"):
        plan_motion(pictured(change), MotionSpec(), chain)


def test_planning_ends_when_nobody_waits_for_it() -> None:
    change, asked = world(), 0

    def given_up() -> bool:
        nonlocal asked
        asked += 1
        return asked > 3

    wish = MotionSpec(steps=tuple(step(belt(0.01 * n)) for n in range(1000)))
    with pytest.raises(KernelError, match="nobody waits"):
        plan_motion(pictured(change), wish, chain, given_up)
    assert asked == 4


@pytest.mark.parametrize("last", [3, 12, 23, 28])
def test_planning_steps_that_zones_join_ends_too(last: int) -> None:
    """Twenty steps are planned one by one, then the corners between them; no solver is needed for moves to joints."""
    change, asked = world(), 0

    def given_up() -> bool:
        nonlocal asked
        asked += 1
        return asked > last

    steps = tuple(MoveStep((belt(0.1 * (n % 2)),), Zone(percent=20.0)) for n in range(20))
    with pytest.raises(KernelError, match="nobody waits"):
        plan_motion(pictured(change), MotionSpec(steps=steps), chain, given_up)
    assert asked == last + 1


def test_tool_states_are_there_when_their_step_is_done() -> None:
    change = world()
    hand = change.structure.node("hand").uid
    off, on = step(ToolStateMove("arm", "", "off")), step(ToolStateMove("arm", "", "on"))
    steps = (off, step(belt(0.05)), on, step(belt(0.0)))
    going = after(change, planned(change, *steps))
    seen = []
    while going.state.motions:
        going = ticked(going)
        states = (going.state.motions or going.state.ended)[0].running.steps_done, going.state.tool_states[hand]
        seen.append(states)
    assert {state for done, state in seen if done in (1, 2)} == {"off"}
    assert {state for done, state in seen if done in (3, 4)} == {"on"}


def test_a_search_tells_where_it_found_its_signal(rng: np.random.Generator) -> None:
    """The tip as it was at the tick in which the signal was seen, though it brakes for a while."""
    change = world()
    command = planned(change, step(belt(0.05)), step(line(change, z=-0.2, until=Condition("touch"))))
    going = after(change, command)
    while going.state.motions[0].running.steps_done < 1:
        going = ticked(going)
    going = ticked(going, int(rng.integers(20, 120)))
    signals = {**going.state.signals, "touch": Signal("touch", True)}
    touched = replace(going, state=replace(going.state, signals=signals))
    end = to_end(touched)
    search = end.state.ended[0].search
    assert search is not None
    assert (search.found, search.tick) == (True, touched.state.tick)
    np.testing.assert_allclose(search.world_t_tcp, tcp(touched), atol=1e-12)
    robot = change.structure.robots[change.structure.node("arm").uid]
    assert dict(search.joint_positions) == dict(zip(robot.joint_names, touched.state.q[robot.q_slice], strict=True))
    assert tcp(change)[2, 3] - 0.2 < tcp(end)[2, 3] < search.world_t_tcp[2, 3]


def test_a_search_that_finds_nothing_tells_its_goal() -> None:
    change = world()
    end = to_end(after(change, planned(change, step(line(change, z=-0.1, until=Condition("touch"))))))
    search = end.state.ended[0].search
    assert search is not None
    assert (search.found, search.tick) == (False, end.state.tick)
    np.testing.assert_allclose(search.world_t_tcp, tcp(end), atol=1e-12)


def test_a_wait_that_fails_cancels_the_motion_with_its_cause() -> None:
    change = world()
    end = to_end(after(change, planned(change, WaitSignalStep(Condition("part"), 0.2), step(belt(0.1)))))
    (motion,) = end.state.ended
    assert motion.cancellation is not None
    assert (motion.cancellation.cause, motion.end_tick) == (EndCause.SIGNAL_TIMEOUT, 50)
    assert motion.cancellation.reason == "step 0: the signal 'part' was not on within 0.2 s"


def test_a_signal_that_a_program_names_stays() -> None:
    change = world()
    command = planned(change, WaitSignalStep(Condition("part")), step(belt(0.1)))
    going = ticked(after(change, command), 3)
    with pytest.raises(KernelError) as refused:
        after(going, RemoveSignal("part"))
    assert (refused.value.reason, refused.value.metadata["motion"]) == (Reason.WRONG_STATE, "motion-1")
    assert "part" not in after(change, RemoveSignal("part")).state.signals
    with pytest.raises(KernelError) as refused:
        after(change, RemoveSignal("part"), command)
    assert refused.value.reason is Reason.UNKNOWN_NAME
    after(to_end(after(change, planned(change, step(belt(0.1))))), RemoveSignal("part"))


def test_a_program_touches_all_its_robots() -> None:
    change = world()
    command = planned(change, step(belt(0.1)), DwellStep(0.1), step(PointToPoint("arm", READY)))
    both = {change.structure.node("arm").uid, change.structure.node("belt").uid}
    assert affected_robots(pictured(change), [command]) == both
    assert set(after(change, command).state.motions[0].robots) == both
