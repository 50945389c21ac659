"""MotionService: groups, busy robots, watches, ends; steering: pause, resume, cancel, speed."""

from __future__ import annotations

import grpc
import pytest
from virtualrobot.v1 import motion_pb2, scene_pb2

from tests.api.asking import IIWA, PANDA, apply, joints, load, refusal, start
from tests.api.moving import CANCELLED, PAUSED, RUNNING, SUCCEEDED, TICK, finished, motion
from tests.api.reading import state, step
from tests.kernels import Stubs


def test_moves_of_a_group_start_and_end_at_the_same_ticks(stepped: Stubs) -> None:
    load(stepped, IIWA, "long")
    load(stepped, PANDA, "short")
    ask = start(stepped, joints("long", lbr_iiwa_joint_1=2.5), joints("short", panda_joint1=0.2))
    assert list(ask.robots) == ["long", "short"]
    moving = []
    while motion(stepped, ask.id).phase == RUNNING:
        moving.append([any(one.velocities) for one in step(stepped).robots])
    assert all(a and b for a, b in moving[:-1])
    assert moving[-1] == [False, False]
    assert state(stepped, "short").positions[0] == pytest.approx(0.2)


def test_a_busy_robot_is_refused_or_preempted(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    first = start(stepped, joints("arm", 0.2, lbr_iiwa_joint_1=2.0))
    step(stepped, 50)
    refused = refusal(lambda: start(stepped, joints("arm", lbr_iiwa_joint_1=0.0)))
    assert (refused.code, refused.reason) == (grpc.StatusCode.ABORTED, "ROBOT_BUSY")
    assert refused.metadata["motion"] == first.id
    assert motion(stepped, first.id).phase == RUNNING
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[joints("arm", lbr_iiwa_joint_1=0.0)]),
        busy_policy=motion_pb2.BUSY_POLICY_PREEMPT,
        on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE,
    )
    call = stepped.motion.StartMotion.future(request)
    while not call.done():
        step(stepped)
    second = call.result().motion
    ended = motion(stepped, first.id)
    assert ended.phase == CANCELLED
    assert ended.end_reason == "preempted by client at ipv4:127.0.0.1"  # no port: equal runs are equal
    assert ended.end_cause == motion_pb2.END_CAUSE_PREEMPTED
    assert finished(stepped, second.id).phase == SUCCEEDED
    assert state(stepped, "arm").positions[0] == pytest.approx(0.0, abs=1e-12)


def test_preempting_while_time_stands_still_is_refused(stepped: Stubs) -> None:
    """A program with one thread that would step after the start waited for ever."""
    load(stepped, IIWA, "arm")
    first = start(stepped, joints("arm", 0.2, lbr_iiwa_joint_1=2.0))
    step(stepped, 50)
    preempt = motion_pb2.BUSY_POLICY_PREEMPT
    refused = refusal(lambda: start(stepped, joints("arm", lbr_iiwa_joint_1=0.0), busy=preempt))
    assert (refused.reason, refused.metadata["motion"]) == ("WRONG_STATE", first.id)
    assert "step the clock until it has ended" in refused.message
    assert finished(stepped, first.id).phase == CANCELLED
    second = start(stepped, joints("arm", lbr_iiwa_joint_1=0.0), busy=preempt)
    assert finished(stepped, second.id).phase == SUCCEEDED


def test_other_joints_are_not_busy(stepped: Stubs) -> None:
    load(stepped, PANDA, "arm")
    ask = start(stepped, joints("arm", panda_joint1=1.0))
    step(stepped, 20)
    fingers = start(stepped, joints("arm", panda_finger_joint1=0.03))
    assert set(state(stepped, "arm").motion_ids) == {ask.id, fingers.id}
    jump = scene_pb2.SetJointPositions(robot="arm", joint_positions={"panda_joint1": 0.0})
    refused = refusal(lambda: apply(stepped, scene_pb2.Command(set_joint_positions=jump)))
    assert refused.reason == "ROBOT_BUSY"
    assert finished(stepped, fingers.id).phase == SUCCEEDED


