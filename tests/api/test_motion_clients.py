"""Motions and the clients that started them: they vanish, they share a kernel, they stop each other."""

from __future__ import annotations

import subprocess
import sys
import threading
import time

import pytest
from virtualrobot.v1 import motion_pb2, scene_pb2

from tests.api.asking import IIWA, ended, joints, load, refusal, start
from tests.api.moving import ABORTED, CANCELLED, RUNNING, SUCCEEDED, motion
from tests.api.reading import state
from tests.kernels import KernelProcess, Stubs

STOP, CONTINUE = motion_pb2.DISCONNECT_POLICY_STOP, motion_pb2.DISCONNECT_POLICY_CONTINUE
WATCH = motion_pb2.WatchMotionRequest

CLIENT = """
import grpc
import sys
from virtualrobot.v1 import motion_pb2, motion_pb2_grpc
address, robot, policy, speed = sys.argv[1:]
stub = motion_pb2_grpc.MotionServiceStub(grpc.insecure_channel(address))
goal = motion_pb2.JointGoal(joint_positions={"lbr_iiwa_joint_1": 2.0})
move = motion_pb2.Move(robot=robot, speed_factor=float(speed), point_to_point=motion_pb2.PointToPoint(joints=goal))
spec = motion_pb2.MotionSpec(moves=[move])
motion = stub.StartMotion(motion_pb2.StartMotionRequest(spec=spec, on_disconnect=int(policy))).motion
for message in stub.WatchMotion(motion_pb2.WatchMotionRequest(id=motion.id)):
    print(message.motion.id, flush=True)
"""


