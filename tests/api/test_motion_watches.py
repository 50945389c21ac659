"""MotionService.WatchMotions and LeaseService.WatchLeases: all that is told to who looks at a cell, as it changes."""

from __future__ import annotations

from virtualrobot.v1 import lease_pb2, motion_pb2

from tests.api.asking import joints, start
from tests.api.leasing import Holder, all_free, two_arms
from tests.api.moving import RUNNING
from tests.api.reading import step
from tests.kernels import KernelProcess, Stubs

SUCCEEDED, CANCELLED = motion_pb2.MOTION_PHASE_SUCCEEDED, motion_pb2.MOTION_PHASE_CANCELLED


def test_motions_are_told_as_they_run_and_end(stepped: Stubs) -> None:
    two_arms(stepped)
    watch = stepped.motion.WatchMotions(motion_pb2.WatchMotionsRequest(max_rate_hertz=1e6), timeout=100)
    first = next(watch)
    assert not first.motions and first.speed_factor == 1.0

    def told(phase: int, id: str) -> motion_pb2.Motion:
        """Return what the watch tells of a motion once it is in a phase; progress never falls."""
        progress = -1.0
        for message in watch:
            for motion in message.motions:
                if motion.id == id:
                    assert motion.progress >= progress
                    progress = motion.progress
                    if motion.phase == phase:
                        return motion
        raise AssertionError("the watch has ended")

    left = start(stepped, joints("left", lbr_iiwa_joint_1=0.05)).id
    right = start(stepped, joints("right", lbr_iiwa_joint_1=0.5)).id
    assert told(RUNNING, left).progress == 0.0
    step(stepped, 10)
    assert {motion.id for motion in next(watch).motions} == {left, right}
    stepped.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=right))
    step(stepped, 500)
    # Ends are told, however many ticks go by at once, and once.
    ends = {}
    for message in watch:
        ends |= {one.id: one.phase for one in message.motions if one.phase in (SUCCEEDED, CANCELLED)}
        if not any(one.phase == RUNNING for one in message.motions) and ends.keys() >= {left, right}:
            break
    assert ends == {left: SUCCEEDED, right: CANCELLED}
    third = start(stepped, joints("left", lbr_iiwa_joint_1=0.0)).id
    for message in watch:
        if message.motions:
            assert [one.id for one in message.motions] == [third]
            break
    watch.cancel()
    # It keeps no motion alive, and who comes later is told those that run alone.
    later = next(stepped.motion.WatchMotions(motion_pb2.WatchMotionsRequest(), timeout=100))
    assert [one.id for one in later.motions] == [third]
    stepped.motion.Stop(motion_pb2.StopRequest())
    step(stepped, 500)


def test_leases_are_told_as_they_change(stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    two_arms(stepped)
    watch = stepped.lease.WatchLeases(lease_pb2.WatchLeasesRequest(), timeout=100)
    assert not next(watch).leases
    ada = Holder(stepped_kernel, "left", owner="Ada")
    (told,) = next(watch).leases
    assert (list(told.robots), told.owner) == (["left"], "Ada")
    bob = Holder(stepped_kernel, "right", owner="Bob")
    assert [one.owner for one in next(watch).leases] == ["Ada", "Bob"]
    ada.release()
    assert [one.owner for one in next(watch).leases] == ["Bob"]
    bob.release()
    assert not next(watch).leases
    watch.cancel()
    all_free(stepped)