def test_a_watch_ends_with_the_end_and_progress_only_grows(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    ask = start(stubs, joints("arm", 0.1, lbr_iiwa_joint_1=1.0))
    messages = list(stubs.motion.WatchMotion(motion_pb2.WatchMotionRequest(id=ask.id, max_rate_hertz=250), timeout=60))
    progress = [message.motion.progress for message in messages]
    assert progress == sorted(progress)
    assert len(set(progress)) > 10
    assert [message.motion.phase for message in messages][-1] == SUCCEEDED
    assert progress[-1] == 1.0
    again = list(stubs.motion.WatchMotion(motion_pb2.WatchMotionRequest(id=ask.id)))
    assert [message.motion.phase for message in again] == [SUCCEEDED], "ended motions are remembered"
    ids = [one.id for one in stubs.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions]
    assert ask.id in ids
    assert not stubs.motion.ListMotions(motion_pb2.ListMotionsRequest(running_only=True)).motions
    rpc = stubs.motion
    for call in (
        lambda: rpc.GetMotion(motion_pb2.GetMotionRequest(id="motion-77777")),
        lambda: rpc.PauseMotion(motion_pb2.PauseMotionRequest(id="motion-77777")),
        lambda: next(rpc.WatchMotion(motion_pb2.WatchMotionRequest(id="motion-77777"))),
    ):
        assert refusal(call).reason == "UNKNOWN_NAME"
    assert refusal(lambda: rpc.PauseMotion(motion_pb2.PauseMotionRequest(id=ask.id))).reason == "WRONG_STATE"


def pause(stubs: Stubs, id: str) -> motion_pb2.Motion:
    return stubs.motion.PauseMotion(motion_pb2.PauseMotionRequest(id=id)).motion


def resume(stubs: Stubs, id: str) -> motion_pb2.Motion:
    return stubs.motion.ResumeMotion(motion_pb2.ResumeMotionRequest(id=id)).motion


def cancel(stubs: Stubs, id: str, reason: str = "") -> motion_pb2.Motion:
    return stubs.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=id, reason=reason)).motion


def slowed(stubs: Stubs, factor: float, robot: str = "") -> None:
    command = scene_pb2.SetSpeedFactor(robot=robot, factor=factor)
    apply(stubs, scene_pb2.Command(set_speed_factor=command))


