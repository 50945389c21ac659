"""Programs over TCP: steps, signals, searches; STEPPED to the tick; errors; clients that vanish; two that meet."""

from __future__ import annotations

from itertools import pairwise

import grpc
import numpy as np
import pytest
from virtualrobot._wire.signal_values import condition, value_message
from virtualrobot.v1 import kernel_pb2, motion_pb2, scene_pb2, signal_pb2

from tests.api.asking import IIWA, PANDA, apply, joints, load, refusal, set_signals
from tests.api.moving import ABORTED, CANCELLED, READY, RUNNING, SUCCEEDED, TICK, circular, finished, linear, motion
from tests.api.reading import matrix, state, step
from tests.kernels import Stubs

WAITING = motion_pb2.MOTION_PHASE_WAITING


def signals(stubs: Stubs, *names: str) -> None:
    """Create signals that are off."""
    made = (scene_pb2.CreateSignal(signal=signal_pb2.Signal(name=name)) for name in names)
    apply(stubs, *(scene_pb2.Command(create_signal=one) for one in made))


def turn_on(stubs: Stubs, name: str, value: bool = True) -> None:
    set_signals(stubs, {name: value})


def move(*moves: motion_pb2.Move, **zone: float) -> motion_pb2.ProgramStep:
    return motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=moves, **zone))  # pyright: ignore[reportArgumentType]


def put(signal: str, value: bool = True, lead: float = 0.0) -> motion_pb2.ProgramStep:
    step = motion_pb2.SetSignalStep(signal=signal, value=value_message(value), lead_seconds=lead)
    return motion_pb2.ProgramStep(set_signal=step)


def wait(signal: str, timeout: float = 0.0) -> motion_pb2.ProgramStep:
    step = motion_pb2.WaitSignalStep(condition=condition(signal, True), timeout_seconds=timeout)
    return motion_pb2.ProgramStep(wait_signal=step)


def dwell(seconds: float) -> motion_pb2.ProgramStep:
    return motion_pb2.ProgramStep(dwell=motion_pb2.DwellStep(seconds=seconds))


def run(
    stubs: Stubs,
    *steps: motion_pb2.ProgramStep,
    policy: motion_pb2.DisconnectPolicy = motion_pb2.DISCONNECT_POLICY_CONTINUE,
) -> motion_pb2.StartMotionResponse:
    """Start a program."""
    return stubs.motion.StartMotion(
        motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(steps=steps), on_disconnect=policy)
    )


def ready(stubs: Stubs, name: str = "arm") -> np.ndarray:
    """Load an arm in a good posture; return world_t_tcp."""
    load(stubs, IIWA, name)
    jump = scene_pb2.SetJointPositions(robot=name, joint_positions=READY)
    apply(stubs, scene_pb2.Command(set_joint_positions=jump))
    return matrix(state(stubs, name).world_t_tcp)


def shifted(pose: np.ndarray, x: float = 0.0, z: float = 0.0) -> np.ndarray:
    result = pose.copy()
    result[:3, 3] += x, 0.0, z
    return result


def state_tick(stubs: Stubs) -> int:
    return stubs.kernel.GetClock(kernel_pb2.GetClockRequest()).stamp.tick


def test_every_step_has_its_tick(stepped: Stubs) -> None:
    """Set at once; 0.1 s are 25 ticks; the moves take what they are planned to, rounded up to one tick together."""
    at = ready(stepped)
    signals(stepped, "a", "b", "c")
    started = run(stepped, put("a"), dwell(0.1), put("b"), move(linear("arm", shifted(at, z=-0.05))), put("c"))
    ask = started.motion
    assert (ask.step, ask.step_count, list(ask.robots)) == (0, 5, ["arm"])
    seen: dict[str, int] = {}
    steps: list[int] = []
    count = 0
    while (now := motion(stepped, ask.id)).phase not in (SUCCEEDED, CANCELLED, ABORTED):
        on = stepped.signal.GetSignals(signal_pb2.GetSignalsRequest()).signals
        for signal in on:
            if signal.value.boolean:
                seen.setdefault(signal.name, count)
        steps.append(now.step)
        assert now.phase == (WAITING if 0 < count < 25 else RUNNING)
        step(stepped)
        count += 1
    assert now.phase == SUCCEEDED
    assert seen == {"a": 1, "b": 25}
    assert stepped.signal.GetSignals(signal_pb2.GetSignalsRequest(names=["c"])).signals[0].value.boolean
    assert count == int(np.ceil(ask.planned_duration_seconds / TICK - 1e-6))
    assert steps == sorted(steps) and set(steps) == {0, 1, 3}
    assert (now.step, now.progress) == (4, 1.0)
    np.testing.assert_allclose(matrix(state(stepped, "arm").world_t_tcp), shifted(at, z=-0.05), atol=1e-5)


