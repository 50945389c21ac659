"""KernelService: information, clock, steps."""

from __future__ import annotations

import grpc
import pytest
from virtualrobot.v1 import kernel_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load, refusal, start
from tests.kernels import Stubs

REALTIME, STEPPED = kernel_pb2.CLOCK_MODE_REALTIME, kernel_pb2.CLOCK_MODE_STEPPED


def step(stubs: Stubs, ticks: int) -> kernel_pb2.StepClockResponse:
    return stubs.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=ticks))


def test_info_says_what_the_kernel_can_do(stubs: Stubs) -> None:
    info = stubs.kernel.GetInfo(kernel_pb2.GetInfoRequest())
    assert {"motion.circular", "motion.linear", "clock.stepped", "assets"} <= set(info.capabilities)
    assert "viewer" not in info.capabilities, "this kernel is headless"
    assert ".urdf" in info.model_formats
    assert {"chain", "closed_form"} <= set(info.kinematics)


def test_a_step_returns_the_observed_state(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    before = stepped.kernel.GetClock(kernel_pb2.GetClockRequest()).stamp
    motion = start(stepped, joints("arm", lbr_iiwa_joint_1=1.0))
    halfway = step(stepped, 10)
    assert halfway.stamp.tick == before.tick + 10
    assert halfway.stamp.simulation_time_seconds == pytest.approx(halfway.stamp.tick * 0.004)
    assert 0.0 < halfway.robots[0].positions[0] < 1.0
    assert halfway.robots[0].velocities[0] > 0.0
    assert list(halfway.robots[0].motion_ids) == [motion.id]
    assert 0.0 < halfway.motions[0].progress < 1.0
    last = step(stepped, 5000)
    assert last.robots[0].positions[0] == pytest.approx(1.0, abs=1e-12)
    assert [m.progress for m in last.motions if m.id == motion.id] == [1.0]
    assert not step(stepped, 1).motions, "a motion that ended earlier is not told again"


def test_time_stands_still_between_steps(stepped: Stubs) -> None:
    ticks = {stepped.kernel.GetClock(kernel_pb2.GetClockRequest()).stamp.tick for _ in range(20)}
    apply(stepped, create(box("b")))
    ticks.add(stepped.kernel.GetClock(kernel_pb2.GetClockRequest()).stamp.tick)
    assert len(ticks) == 1


def test_modes_change_and_the_watch_tells_it(stubs: Stubs) -> None:
    watch = stubs.kernel.WatchClock(kernel_pb2.WatchClockRequest(max_rate_hertz=100))
    assert next(watch).clock.mode == REALTIME
    try:
        stubs.kernel.SetClock(kernel_pb2.SetClockRequest(mode=STEPPED))
        assert next(answer for answer in watch if answer.clock.mode == STEPPED)
        assert step(stubs, 3).stamp.tick > 0
    finally:
        stubs.kernel.SetClock(kernel_pb2.SetClockRequest(mode=REALTIME, speed_factor=1.0))
    assert next(answer for answer in watch if answer.clock.real_time_factor > 0.0)
    watch.cancel()


def test_impossible_clocks_and_steps_are_refused(stubs: Stubs, stepped: Stubs) -> None:
    refused = refusal(lambda: step(stubs, 1))
    assert (refused.code, refused.reason) == (grpc.StatusCode.FAILED_PRECONDITION, "WRONG_STATE")
    assert refusal(lambda: step(stepped, 0)).reason == "INVALID_ARGUMENT"
    for clock in (
        kernel_pb2.SetClockRequest(),
        kernel_pb2.SetClockRequest(mode=REALTIME, speed_factor=-1.0),
        kernel_pb2.SetClockRequest(mode=REALTIME, speed_factor=1e6),
        kernel_pb2.SetClockRequest(mode=REALTIME, speed_factor=float("nan")),
    ):
        assert refusal(lambda clock=clock: stubs.kernel.SetClock(clock)).reason == "INVALID_ARGUMENT"


def test_rates_must_be_sensible(stubs: Stubs) -> None:
    for rate in (-1.0, float("inf"), float("nan")):
        watch = stubs.kernel.WatchClock(kernel_pb2.WatchClockRequest(max_rate_hertz=rate))
        assert refusal(lambda watch=watch: next(watch)).reason == "INVALID_ARGUMENT"
