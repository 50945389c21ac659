"""Streams of setpoints over TCP: what is followed, what is refused, and clients that vanish or lose their lease."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Sequence

import grpc
import psutil
import pytest
from virtualrobot.v1 import lease_pb2, motion_pb2, nodes_pb2, robot_pb2, scene_pb2
from virtualrobot_kernel.history.journal import Told

from tests.api.asking import IIWA, PANDA, apply, create, ended, joints, load, refusal, start
from tests.api.leasing import Holder, all_free
from tests.api.moving import ABORTED, RUNNING, SUCCEEDED, TICK, finished, motion
from tests.api.reading import state, step
from tests.api.streaming import FIRST, POSITION, SECOND, VELOCITY, Sender
from tests.inside import kernel_inside
from tests.kernels import EMPTY_SCENE, KernelProcess, Stubs

STOPPING = motion_pb2.MOTION_PHASE_STOPPING
LONG = 1e6
"""A timeout in seconds that never comes."""

CLIENT = """
import grpc, sys, time
from virtualrobot.v1 import motion_pb2, motion_pb2_grpc
stub = motion_pb2_grpc.MotionServiceStub(grpc.insecure_channel(sys.argv[1]))
target = motion_pb2.SetpointTarget(robot="arm", joint_names=["lbr_iiwa_joint_1"], mode=2, timeout_seconds=1000)
def requests():
    yield motion_pb2.StreamSetpointsRequest(target=target)
    while True:
        yield motion_pb2.StreamSetpointsRequest(values=[0.2])
        time.sleep(0.01)
for message in stub.StreamSetpoints(requests()):
    print(message.motion.id, flush=True)