def test_a_program_of_two_robots(stepped: Stubs) -> None:
    load(stepped, IIWA, "one")
    load(stepped, PANDA, "two")
    ask = run(
        stepped,
        move(joints("one", lbr_iiwa_joint_1=0.5)),
        move(joints("two", panda_joint1=0.5), joints("one", lbr_iiwa_joint_2=0.5)),
        move(joints("one", lbr_iiwa_joint_1=0.0)),
    ).motion
    assert list(ask.robots) == ["one", "two"]
    assert state(stepped, "two").motion_ids == [ask.id]
    refused = refusal(lambda: run(stepped, move(joints("two", panda_joint1=0.1))))
    assert (refused.reason, refused.metadata["motion"]) == ("ROBOT_BUSY", ask.id)
    assert finished(stepped, ask.id).phase == SUCCEEDED
    assert state(stepped, "two").positions[0] == pytest.approx(0.5, abs=1e-12)
    assert state(stepped, "one").positions[:2] == pytest.approx([0.0, 0.5], abs=1e-12)


def test_every_change_within_a_step_is_told(stepped: Stubs) -> None:
    """Thousands of ticks in one Step: the watch tells each change, in order, with the tick in which it came."""
    load(stepped, IIWA, "arm")
    signals(stepped, "a", "b")
    watch = stepped.signal.WatchSignals(signal_pb2.WatchSignalsRequest())
    next(watch)
    turn = (put("a"), dwell(0.02), put("b"), put("a", False), dwell(0.02), put("b", False))
    ask = run(stepped, *(turn * 20)).motion
    first = state_tick(stepped)
    step(stepped, 1000)
    assert motion(stepped, ask.id).phase == SUCCEEDED
    told: list[tuple[int, str, bool]] = []
    while len(told) < 80:
        response = next(watch)
        told += [(response.stamp.tick - first, signal.name, signal.value.boolean) for signal in response.signals]
    watch.cancel()
    changes = [("a", True), ("b", True), ("a", False), ("b", False)]
    assert all(before[0] <= after[0] for before, after in pairwise(told))
    by_tick: dict[int, set[tuple[str, bool]]] = {}
    for tick, name, value in told:
        by_tick.setdefault(tick, set()).add((name, value))
    expected: dict[int, set[tuple[str, bool]]] = {}
    for turn in range(20):
        # A dwell of 0.02 s is 5 ticks; what is set after it is set in its last tick.
        begin = max(1, 10 * turn)
        for tick, change in zip((begin, 10 * turn + 5, 10 * turn + 5, 10 * turn + 10), changes, strict=True):
            expected.setdefault(tick, set()).add(change)
    assert by_tick == expected


def test_two_programs_shake_hands(stepped: Stubs) -> None:
    load(stepped, IIWA, "giver")
    load(stepped, PANDA, "taker")
    signals(stepped, "ready", "taken")
    giver = run(stepped, move(joints("giver", lbr_iiwa_joint_1=0.3)), put("ready"), wait("taken"),
                move(joints("giver", lbr_iiwa_joint_1=0.0))).motion  # fmt: skip
    taker = run(stepped, wait("ready"), move(joints("taker", panda_joint1=0.3)), put("taken")).motion
    order: list[tuple[int, int]] = []
    while (one := motion(stepped, giver.id)).phase != SUCCEEDED:
        other = motion(stepped, taker.id)
        order.append((one.step, other.step))
        step(stepped)
    # The giver waits (2) as long as the taker moves (1), and goes on (3) when that is done (2).
    seen = [pair for pair, after in zip(order, [*order[1:], None], strict=True) if pair != after]
    assert seen == [(0, 0), (2, 0), (2, 1), (2, 2), (3, 2)] or seen == [(0, 0), (2, 0), (2, 1), (3, 2)]
    assert motion(stepped, taker.id).phase == SUCCEEDED


