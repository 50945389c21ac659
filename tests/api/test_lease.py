"""Leases over the contract: who is refused, what stopping may, and what happens to those who vanish."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from typing import Any

import grpc
import numpy as np
import pytest
from virtualrobot.v1 import (
    kernel_pb2,
    lease_pb2,
    motion_pb2,
    nodes_pb2,
    scene_pb2,
)

from tests.api.asking import IIWA, PANDA, joints, load, refusal, start
from tests.api.leasing import CONTINUE, Holder, all_free, free, leases, slow, two_arms, update
from tests.api.moving import ABORTED, CANCELLED, RUNNING, motion
from tests.api.reading import state, step
from tests.kernels import KernelProcess, Stubs


@pytest.fixture
def cell(kernel: KernelProcess, stubs: Stubs) -> Iterator[Stubs]:
    """Return stubs that hold no lease, in a world with two arms."""
    two_arms(stubs)
    yield stubs
    all_free(stubs)


def test_without_lease_anyone_moves_and_with_it_the_holder_alone(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    start(stubs, joints("left", lbr_iiwa_joint_1=0.01))
    stubs.motion.Stop(motion_pb2.StopRequest())
    ada = Holder(kernel, "left", owner="Ada")
    refused = refusal(lambda: start(stubs, joints("left", lbr_iiwa_joint_1=0.1)))
    assert (refused.code, refused.reason) == (grpc.StatusCode.PERMISSION_DENIED, "LEASED")
    assert (refused.metadata["robot"], refused.metadata["owner"]) == ("left", "Ada")
    assert refused.metadata["lease"] == ada.given.lease.id
    assert refused.metadata["since"] == ada.given.lease.since.ToDatetime().isoformat(timespec="seconds") + "+00:00"
    assert "'left' is leased by 'Ada'" in refused.message
    ada.start(joints("left", lbr_iiwa_joint_1=0.1), busy_policy=motion_pb2.BUSY_POLICY_PREEMPT)
    start(stubs, joints("right", lbr_iiwa_joint_1=0.1))
    (shown,) = leases(stubs)
    assert shown == ada.given.lease
    assert list(shown.robots) == ["left"]
    ada.release()
    stubs.motion.Stop(motion_pb2.StopRequest())
    start(stubs, joints("left", lbr_iiwa_joint_1=0.2), busy=motion_pb2.BUSY_POLICY_PREEMPT)


def test_anyone_may_stop_and_pause_but_not_resume(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    ada = Holder(kernel, "left")
    id = ada.start(slow("left"))
    stubs.motion.PauseMotion(motion_pb2.PauseMotionRequest(id=id))
    resume = motion_pb2.ResumeMotionRequest(id=id)
    assert refusal(lambda: stubs.motion.ResumeMotion(resume)).metadata["owner"] == "Ada"
    ada.stubs.motion.ResumeMotion(resume, metadata=ada.metadata)
    stubs.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=id))
    id = ada.start(slow("left"), busy_policy=motion_pb2.BUSY_POLICY_PREEMPT)
    assert [one.id for one in stubs.motion.Stop(motion_pb2.StopRequest(robots=["left"])).motions] == [id]
    assert leases(stubs) == [ada.given.lease]  # stopping is not taking


def test_a_start_that_would_preempt_the_holder_stops_nothing(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    ada = Holder(kernel, "left")
    group = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[slow("left"), slow("right")]), on_disconnect=CONTINUE
    )
    id = ada.stubs.motion.StartMotion(group, metadata=ada.metadata).motion.id
    for robot in ("left", "right"):  # the motion of `right` moves `left` as well
        move = joints(robot, lbr_iiwa_joint_1=0.5)
        refused = refusal(lambda move=move: start(stubs, move, busy=motion_pb2.BUSY_POLICY_PREEMPT))
        assert refused.metadata["owner"] == "Ada"
    assert motion(stubs, id).phase == RUNNING


def test_several_robots_are_leased_all_or_none(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    ada = Holder(kernel, "left")
    ask = lease_pb2.AcquireLeaseRequest(robots=["right", "left"], owner="Bob")
    assert refusal(lambda: stubs.lease.AcquireLease(ask)).metadata["owner"] == "Ada"
    start(stubs, joints("right", lbr_iiwa_joint_1=0.1))  # is still free
    bob = Holder(kernel, "right", owner="Bob")
    both = (*ada.metadata, *bob.metadata)
    together = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[slow("left"), slow("right")]),
        on_disconnect=CONTINUE,
        busy_policy=motion_pb2.BUSY_POLICY_PREEMPT,
    )
    assert refusal(lambda: stubs.motion.StartMotion(together, metadata=ada.metadata)).metadata["robot"] == "right"
    stubs.motion.StartMotion(together, metadata=both)


def test_of_many_who_acquire_at_once_one_gets_it(cell: Stubs, kernel: KernelProcess) -> None:
    clients = [kernel.stubs() for _ in range(8)]
    calls = [
        client.lease.AcquireLease.future(
            lease_pb2.AcquireLeaseRequest(robots=["left", "right"], owner=f"client {number}")
        )
        for number, client in enumerate(clients)
    ]
    refused = [call for call in calls if call.exception(30) is not None]
    (won,) = [call.result() for call in calls if call not in refused]
    assert {refusal(call.result).metadata["owner"] for call in refused} == {won.lease.owner}


def test_taking_stops_the_motion_and_tells_the_owner(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    ada = Holder(kernel, "left", "right", owner="Ada")
    id, other = ada.start(slow("left")), ada.start(slow("right"))
    bob = Holder(kernel, "left", owner="Bob", take=True)
    assert list(bob.given.taken_from) == [ada.given.lease]
    assert motion(stubs, id).end_cause == motion_pb2.END_CAUSE_LEASE_TAKEN
    assert "taken over by 'Bob'" in motion(stubs, id).end_reason
    told = next(ada.told)
    assert (told.loss, list(told.lease.robots)) == (lease_pb2.LEASE_LOSS_TAKEN, ["right"])
    assert "'Bob'" in told.reason
    assert refusal(lambda: ada.start(joints("left", lbr_iiwa_joint_1=0.1))).metadata["owner"] == "Bob"
    assert motion(stubs, other).phase == RUNNING  # she keeps the other robot
    last = Holder(kernel, "right", owner="Bob", take=True)
    *_, told = ada.told
    assert (told.loss, list(told.lease.robots)) == (lease_pb2.LEASE_LOSS_TAKEN, [])
    last.release()
    refused = refusal(lambda: ada.start(joints("right", lbr_iiwa_joint_1=0.1)))  # free now, but her lease has ended
    assert (refused.reason, refused.metadata["cause"]) == ("LEASE_ENDED", "taken")
    assert "'Bob'" in refused.message
    ada.stubs.motion.Stop(motion_pb2.StopRequest(), metadata=ada.metadata)  # stopping asks for nothing


def test_releasing_lets_a_motion_go_on(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    ada = Holder(kernel, "left")
    id = ada.start(slow("left"))
    ada.release()
    *_, told = ada.told
    assert (told.loss, list(told.lease.robots)) == (lease_pb2.LEASE_LOSS_RELEASED, [])
    assert motion(stubs, id).phase == RUNNING
    refused = refusal(ada.release)
    assert (refused.reason, refused.metadata["cause"]) == ("LEASE_ENDED", "released")


def test_a_lease_follows_its_robot_s_name(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    ada = Holder(kernel, "left")
    ada.apply(update("left", nodes_pb2.Node(name="arm"), "name"))
    assert [list(lease.robots) for lease in leases(stubs)] == [["arm"]]
    load(stubs, IIWA, "left")
    start(stubs, joints("left", lbr_iiwa_joint_1=0.1))
    assert refusal(lambda: start(stubs, joints("arm", lbr_iiwa_joint_1=0.1))).metadata["robot"] == "arm"


CLIENT = """
import grpc, sys, threading
from virtualrobot.v1 import lease_pb2, lease_pb2_grpc, motion_pb2, motion_pb2_grpc
address, robot = sys.argv[1:]
channel = grpc.insecure_channel(address)
leases, motions = lease_pb2_grpc.LeaseServiceStub(channel), motion_pb2_grpc.MotionServiceStub(channel)
token = leases.AcquireLease(lease_pb2.AcquireLeaseRequest(robots=[robot], owner="doomed")).token
told = leases.KeepLeaseAlive(lease_pb2.KeepLeaseAliveRequest(token=token))
next(told)
goal = motion_pb2.JointGoal(joint_positions={"lbr_iiwa_joint_1": 2.0})
move = motion_pb2.Move(robot=robot, speed_factor=0.003, point_to_point=motion_pb2.PointToPoint(joints=goal))
spec = motion_pb2.MotionSpec(moves=[move])
request = motion_pb2.StartMotionRequest(spec=spec, on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE)
print(motions.StartMotion(request, metadata=[("virtualrobot-lease", token)]).motion.id, flush=True)
for _ in told:
    pass
