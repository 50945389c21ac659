"""Steps appended to open programs over TCP: joined early, starved, at random moments, in all phases, and refused."""

from __future__ import annotations

import re

import numpy as np
import pytest
from virtualrobot.v1 import motion_pb2, robot_pb2, signal_pb2

from tests.api.asking import PANDA, joints, load, refusal, start
from tests.api.moving import ABORTED, CANCELLED, PAUSED, RUNNING, SUCCEEDED, TICK, linear, motion
from tests.api.reading import state, step, values
from tests.api.test_motion import cancel
from tests.api.test_program import WAITING, dwell, move, put, ready, run, shifted, signals, wait
from tests.kernels import Stubs
from tests.tiers import Draws

STARVED = motion_pb2.MOTION_PHASE_STARVED
DROPPED = motion_pb2.PLAN_NOTE_KIND_ZONE_DROPPED
Step = motion_pb2.ProgramStep


def opened(stubs: Stubs, *steps: Step) -> str:
    """Start an open program that goes on without a watch; return its id."""
    leave = motion_pb2.DISCONNECT_POLICY_CONTINUE
    request = motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(steps=steps), on_disconnect=leave, open=True)
    return stubs.motion.StartMotion(request).motion.id


def append(
    stubs: Stubs, id: str, *steps: Step, last: bool = False, expected: int | None = None
) -> motion_pb2.AppendMotionResponse:
    """Append steps."""
    return stubs.motion.AppendMotion(
        motion_pb2.AppendMotionRequest(id=id, steps=steps, last=last, expected_step_count=expected)
    )


def to(pose: np.ndarray, percent: float = 25.0) -> Step:
    """Return a step that goes straight to a pose, with a zone."""
    return move(linear("arm", pose), blend_percent=percent)


def square(at: np.ndarray) -> list[np.ndarray]:
    """Return poses whose lines from one to the next meet at 120°: of a zigzag downwards."""
    return [shifted(at, x=0.1 * (place % 2), z=-0.06 * (place + 1)) for place in range(4)]


def turn(angle: float, percent: float = 30.0) -> Step:
    """Return a step that turns the first joint, with a zone."""
    return move(joints("arm", lbr_iiwa_joint_1=angle), blend_percent=percent)


def phase(stubs: Stubs, id: str) -> int:
    return motion(stubs, id).phase


def until(stubs: Stubs, id: str, *phases: int) -> int:
    """Step until a motion is in one of these phases; return the number of ticks."""
    for count in range(20_000):
        if phase(stubs, id) in phases:
            return count
        step(stubs)
    raise AssertionError(f"it is {motion(stubs, id)}")


@pytest.mark.long
def test_what_is_appended_early_is_the_whole_program_at_once(stepped: Stubs) -> None:
    at = ready(stepped)
    steps = [to(pose) for pose in square(at)]
    request = motion_pb2.PlanMotionRequest(spec=motion_pb2.MotionSpec(steps=steps), sample_seconds=TICK)
    whole = stepped.motion.PlanMotion(request)
    planned = values(whole.robots[0].positions)
    id, seen = opened(stepped, *steps[:2]), [list(state(stepped, "arm").positions)]
    left = steps[2:]
    while phase(stepped, id) not in (SUCCEEDED, CANCELLED, ABORTED):
        if left and motion(stepped, id).step >= 2 - len(left):
            answer = append(stepped, id, left.pop(0), last=not left, expected=4 - len(left) - 1)
            dropped = [note.step for note in answer.notes if note.kind == DROPPED]
            assert dropped == ([3] if not left else [])  # nothing follows the last one
        step(stepped)
        seen.append(list(state(stepped, "arm").positions))
    ended = motion(stepped, id)
    assert (ended.phase, ended.step, ended.step_count, ended.progress) == (SUCCEEDED, 3, 4, 1.0)
    assert abs(len(seen) - len(planned)) <= 3
    # The same path: each place that it passes is one of the whole program's, to what a tick's chord is off it.
    way = np.array(seen)
    assert max(np.abs(planned - q).max(axis=1).min() for q in way) < 0.003


@pytest.mark.long
def test_a_program_that_starves_holds_its_joints_and_goes_on(stepped: Stubs) -> None:
    ready(stepped)
    id = opened(stepped, turn(0.2))
    ticks = until(stepped, id, STARVED)
    told = motion(stepped, id)
    assert (told.step, told.step_count, told.progress, ticks) == (0, 1, 1.0, ticks)
    step(stepped, 50)
    assert phase(stepped, id) == STARVED
    assert refusal(lambda: start(stepped, joints("arm", lbr_iiwa_joint_1=0.0))).reason == "ROBOT_BUSY"
    answer = append(stepped, id, dwell(0.02), turn(0.4))
    assert (answer.motion.phase, answer.motion.step_count) == (RUNNING, 3)
    (note,) = answer.notes
    assert (note.kind, note.step) == (DROPPED, 0) and "step 1 waits" in note.message
    step(stepped)
    assert phase(stepped, id) == WAITING
    until(stepped, id, STARVED)
    answer = append(stepped, id, turn(0.1))
    assert [note.step for note in answer.notes] == [2] and "stands there already" in answer.notes[0].message
    step(stepped, 5)
    append(stepped, id, last=True)
    until(stepped, id, SUCCEEDED)
    assert state(stepped, "arm").positions[0] == pytest.approx(0.1)
    id = opened(stepped, turn(0.2))
    until(stepped, id, STARVED)
    append(stepped, id, last=True)
    assert until(stepped, id, SUCCEEDED) == 1