def test_a_wait_that_takes_too_long(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    signals(stepped, "go", "later")
    ask = run(stepped, move(joints("arm", lbr_iiwa_joint_1=0.1)), wait("go", 0.5), put("later")).motion
    ended = finished(stepped, ask.id)
    assert (ended.phase, ended.end_cause) == (ABORTED, motion_pb2.END_CAUSE_SIGNAL_TIMEOUT)
    assert ended.end_reason == "step 1: the signal 'go' was not on within 0.5 s"
    assert ended.step == 1
    assert not stepped.signal.GetSignals(signal_pb2.GetSignalsRequest(names=["later"])).signals[0].value.boolean
    removed = scene_pb2.Command(remove_signal=scene_pb2.RemoveSignal(name="go"))
    apply(stepped, removed)


def test_a_search_finds_and_does_not_find(stepped: Stubs) -> None:
    at = ready(stepped)
    signals(stepped, "touch")
    down = linear("arm", shifted(at, z=-0.1))
    down.linear.until.CopyFrom(condition("touch", True))
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[down]), on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE
    )
    ask = stepped.motion.StartMotion(request).motion
    assert not ask.HasField("search")
    step(stepped, 60)
    turn_on(stepped, "touch")
    there = matrix(state(stepped, "arm").world_t_tcp)
    tick = state_tick(stepped)
    positions = list(state(stepped, "arm").positions)
    ended = finished(stepped, ask.id)
    assert (ended.phase, ended.search.found, ended.step_count) == (SUCCEEDED, True, 0)
    assert ended.search.time_seconds == pytest.approx(tick * TICK)
    np.testing.assert_allclose(matrix(ended.search.world_t_tcp), there, atol=1e-12)
    assert sorted(ended.search.joint_positions.values()) == sorted(positions)
    # Braked on the line: below what was found, above the goal, and on the line to 0.01 mm.
    end = matrix(state(stepped, "arm").world_t_tcp)
    assert at[2, 3] - 0.1 < end[2, 3] < there[2, 3]
    np.testing.assert_allclose(end[:2, 3], at[:2, 3], atol=1e-5)
    turn_on(stepped, "touch", False)
    ended = finished(stepped, stepped.motion.StartMotion(request).motion.id)
    assert (ended.phase, ended.search.found) == (SUCCEEDED, False)
    np.testing.assert_allclose(matrix(ended.search.world_t_tcp)[2, 3], at[2, 3] - 0.1, atol=1e-5)


def test_a_search_on_an_arc_ends_on_it(stepped: Stubs) -> None:
    """A half circle of radius 5 cm about the start shifted by that, in the plane of x and z."""
    at = ready(stepped)
    signals(stepped, "touch")
    arc = circular("arm", shifted(at, x=-0.1), via=shifted(at, x=-0.05, z=-0.05)[:3, 3])
    arc.circular.until.CopyFrom(condition("touch", True))
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[arc]), on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE
    )
    ask = stepped.motion.StartMotion(request).motion
    step(stepped, 60)
    turn_on(stepped, "touch")
    there = matrix(state(stepped, "arm").world_t_tcp)
    ended = finished(stepped, ask.id)
    assert (ended.phase, ended.search.found) == (SUCCEEDED, True)
    np.testing.assert_allclose(matrix(ended.search.world_t_tcp), there, atol=1e-12)
    end = matrix(state(stepped, "arm").world_t_tcp)
    for place in (there, end):
        offset = (place - shifted(at, x=-0.05))[:3, 3]
        assert np.linalg.norm(offset) == pytest.approx(0.05, abs=1e-5)
    assert at[0, 3] - 0.1 < end[0, 3] < there[0, 3] < at[0, 3]


def test_a_waiting_program_makes_way_at_once(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    signals(stepped, "go")
    waiting = run(stepped, wait("go"), move(joints("arm", lbr_iiwa_joint_1=0.1))).motion
    step(stepped, 3)
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(steps=[move(joints("arm", lbr_iiwa_joint_1=0.2))]),
        busy_policy=motion_pb2.BUSY_POLICY_PREEMPT,
        on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE,
    )
    ask = stepped.motion.StartMotion(request).motion
    ended = motion(stepped, waiting.id)
    assert (ended.phase, ended.end_cause) == (CANCELLED, motion_pb2.END_CAUSE_PREEMPTED)
    assert finished(stepped, ask.id).phase == SUCCEEDED