def test_a_paused_motion_stands_still_and_goes_on(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    ask = start(stepped, joints("arm", 0.2, lbr_iiwa_joint_1=2.0))
    step(stepped, 100)
    assert pause(stepped, ask.id).phase == motion_pb2.MOTION_PHASE_PAUSING
    step(stepped, 500)
    stopped = state(stepped, "arm")
    assert (motion(stepped, ask.id).phase, any(stopped.velocities)) == (PAUSED, False)
    assert 0.0 < stopped.positions[0] < 2.0
    step(stepped, 100)
    assert state(stepped, "arm").positions == stopped.positions
    assert pause(stepped, ask.id).phase == PAUSED, "pausing again changes nothing"
    assert resume(stepped, ask.id).phase == RUNNING
    assert finished(stepped, ask.id).phase == SUCCEEDED
    assert state(stepped, "arm").positions[0] == pytest.approx(2.0, abs=1e-12)


def test_a_cancelled_motion_ends_at_rest_on_its_path(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    ask = start(stepped, joints("arm", 0.2, lbr_iiwa_joint_1=2.0, lbr_iiwa_joint_2=1.0))
    step(stepped, 100)
    assert cancel(stepped, ask.id, "the door is open").phase == motion_pb2.MOTION_PHASE_STOPPING
    ended = finished(stepped, ask.id)
    assert (ended.phase, ended.end_reason) == (CANCELLED, "the door is open")
    assert ended.end_cause == motion_pb2.END_CAUSE_CALL
    now = state(stepped, "arm")
    assert not any(now.velocities)
    assert not now.motion_ids
    assert now.positions[0] == pytest.approx(2.0 * now.positions[1], abs=1e-12), "on the line in joint space"
    assert 0.0 < now.positions[0] < 2.0
    for call in (pause, resume, cancel):
        assert refusal(lambda call=call: call(stepped, ask.id)).reason == "WRONG_STATE"


def test_a_paused_motion_ends_at_once_when_it_is_cancelled(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    ask = start(stepped, joints("arm", 0.2, lbr_iiwa_joint_1=2.0))
    step(stepped, 100)
    pause(stepped, ask.id)
    step(stepped, 500)
    assert cancel(stepped, ask.id).phase == CANCELLED
    assert start(stepped, joints("arm", lbr_iiwa_joint_1=0.0)).phase == RUNNING, "no joint is busy, without any tick"


@pytest.mark.parametrize(("of_all", "of_one"), [(1.0, 1.0), (0.5, 1.0), (1.0, 0.25), (0.5, 0.4)])
def test_speed_factors_multiply(stepped: Stubs, of_all: float, of_one: float) -> None:
    """A law of time: at a constant rate f, a motion of T seconds takes T / f."""
    load(stepped, IIWA, "arm")
    slowed(stepped, of_all)
    slowed(stepped, of_one, "arm")
    assert state(stepped, "arm").speed_factor == of_one
    ask = start(stepped, joints("arm", lbr_iiwa_joint_1=1.0))
    expected = ask.planned_duration_seconds / (of_all * of_one * TICK)
    step(stepped, int(expected) - 1)
    assert motion(stepped, ask.id).phase == RUNNING
    step(stepped, 3)
    assert motion(stepped, ask.id).phase == SUCCEEDED


def test_one_robot_s_factor_leaves_the_others_alone(stepped: Stubs) -> None:
    load(stepped, IIWA, "slow")
    load(stepped, IIWA, "fast")
    slowed(stepped, 0.1, "slow")
    moves = [start(stepped, joints(name, lbr_iiwa_joint_1=1.0)) for name in ("slow", "fast")]
    step(stepped, round(moves[1].planned_duration_seconds / TICK) + 1)
    assert [motion(stepped, one.id).phase for one in moves] == [RUNNING, SUCCEEDED]
    assert refusal(lambda: slowed(stepped, 0.0)).reason == "INVALID_ARGUMENT"
    assert refusal(lambda: slowed(stepped, 1.1, "slow")).reason == "INVALID_ARGUMENT"
    assert refusal(lambda: slowed(stepped, float("nan"))).reason == "INVALID_ARGUMENT"
    assert refusal(lambda: slowed(stepped, 0.5, "nobody")).reason == "UNKNOWN_NAME"


def test_stop_cancels_the_motions_of_some_or_all_robots(stepped: Stubs) -> None:
    for name in "abc":
        load(stepped, IIWA, name)
    a, b, c = (start(stepped, joints(name, 0.05, lbr_iiwa_joint_1=2.0)) for name in "abc")
    step(stepped, 50)
    cancel(stepped, c.id)
    told = stepped.motion.Stop(motion_pb2.StopRequest(robots=["a"])).motions
    assert [one.id for one in told] == [a.id]
    step(stepped, 200)
    assert [motion(stepped, one.id).phase for one in (a, b, c)] == [CANCELLED, RUNNING, CANCELLED]
    assert [one.id for one in stepped.motion.Stop(motion_pb2.StopRequest()).motions] == [b.id]
    assert finished(stepped, b.id).end_reason == "stopped by client at ipv4:127.0.0.1"
    assert refusal(lambda: stepped.motion.Stop(motion_pb2.StopRequest(robots=["d"]))).reason == "UNKNOWN_NAME"


def test_clearing_the_world_ends_its_motions(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    ask = start(stepped, joints("arm", 0.1, lbr_iiwa_joint_1=1.0))
    stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text="schema_version: 1\n"))
    *_, last = stepped.motion.WatchMotion(motion_pb2.WatchMotionRequest(id=ask.id), timeout=30)
    assert (last.motion.phase, last.motion.end_reason) == (CANCELLED, "the world was cleared")
    assert last.motion.end_cause == motion_pb2.END_CAUSE_WORLD_CLEARED
    assert not step(stepped).motions


def test_a_start_that_is_repeated_starts_nothing_and_is_answered_the_same(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[joints("arm", 0.1, lbr_iiwa_joint_1=1.0)]), request_id="5f0c"
    )
    request.on_disconnect = motion_pb2.DISCONNECT_POLICY_CONTINUE
    first = stepped.motion.StartMotion(request)
    step(stepped, 10)
    assert stepped.motion.StartMotion(request) == first
    running = stepped.motion.ListMotions(motion_pb2.ListMotionsRequest(running_only=True)).motions
    assert [one.id for one in running] == [first.motion.id]
    request.busy_policy = motion_pb2.BUSY_POLICY_PREEMPT
    assert "belongs to another request" in refusal(lambda: stepped.motion.StartMotion(request)).message
    finished(stepped, stepped.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=first.motion.id)).motion.id)
    request.request_id = ""
    assert stepped.motion.StartMotion(request).motion.id != first.motion.id


def test_a_refused_start_is_not_remembered(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[joints("arm", 0.1, lbr_iiwa_joint_1=0.1)]), request_id="again"
    )
    request.on_disconnect = motion_pb2.DISCONNECT_POLICY_CONTINUE
    other = start(stepped, joints("arm", 0.1, lbr_iiwa_joint_1=0.1))
    assert refusal(lambda: stepped.motion.StartMotion(request)).reason == "ROBOT_BUSY"
    finished(stepped, other.id)
    assert stepped.motion.StartMotion(request).motion.id != other.id
    request.request_id = "x" * 201
    assert "200 characters" in refusal(lambda: stepped.motion.StartMotion(request)).message


def test_answers_say_when_they_were_true(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    id = start(stepped, joints("arm", 0.1, lbr_iiwa_joint_1=1.0)).id
    step(stepped, 7)
    calls = stepped.motion
    tick = calls.GetMotion(motion_pb2.GetMotionRequest(id=id)).stamp.tick
    assert calls.PauseMotion(motion_pb2.PauseMotionRequest(id=id)).stamp.tick == tick
    assert calls.ResumeMotion(motion_pb2.ResumeMotionRequest(id=id)).stamp.tick == tick
    assert calls.CancelMotion(motion_pb2.CancelMotionRequest(id=id)).stamp.tick == tick
    assert calls.Stop(motion_pb2.StopRequest()).stamp.tick == tick