@pytest.mark.parametrize("ticks", [0, 5, 20_000])
def test_a_program_goes_on_after_a_step_without_a_zone_that_was_joined(stepped: Stubs, ticks: int) -> None:
    """The step is reached at rest, whether the next one comes at once, while it moves, or when it stands."""
    ready(stepped)
    id = opened(stepped, turn(0.5))
    assert not append(stepped, id, move(joints("arm", lbr_iiwa_joint_1=0.7))).notes
    for _ in range(ticks):
        if phase(stepped, id) == STARVED:
            break
        step(stepped)
    answer = append(stepped, id, turn(0.6), last=True)
    assert [note.step for note in answer.notes] == [2]  # nothing follows the last one
    turned = []
    while phase(stepped, id) != SUCCEEDED:
        step(stepped)
        turned.append(state(stepped, "arm").positions[0])
    assert turned[-1] == pytest.approx(0.6)
    assert ticks > 5 or max(turned) == pytest.approx(0.7, abs=1e-6)  # between two ticks it is nearer still


def test_a_starved_program_is_paused_cancelled_and_left(stepped: Stubs) -> None:
    ready(stepped)
    id = opened(stepped, turn(0.2))
    until(stepped, id, STARVED)
    assert stepped.motion.PauseMotion(motion_pb2.PauseMotionRequest(id=id)).motion.phase == PAUSED
    append(stepped, id, turn(0.4))
    step(stepped, 50)
    assert phase(stepped, id) == PAUSED
    stepped.motion.ResumeMotion(motion_pb2.ResumeMotionRequest(id=id))
    until(stepped, id, STARVED)
    assert state(stepped, "arm").positions[0] == pytest.approx(0.4)
    stepped.motion.PauseMotion(motion_pb2.PauseMotionRequest(id=id))
    assert stepped.motion.ResumeMotion(motion_pb2.ResumeMotionRequest(id=id)).motion.phase == STARVED
    cancel(stepped, id)
    assert phase(stepped, id) == CANCELLED
    id = opened(stepped, turn(-0.4))
    step(stepped, 20)
    cancel(stepped, id)
    assert refusal(lambda: append(stepped, id, turn(0.0))).message.endswith("it stops")
    until(stepped, id, CANCELLED)


@pytest.mark.long
def test_appends_at_any_moment_keep_limits_and_jump_nowhere(
    stepped: Stubs, rng: np.random.Generator, draws: Draws
) -> None:
    at = ready(stepped)
    limits = [joint.limits for joint in stepped.robot.GetRobot(robot_pb2.GetRobotRequest(name="arm")).joints]
    velocity, acceleration = (np.array([getattr(one, f) for one in limits]) for f in ("velocity", "acceleration"))
    joined = 0
    for _ in range(draws(5)):
        id = opened(stepped, to(shifted(at, *rng.uniform(-0.1, 0.1, 2))))
        rows: list[list[float]] = []

        def tick(rows: list[list[float]] = rows) -> None:
            now = state(stepped, "arm")
            rows.append([*now.positions, *now.velocities])
            step(stepped)

        for left in range(4, -1, -1):
            for _ in range(int(rng.integers(1, 120))):
                tick()
            if rng.random() < 0.3:
                stepped.motion.PauseMotion(motion_pb2.PauseMotionRequest(id=id))
            line = to(shifted(at, *rng.uniform(-0.1, 0.1, 2)))
            following = turn(float(rng.uniform(-0.4, 0.4))) if rng.random() < 0.3 else line
            before = state(stepped, "arm").positions
            answer = append(stepped, id, *([following] if left else []), last=not left)
            joined += bool(left) and not answer.notes
            assert state(stepped, "arm").positions == before
            stepped.motion.ResumeMotion(motion_pb2.ResumeMotionRequest(id=id))
        while phase(stepped, id) != SUCCEEDED:
            tick()
        q, v = np.hsplit(np.array(rows), 2)
        assert np.abs(v / velocity).max() <= 1.0 + 1e-6
        assert np.abs(np.diff(v, axis=0) / TICK / acceleration).max() <= 1.005
        # Positions are the integral of the velocities, by the trapezoidal rule to the jerk times a tick cubed over 12.
        assert np.abs(np.diff(q, axis=0) - 0.5 * TICK * (v[1:] + v[:-1])).max() < 1e-4
    assert joined