def test_a_client_that_vanishes_leaves_no_waiting_program(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    signals(stubs, "go")
    ask = run(stubs, wait("go"), move(joints("arm", lbr_iiwa_joint_1=0.1)), policy=motion_pb2.DISCONNECT_POLICY_STOP)
    # Nobody watches it: after the grace of one second it is cancelled.
    for response in stubs.motion.WatchMotion(motion_pb2.WatchMotionRequest(id=ask.motion.id)):
        assert response.motion.id == ask.motion.id
        break
    last = None
    while last is None or last.phase not in (SUCCEEDED, CANCELLED, ABORTED):
        last = motion(stubs, ask.motion.id)
    assert (last.phase, last.end_cause) == (ABORTED, motion_pb2.END_CAUSE_UNWATCHED)


def radius_step(radius: float) -> motion_pb2.ProgramStep:
    """Return a step with a controller's zone."""
    step = move(joints("arm"))
    step.move.blend_radius.radius_meters = radius
    return step


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        ([motion_pb2.ProgramStep()], "steps[0] does not say what to do; give one of move, set_signal, wait_signal"),
        ([move()], "steps[0].move.moves is empty"),
        ([dwell(0.0)], "steps[0].dwell.seconds must be above 0 and at most 86400, a day, not 0"),
        ([dwell(1e300)], "steps[0].dwell.seconds must be above 0 and at most 86400, a day, not 1e+300"),
        ([dwell(float("nan"))], "steps[0].dwell.seconds must be a finite number"),
        ([wait("go", -1.0)], "steps[0].wait_signal.timeout_seconds must be 0 (never) or above"),
        ([wait("")], "steps[0].wait_signal.condition.signal is empty"),
        ([put("")], "steps[0].set_signal.signal is empty"),
        ([put("a", lead=-0.1)], "steps[0].set_signal.lead_seconds must be 0 or above, not -0.1"),
        ([put("a", lead=float("nan"))], "steps[0].set_signal.lead_seconds must be a finite number"),
        ([move(joints("arm"), blend_percent=51.0)], "blend_percent must be above 0 and at most 50, not 51"),
        ([move(joints("arm"), blend_distance_meters=-0.1)], "blend_distance_meters must be above 0, not -0.1"),
        (
            [radius_step(0.0)],
            "blend_radius.radius_meters must be above 0, not 0",
        ),
    ],
)
def test_a_wrong_step_is_named(stepped: Stubs, steps: list[motion_pb2.ProgramStep], words: str) -> None:
    refused = refusal(lambda: run(stepped, *steps))
    assert (refused.code, refused.reason) == (grpc.StatusCode.INVALID_ARGUMENT, "INVALID_ARGUMENT")
    assert refused.metadata["step"] == "0"
    assert words in refused.message


def test_nothing_moves_when_a_step_cannot_be_planned(stepped: Stubs) -> None:
    at = ready(stepped)
    signals(stepped, "a")
    far = shifted(at, x=5.0)
    near = linear("arm", shifted(at, z=-0.05))
    refused = refusal(lambda: run(stepped, put("a"), move(near), move(linear("arm", far))))
    assert (refused.reason, refused.metadata["step"]) == ("UNREACHABLE", "2")
    assert refused.message.startswith("step 2: ")
    refused = refusal(lambda: run(stepped, dwell(0.1), wait("b")))
    assert (refused.reason, refused.metadata["step"]) == ("UNKNOWN_NAME", "1")
    step(stepped, 10)
    assert not state(stepped, "arm").motion_ids
    assert not stepped.signal.GetSignals(signal_pb2.GetSignalsRequest(names=["a"])).signals[0].value.boolean


def test_a_program_file_is_read(stepped: Stubs) -> None:
    text = "schema_version: 1\nsteps:\n  - dwell: {seconds: 0.1}\n"
    request = motion_pb2.ReadProgramRequest(text=text)
    assert stepped.motion.ReadProgram(request).spec == motion_pb2.MotionSpec(steps=[dwell(0.1)])
    bad = motion_pb2.ReadProgramRequest(text=text.replace("dwell", "dwel"), uri="cell.yaml")
    refused = refusal(lambda: stepped.motion.ReadProgram(bad))
    assert refused.reason == "MALFORMED_FILE"
    assert refused.message.startswith("cell.yaml:3: steps[0]: there is no field 'dwel'; did you mean 'dwell'?")


def test_clearing_the_world_ends_a_program(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    signals(stepped, "go")
    ask = run(stepped, wait("go"), move(joints("arm", lbr_iiwa_joint_1=0.1))).motion
    step(stepped, 5)
    removed = scene_pb2.Command(remove_signal=scene_pb2.RemoveSignal(name="go"))
    refused = refusal(lambda: apply(stepped, removed))
    assert (refused.reason, refused.metadata["motion"]) == ("WRONG_STATE", ask.id)
    stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text="schema_version: 1\n"))
    ended = motion(stepped, ask.id)
    assert (ended.phase, ended.end_cause) == (CANCELLED, motion_pb2.END_CAUSE_WORLD_CLEARED)
    step(stepped, 5)


def test_a_renamed_robot_goes_on(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    signals(stepped, "go")
    ask = run(stepped, move(joints("arm", lbr_iiwa_joint_1=0.2)), wait("go"), move(joints("arm", lbr_iiwa_joint_2=0.2)))
    step(stepped, 20)
    update = scene_pb2.UpdateNode(name="arm")
    update.node.name = "leg"
    update.update_mask.paths.append("name")
    apply(stepped, scene_pb2.Command(update_node=update))
    turn_on(stepped, "go")
    ended = finished(stepped, ask.motion.id)
    assert (ended.phase, list(ended.robots)) == (SUCCEEDED, ["leg"])
    assert list(state(stepped, "leg").positions[:2]) == pytest.approx([0.2, 0.2], abs=1e-12)