"""


def test_positions_are_followed_tick_by_tick(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    stream = Sender(stepped, joints=(SECOND, FIRST), mode=POSITION, timeout_seconds=LONG)
    assert list(stream.told.positions) == [0.0, 0.0]
    for tick in range(300):
        there = min(tick * TICK * 0.3, 0.2)
        stream.give(there, -there)
        step(stepped)
    stream.end()
    assert finished(stepped, stream.id).phase == SUCCEEDED
    end = stream.rest()
    assert (end.motion.phase, end.motion.progress) == (SUCCEEDED, 1.0)
    assert list(end.positions) == [0.2, -0.2]
    assert state(stepped, "arm").positions[:2] == [-0.2, 0.2]


def test_a_silent_stream_stops_after_its_timeout_of_simulation_time(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    stream = Sender(stepped, timeout_seconds=0.1)
    stream.give(0.2)
    step(stepped, 25)
    assert motion(stepped, stream.id).phase == RUNNING
    step(stepped)
    assert motion(stepped, stream.id).phase == STOPPING
    step(stepped, 100)
    end = stream.rest()
    assert (end.motion.phase, end.motion.end_cause) == (ABORTED, motion_pb2.END_CAUSE_SETPOINT_TIMEOUT)
    assert end.motion.end_reason == "no setpoint came for 0.1 s"
    assert end.positions[0] > 0.0
    assert list(end.velocities) == [0.0]


@pytest.mark.parametrize(
    ("mode", "value", "code", "said"),
    [
        (POSITION, float("nan"), "INVALID_ARGUMENT", "'lbr_iiwa_joint_1' must be a finite number, not nan"),
        (POSITION, 3.0, "LIMIT_EXCEEDED", "'lbr_iiwa_joint_1' would be at 3 rad, its limits are"),
        (POSITION, -2.0, "LIMIT_EXCEEDED", "'lbr_iiwa_joint_1' would go from 0.02 to -2 within 0.04 s"),
        (VELOCITY, 1e3, "LIMIT_EXCEEDED", "'lbr_iiwa_joint_1' would move at 1000, its limit is"),
    ],
)
def test_a_refused_setpoint_ends_the_stream_and_stops_smoothly(
    stepped: Stubs, mode: motion_pb2.SetpointMode, value: float, code: str, said: str
) -> None:
    load(stepped, IIWA, "arm")
    stream = Sender(stepped, mode=mode)
    stream.give(0.02)
    step(stepped, 10)
    refused = refusal(lambda: stream.give(value))
    assert refused.reason == code
    assert said in refused.message
    assert (refused.metadata["joint"], float(refused.metadata["value"])) == (FIRST, pytest.approx(value, nan_ok=True))
    stopping = motion(stepped, stream.id)
    assert (stopping.phase, stopping.end_cause) == (STOPPING, motion_pb2.END_CAUSE_SETPOINT_REFUSED)
    assert stopping.end_reason == refused.message
    assert finished(stepped, stream.id).phase == ABORTED
    assert not any(state(stepped, "arm").velocities)


class Held:
    """Keeper of the journal that waits until it may."""

    def __init__(self) -> None:
        """May keep everything at first."""
        self.may = threading.Event()
        self.may.set()

    def keep(self, told: Sequence[Told]) -> None:
        """Keep entries, once it may."""
        assert self.may.wait(60.0)


def test_a_refusal_is_told_though_the_motion_has_ended_before_its_stop_is_kept() -> None:
    held = Held()
    with kernel_inside(held) as (_, address), grpc.insecure_channel(address) as channel:
        stubs = Stubs(channel)
        load(stubs, IIWA, "arm")
        stream = Sender(stubs, mode=POSITION, timeout_seconds=LONG)
        held.may.clear()
        stream.send(4.0)
        while motion(stubs, stream.id).phase == RUNNING:
            threading.Event().wait(0.01)
        step(stubs, 10)
        assert motion(stubs, stream.id).phase == ABORTED
        threading.Timer(0.5, held.may.set).start()
        refused = refusal(stream.rest)
        assert (refused.reason, refused.metadata["joint"]) == ("LIMIT_EXCEEDED", FIRST)


def test_impossible_targets_are_refused(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    assert refusal(lambda: Sender(stepped, robot="nobody")).reason == "UNKNOWN_NAME"
    assert refusal(lambda: Sender(stepped, joints=("j",))).reason == "UNKNOWN_NAME"
    assert refusal(lambda: Sender(stepped, joints=(FIRST, FIRST))).reason == "INVALID_ARGUMENT"
    for timeout in (-1.0, float("nan")):
        refused = refusal(lambda timeout=timeout: Sender(stepped, timeout_seconds=timeout))
        assert "target.timeout_seconds" in refused.message
    assert "mode is 7" in refusal(lambda: Sender(stepped, mode=7)).message  # pyright: ignore[reportArgumentType]
    silent = stepped.motion.StreamSetpoints(iter([motion_pb2.StreamSetpointsRequest(values=[0.0])]))
    assert "`target`" in refusal(lambda: next(silent)).message
    stream = Sender(stepped)
    assert "not 2" in refusal(lambda: stream.give(0.0, 0.0)).message
    assert not stepped.motion.ListMotions(motion_pb2.ListMotionsRequest(running_only=True)).motions[1:]


def test_joints_that_move_are_busy_and_can_be_preempted(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    planned = start(stepped, joints("arm", lbr_iiwa_joint_1=1.0))
    step(stepped, 20)
    assert refusal(lambda: Sender(stepped)).reason == "ROBOT_BUSY"
    other = Sender(stepped, joints=(SECOND,))
    assert refusal(lambda: start(stepped, joints("arm", lbr_iiwa_joint_2=1.0))).metadata["motion"] == other.id
    ticking = threading.Event()

    def tick() -> None:
        while not ticking.is_set():
            step(stepped)

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        stream = Sender(stepped, busy_policy=motion_pb2.BUSY_POLICY_PREEMPT, timeout_seconds=LONG)
    finally:
        ticking.set()
        thread.join()
    assert motion(stepped, planned.id).end_cause == motion_pb2.END_CAUSE_PREEMPTED
    assert motion(stepped, stream.id).phase == RUNNING


def test_two_arms_and_a_gripper_move_at_the_same_time(stepped: Stubs) -> None:
    load(stepped, PANDA, "left")
    load(stepped, IIWA, "right")
    fingers = {"panda_finger_joint1": 0.04}
    states = [nodes_pb2.ToolState(name="closed", joint_positions={"panda_finger_joint1": 0.0})]
    states.append(nodes_pb2.ToolState(name="open", joint_positions=fingers))
    tool = nodes_pb2.Node(name="hand", parent="left.panda_hand", tool=nodes_pb2.Tool(states=states))
    apply(stepped, create(tool))
    left = Sender(stepped, "left", joints=("panda_joint1", "panda_joint7"), timeout_seconds=LONG)
    right = Sender(stepped, "right", mode=POSITION, timeout_seconds=LONG)
    opening = motion_pb2.Move(robot="left", tool_state=motion_pb2.ToolStateMove(tool="hand", state="open"))
    gripper = start(stepped, opening)
    left.give(0.1, 0.2)
    right.give(0.05)
    step(stepped, 500)
    assert motion(stepped, gripper.id).phase == SUCCEEDED
    names = [joint.name for joint in stepped.robot.GetRobot(robot_pb2.GetRobotRequest(name="left")).joints]
    now = dict(zip(names, state(stepped, "left").velocities, strict=True))
    assert {name: v for name, v in now.items() if v} == {"panda_joint1": 0.1, "panda_joint7": 0.2}
    assert state(stepped, "left").positions[names.index("panda_finger_joint1")] == 0.04
    assert state(stepped, "right").positions[0] == 0.05
    stepped.motion.Stop(motion_pb2.StopRequest(robots=["left"]))
    step(stepped, 200)
    assert left.rest().motion.end_cause == motion_pb2.END_CAUSE_STOP
    assert motion(stepped, right.id).phase == RUNNING


def test_a_stream_ends_with_its_world(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    stream = Sender(stepped, timeout_seconds=LONG)
    stream.give(0.1)
    step(stepped, 20)
    stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
    assert stream.rest().motion.end_cause == motion_pb2.END_CAUSE_WORLD_CLEARED


def test_a_stream_can_be_preempted(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    first, second = Sender(stubs, timeout_seconds=LONG), Sender(stubs, joints=(SECOND,), timeout_seconds=LONG)
    third = Sender(stubs, busy_policy=motion_pb2.BUSY_POLICY_PREEMPT, timeout_seconds=LONG)
    assert first.rest().motion.end_cause == motion_pb2.END_CAUSE_PREEMPTED
    assert [motion(stubs, one.id).phase for one in (second, third)] == [RUNNING, RUNNING]


def test_a_killed_client_s_joints_stop_at_once(stubs: Stubs, kernel: KernelProcess) -> None:
    load(stubs, IIWA, "arm")
    command = [sys.executable, "-c", CLIENT, kernel.address]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as client:
        assert client.stdout
        id = client.stdout.readline().strip()
        for _ in range(20):
            client.stdout.readline()
        assert motion(stubs, id).phase == RUNNING
        client.kill()
    stopped = ended(stubs, id)
    assert (stopped.phase, stopped.end_cause) == (ABORTED, motion_pb2.END_CAUSE_UNWATCHED)
    assert stopped.end_reason == "the client that sent setpoints is gone"
    assert state(stubs, "arm").positions[0] > 0.0


def test_a_client_that_hangs_up_has_cancelled(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    stream = Sender(stubs, timeout_seconds=LONG)
    stream.give(0.1)
    stream.call.cancel()
    assert ended(stubs, stream.id).end_cause == motion_pb2.END_CAUSE_UNWATCHED


@pytest.mark.long
def test_a_flood_of_setpoints_is_read_and_the_newest_counts(stubs: Stubs, kernel: KernelProcess) -> None:
    load(stubs, IIWA, "arm")
    stream = Sender(stubs, timeout_seconds=LONG)
    before = resident(kernel)
    # Slow, so that the joint isn't at its limit before a slow machine has read all.
    for _ in range(20_000):
        stream.send(0.001)
    stream.give(0.002)
    waiting = threading.Event()
    for _ in range(10_000):
        if state(stubs, "arm").velocities[0] == pytest.approx(0.002):
            break
        waiting.wait(0.01)
    assert state(stubs, "arm").velocities[0] == pytest.approx(0.002)
    assert resident(kernel) - before < 20_000, "kB: 20,000 setpoints kept would be more"
    stream.end()
    assert stream.rest().motion.phase == SUCCEEDED


def resident(kernel: KernelProcess) -> int:
    """Return the memory of a kernel in kB."""
    return psutil.Process(kernel.process.pid).memory_info().rss // 1024


def test_only_the_holder_of_a_lease_streams(kernel: KernelProcess, stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    ada = Holder(kernel, "arm")
    refused = refusal(lambda: Sender(stubs))
    assert (refused.code, refused.metadata["owner"]) == (grpc.StatusCode.PERMISSION_DENIED, "Ada")
    stream = Sender(ada.stubs, metadata=ada.metadata, timeout_seconds=LONG)
    stream.give(0.1)
    all_free(stubs)
    assert refusal(lambda: stream.rest()).reason == "LEASE_ENDED"
    assert ended(stubs, stream.id).end_cause == motion_pb2.END_CAUSE_LEASE_TAKEN


def test_a_stream_ends_when_its_lease_expires(kernel: KernelProcess, stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    ada = Holder(kernel, "arm")
    stream = Sender(ada.stubs, metadata=ada.metadata, timeout_seconds=LONG)
    stream.give(0.1)
    ada.told.cancel()  # nobody keeps it alive
    refused = refusal(lambda: stream.rest())
    assert refused.reason == "LEASE_ENDED"
    assert ended(stubs, stream.id).end_cause == motion_pb2.END_CAUSE_LEASE_EXPIRED


def test_a_stream_without_a_lease_ends_when_somebody_leases_the_robot(kernel: KernelProcess, stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    stream = Sender(stubs, timeout_seconds=LONG)
    stream.give(0.1)
    ada = stubs.lease.AcquireLease(lease_pb2.AcquireLeaseRequest(robots=["arm"], owner="Ada"))
    stream.send(0.1)  # counted as given, perhaps, before it is refused
    assert refusal(stream.rest).metadata["owner"] == "Ada"
    assert ended(stubs, stream.id).end_cause == motion_pb2.END_CAUSE_LEASE_TAKEN
    stubs.lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token=ada.token))