@pytest.mark.parametrize(("appended", "words"), [(turn(0.4), ""), (put("a"), ""), (wait("a", timeout=1.0), "waits")])
def test_each_kind_of_step_follows(stepped: Stubs, appended: Step, words: str) -> None:
    ready(stepped)
    signals(stepped, "a")
    id = opened(stepped, turn(0.2))
    answer = append(stepped, id, appended)
    assert [words in note.message for note in answer.notes] == [True] * bool(words)
    until(stepped, id, STARVED, WAITING)
    assert motion(stepped, id).step_count == 2


def test_signals_between_joined_steps_are_set_in_the_middle_of_the_zone(stepped: Stubs) -> None:
    ready(stepped)
    signals(stepped, "a")
    id = opened(stepped, turn(0.4))
    step(stepped, 5)
    assert not append(stepped, id, put("a"), turn(0.8)).notes
    was = 0.0
    while not dict_of(stepped)["a"]:
        step(stepped)
        was = state(stepped, "arm").velocities[0]
    assert was > 0.1 and motion(stepped, id).step == 2
    until(stepped, id, STARVED)


def dict_of(stubs: Stubs) -> dict[str, bool]:
    return {one.name: one.value.boolean for one in stubs.signal.GetSignals(signal_pb2.GetSignalsRequest()).signals}


def test_what_cannot_be_appended_is_refused_and_changes_nothing(stepped: Stubs) -> None:
    at = ready(stepped)
    closed = run(stepped, turn(0.1)).motion.id
    refused = refusal(lambda: append(stepped, closed, turn(0.2)))
    assert refused.reason == "WRONG_STATE" and "was not started as an open program" in refused.message
    until(stepped, closed, SUCCEEDED)
    assert refusal(lambda: append(stepped, closed, turn(0.2))).message.endswith("has ended")
    assert refusal(lambda: append(stepped, "motion-99", turn(0.2))).reason == "UNKNOWN_NAME"
    id = opened(stepped, turn(0.2), dwell(0.1))
    for steps, reason, words in (
        ([], "INVALID_ARGUMENT", "nothing to append"),
        ([dwell(0.1), to(shifted(at, x=5.0))], "UNREACHABLE", "step 3: "),
        ([wait("none")], "UNKNOWN_NAME", "step 2: "),
        ([Step()], "INVALID_ARGUMENT", "steps[2] does not say what to do"),
        ([turn(0.1), dwell(-1.0)], "INVALID_ARGUMENT", "steps[3].dwell.seconds must be above 0"),
    ):
        refused = refusal(lambda steps=steps: append(stepped, id, *steps))
        assert refused.reason == reason and words in refused.message
        if number := re.search(r"steps?[ \[](\d)", words):  # that of the program, which has two steps before
            assert refused.metadata["step"] == number[1]
    refused = refusal(lambda: append(stepped, id, turn(0.3), expected=3))
    assert (refused.reason, refused.metadata["step_count"]) == ("WRONG_STATE", "2")
    assert motion(stepped, id).step_count == 2
    append(stepped, id, turn(0.3), last=True)
    assert "has been closed" in refusal(lambda: append(stepped, id, turn(0.4))).message
    until(stepped, id, SUCCEEDED)
    moves = motion_pb2.MotionSpec(moves=[joints("arm", lbr_iiwa_joint_1=0.0)])
    refused = refusal(lambda: stepped.motion.StartMotion(motion_pb2.StartMotionRequest(spec=moves, open=True)))
    assert refused.metadata["field"] == "open"


def test_an_append_that_is_repeated_appends_once(stepped: Stubs) -> None:
    ready(stepped)
    id = opened(stepped, turn(0.2))
    request = motion_pb2.AppendMotionRequest(id=id, steps=[turn(0.4)], request_id="once")
    first = stepped.motion.AppendMotion(request)
    step(stepped)
    assert stepped.motion.AppendMotion(request) == first
    assert motion(stepped, id).step_count == 2


def test_joints_that_the_program_has_not_moved_must_be_free_and_join_it(stepped: Stubs) -> None:
    ready(stepped)
    load(stepped, PANDA, "other")
    id = opened(stepped, turn(0.2))
    going = start(stepped, joints("other", 0.1, panda_joint1=0.5))
    there = move(joints("other", panda_joint1=0.2))
    assert refusal(lambda: append(stepped, id, there)).reason == "ROBOT_BUSY"
    cancel(stepped, going.id)
    until(stepped, going.id, CANCELLED)
    answer = append(stepped, id, there, last=True)
    assert list(answer.motion.robots) == ["arm", "other"]
    until(stepped, id, SUCCEEDED)
    assert state(stepped, "other").positions[0] == pytest.approx(0.2)
    assert state(stepped, "arm").positions[0] == pytest.approx(0.2)


def test_after_a_change_of_the_structure_a_step_begins_from_rest(stepped: Stubs) -> None:
    ready(stepped)
    id = opened(stepped, turn(0.4))
    step(stepped, 5)
    load(stepped, PANDA, "bystander")
    (note,) = append(stepped, id, turn(0.8)).notes
    assert (note.kind, note.step) == (DROPPED, 0) and "the world has changed" in note.message
    until(stepped, id, STARVED)
    assert state(stepped, "arm").positions[0] == pytest.approx(0.8)