"""


@pytest.mark.long
@pytest.mark.parametrize(
    "ending",
    [
        "kill",
        pytest.param(
            "freeze",
            marks=pytest.mark.skipif(sys.platform == "win32", reason="Windows stops no process by a signal"),
        ),
    ],
)
def test_a_client_that_vanishes_loses_its_lease_and_its_robot_stops(
    cell: Stubs, kernel: KernelProcess, ending: str
) -> None:
    """One that is frozen closes no connection, like one whose network is cut: it answers no pings."""
    stubs = cell
    ada = Holder(kernel, "right")
    id = ada.start(slow("right"))
    command = [sys.executable, "-c", CLIENT, kernel.address, "left"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as client:
        try:
            assert client.stdout
            doomed = client.stdout.readline().strip()
            assert refusal(lambda: start(stubs, slow("left"))).metadata["owner"] == "doomed"
            if ending == "kill":
                client.kill()
            else:
                os.kill(client.pid, signal.SIGSTOP)
            *_, last = stubs.motion.WatchMotion(motion_pb2.WatchMotionRequest(id=doomed))
        finally:
            client.kill()
    assert (last.motion.phase, last.motion.end_cause) == (ABORTED, motion_pb2.END_CAUSE_LEASE_EXPIRED)
    assert "the lease of 'doomed' expired" in last.motion.end_reason
    assert leases(stubs) == [ada.given.lease]
    assert motion(stubs, id).phase == RUNNING
    assert not np.any(state(stubs, "left").velocities)
    start(stubs, joints("left", lbr_iiwa_joint_1=0.1))


def test_a_lease_that_nobody_keeps_alive_expires(cell: Stubs) -> None:
    stubs = cell
    token = stubs.lease.AcquireLease(lease_pb2.AcquireLeaseRequest(robots=["left"])).token
    assert leases(stubs)
    free(stubs)
    keep = lease_pb2.KeepLeaseAliveRequest(token=token)
    for call in (lambda: next(stubs.lease.KeepLeaseAlive(keep)), lambda: stubs.lease.ReleaseLease(keep)):
        with pytest.raises(grpc.RpcError):
            call()
    refused = refusal(lambda: next(stubs.lease.KeepLeaseAlive(keep)))
    assert (refused.reason, refused.metadata["cause"]) == ("LEASE_ENDED", "expired")


def test_a_stream_that_is_opened_again_in_time_keeps_the_lease(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    ada = Holder(kernel, "left")
    keep = lease_pb2.KeepLeaseAliveRequest(token=ada.given.token)
    for _ in range(20):
        again = stubs.lease.KeepLeaseAlive(keep)
        next(again)
        ada.told.cancel()
        ada.told = again
        threading.Event().wait(0.1)
    assert leases(stubs) == [ada.given.lease]


@pytest.mark.parametrize("who", ["anyone", "the holder"])
def test_a_start_that_waits_is_refused_when_the_robot_is_leased_meanwhile(
    stepped_kernel: KernelProcess, stepped: Stubs, who: str
) -> None:
    """A start that preempts waits for standstill, and so for steps: time for others to lease the robot."""
    load(stepped, IIWA, "arm")
    ada = Holder(stepped_kernel, "arm") if who == "the holder" else None
    metadata = ada.metadata if ada else ()
    going = motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[slow("arm")]), on_disconnect=CONTINUE)
    id = stepped.motion.StartMotion(going, metadata=metadata).motion.id
    step(stepped, 50)
    preempting = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[joints("arm", lbr_iiwa_joint_1=-0.5)]),
        on_disconnect=CONTINUE,
        busy_policy=motion_pb2.BUSY_POLICY_PREEMPT,
    )
    call = stepped.motion.StartMotion.future(preempting, metadata=metadata)
    waiting = threading.Event()
    while motion(stepped, id).phase != motion_pb2.MOTION_PHASE_STOPPING:
        waiting.wait(0.01)
    bob = Holder(stepped_kernel, "arm", owner="Bob", take=who == "the holder")
    assert not call.done()
    step(stepped, 500)
    refused = refusal(lambda: call.result(60))
    assert refused.reason == ("LEASE_ENDED" if ada else "LEASED")
    assert "'Bob'" in refused.message
    assert motion(stepped, id).phase == CANCELLED
    assert len(stepped.motion.ListMotions(motion_pb2.ListMotionsRequest(running_only=True)).motions) == 0
    bob.release()


def test_once_a_robot_is_taken_nothing_of_others_starts(cell: Stubs, kernel: KernelProcess) -> None:
    """Starts are planned in threads of their own, so that they come before, while and after the robot is taken."""
    stubs = cell
    load(stubs, PANDA, "panda")
    running = motion_pb2.ListMotionsRequest(running_only=True)
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[joints("panda", panda_joint1=0.5)]), on_disconnect=CONTINUE
    )
    for _ in range(20):
        calls = [stubs.motion.StartMotion.future(request) for _ in range(4)]
        ada = Holder(kernel, "panda", take=True)
        going = {one.id for one in stubs.motion.ListMotions(running).motions}
        for call in calls:
            if call.exception(30) is not None:
                assert refusal(call.result).reason in ("LEASED", "ROBOT_BUSY", "PLAN_OUTDATED")
        assert {one.id for one in stubs.motion.ListMotions(running).motions} <= going
        ada.release()
        ada.vanish()


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({}, "INVALID_ARGUMENT"),
        ({"robots": ["lefft"]}, "UNKNOWN_NAME"),
        ({"robots": ["box"]}, "UNKNOWN_NAME"),
        ({"robots": [""]}, "UNKNOWN_NAME"),
        ({"robots": ["left"], "owner": "x" * 201}, "INVALID_ARGUMENT"),
    ],
)
def test_bad_requests_are_refused(cell: Stubs, fields: dict[str, Any], reason: str) -> None:
    stubs = cell
    for call, ask in (
        (stubs.lease.AcquireLease, lease_pb2.AcquireLeaseRequest),
        (stubs.lease.TakeLease, lease_pb2.TakeLeaseRequest),
    ):
        assert refusal(lambda call=call, ask=ask: call(ask(**fields))).reason == reason
    assert leases(stubs) == []


def test_tokens_that_are_none(cell: Stubs) -> None:
    stubs = cell
    for call in (
        lambda: stubs.lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token="guess")),
        lambda: next(stubs.lease.KeepLeaseAlive(lease_pb2.KeepLeaseAliveRequest(token=""))),
        lambda: stubs.scene.Apply(scene_pb2.ApplyRequest(), metadata=(("virtualrobot-lease", "guess"),)),
    ):
        assert refusal(call).reason == "LEASE_ENDED"
    stubs.kernel.GetClock(kernel_pb2.GetClockRequest(), metadata=(("virtualrobot-lease", "guess"),))


def test_an_owner_without_a_name_is_the_client(cell: Stubs) -> None:
    stubs = cell
    ask = lease_pb2.AcquireLeaseRequest(robots=["left", "left"])
    lease = stubs.lease.AcquireLease(ask, metadata=(("client-name", "press"),)).lease
    assert list(lease.robots) == ["left"]
    assert lease.owner == "press at ipv4:127.0.0.1"


def test_in_steps_an_expired_lease_stops_its_robot_too(stepped_kernel: KernelProcess, stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    ada = Holder(stepped_kernel, "arm")
    id = ada.start(slow("arm"))
    step(stepped, 50)
    ada.vanish()
    free(stepped)
    step(stepped, 500)
    assert motion(stepped, id).end_cause == motion_pb2.END_CAUSE_LEASE_EXPIRED
    assert motion(stepped, id).phase == ABORTED