def killed_client(
    kernel: KernelProcess, robot: str, policy: motion_pb2.DisconnectPolicy, speed: float
) -> tuple[str, float]:
    """Let a client start and watch a motion, then kill it; return the motion's id and when it was killed."""
    command = [sys.executable, "-c", CLIENT, kernel.address, robot, str(policy), str(speed)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as client:
        assert client.stdout
        id = client.stdout.readline().strip()
        client.stdout.readline()
        killed = time.monotonic()
        client.kill()
    return id, killed


def seen(stubs: Stubs, id: str, *phases: motion_pb2.MotionPhase) -> motion_pb2.Motion:
    """Return a motion once it is in one of these phases; asks, because a watch would keep it alive."""
    waiting = threading.Event()
    for _ in range(3000):
        now = motion(stubs, id)
        if now.phase in phases:
            return now
        waiting.wait(0.01)
    raise AssertionError(f"{id} has not got into {phases}")


def test_a_killed_client_s_motion_stops_and_others_go_on(stubs: Stubs, kernel: KernelProcess) -> None:
    load(stubs, IIWA, "orphan")
    load(stubs, IIWA, "other")
    other = start(stubs, joints("other", 0.003, lbr_iiwa_joint_1=2.0))
    orphan, killed = killed_client(kernel, "orphan", STOP, 0.003)
    now = motion(stubs, orphan)
    assert now.phase == RUNNING or time.monotonic() > killed + 1.0, "there is a second of grace"
    stopped = seen(stubs, orphan, SUCCEEDED, ABORTED)
    assert stopped.phase == ABORTED
    assert "nobody has watched it for 1 s" in stopped.end_reason
    assert stopped.end_cause == motion_pb2.END_CAUSE_UNWATCHED
    now = state(stubs, "orphan")
    assert not any(now.velocities)
    assert 0.0 < now.positions[0] < 2.0
    assert motion(stubs, other.id).phase == RUNNING
    stubs.motion.Stop(motion_pb2.StopRequest())


@pytest.mark.long
def test_a_killed_client_s_motion_goes_on_if_it_said_so(stubs: Stubs, kernel: KernelProcess) -> None:
    load(stubs, IIWA, "arm")
    id, _ = killed_client(kernel, "arm", CONTINUE, 0.04)
    assert ended(stubs, id).phase == SUCCEEDED
    assert state(stubs, "arm").positions[0] == pytest.approx(2.0)


def test_a_motion_that_nobody_ever_watched_stops_too(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    ask = start(stubs, joints("arm", 0.003, lbr_iiwa_joint_1=2.0), leave=motion_pb2.DISCONNECT_POLICY_UNSPECIFIED)
    assert seen(stubs, ask.id, SUCCEEDED, ABORTED).phase == ABORTED, "STOP is the default"


@pytest.mark.long
def test_who_comes_back_within_the_grace_keeps_the_motion(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    ask = start(stubs, joints("arm", 0.05, lbr_iiwa_joint_1=2.0), leave=STOP)
    for _ in range(3):
        watch = stubs.motion.WatchMotion(WATCH(id=ask.id, max_rate_hertz=50))
        for _ in range(5):
            next(watch)
        watch.cancel()
    assert ended(stubs, ask.id).phase == SUCCEEDED


def test_one_of_two_watchers_is_enough(stubs: Stubs, kernel: KernelProcess) -> None:
    load(stubs, IIWA, "arm")
    other = kernel.stubs()
    ask = start(stubs, joints("arm", 0.1, lbr_iiwa_joint_1=2.0), leave=STOP)
    first, second = (one.motion.WatchMotion(WATCH(id=ask.id)) for one in (stubs, other))
    next(first)
    next(second)
    first.cancel()
    *_, last = second
    assert last.motion.phase == SUCCEEDED
    other.channel.close()


def test_another_client_stops_and_steers(stubs: Stubs, kernel: KernelProcess) -> None:
    """Whoever watches hears of it."""
    load(stubs, IIWA, "arm")
    ask = start(stubs, joints("arm", 0.003, lbr_iiwa_joint_1=2.0), leave=STOP)
    watch = stubs.motion.WatchMotion(WATCH(id=ask.id, max_rate_hertz=100))
    next(watch)
    other = kernel.stubs()
    other.motion.PauseMotion(motion_pb2.PauseMotionRequest(id=ask.id))
    assert next(one for one in watch if one.motion.phase == motion_pb2.MOTION_PHASE_PAUSED)
    other.motion.ResumeMotion(motion_pb2.ResumeMotionRequest(id=ask.id))
    assert next(one for one in watch if one.motion.phase == RUNNING)
    assert [one.id for one in other.motion.Stop(motion_pb2.StopRequest(robots=["arm"])).motions] == [ask.id]
    *_, last = watch
    assert last.motion.phase == CANCELLED
    assert "stopped by" in last.motion.end_reason
    assert last.motion.end_cause == motion_pb2.END_CAUSE_STOP
    other.channel.close()


def test_many_starts_at_once_for_one_robot_let_one_pass(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[joints("arm", 0.003, lbr_iiwa_joint_1=1.0)]), on_disconnect=CONTINUE
    )
    calls = [stubs.motion.StartMotion.future(request) for _ in range(8)]
    refused = [call for call in calls if call.exception(60) is not None]
    assert len(refused) == len(calls) - 1
    assert {refusal(call.result).reason for call in refused} == {"ROBOT_BUSY"}


def test_a_world_replaced_under_a_watched_motion(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    ask = start(stubs, joints("arm", 0.003, lbr_iiwa_joint_1=1.0), leave=STOP)
    watch = stubs.motion.WatchMotion(WATCH(id=ask.id))
    next(watch)
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text="schema_version: 1\n"))
    *_, last = watch
    assert last.motion.phase == CANCELLED


@pytest.mark.parametrize("field", ["busy_policy", "on_disconnect"])
def test_numbers_that_no_policy_has_are_refused(stepped: Stubs, field: str) -> None:
    load(stepped, IIWA, "arm")
    request = motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[joints("arm", lbr_iiwa_joint_1=0.1)]))
    setattr(request, field, 77)
    refused = refusal(lambda: stepped.motion.StartMotion(request))
    assert (refused.reason, refused.metadata["field"]) == ("INVALID_ARGUMENT", field)
    assert "77" in refused.message
