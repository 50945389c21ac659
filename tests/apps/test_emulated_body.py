"""The arm of an emulated controller: within its limits, at its setpoint in the end, silent after a complaint."""

from __future__ import annotations

import threading

import numpy as np
import pytest
import virtualrobot
from virtualrobot_apps.emulators.body import ArmLimits, SimulatedArm, Twin

from tests.kernels import KernelProcess, Stubs
from tests.tiers import Draws

CYCLE = 0.004


def test_it_reaches_setpoints_within_its_limits(rng: np.random.Generator, draws: Draws) -> None:
    for _ in range(draws(20)):
        limits = ArmLimits.usual(3, lag=rng.uniform(0.0, 0.05))
        arm = SimulatedArm(rng.uniform(-1.0, 1.0, 3), limits)
        goal = rng.uniform(-2.0, 2.0, 3)
        arm.follow(goal)
        before = arm.read()
        for _ in range(1000):
            arm.advance(CYCLE)
            now = arm.read()
            np.testing.assert_array_less(np.abs(now[1]), limits.velocity + 1e-9)
            np.testing.assert_array_less(np.abs(now[1] - before[1]), limits.acceleration * CYCLE + 1e-9)
            before = now
        np.testing.assert_array_equal(before, (goal, np.zeros(3)))


def test_it_is_behind_by_its_lag_at_constant_speed() -> None:
    arm, speed = SimulatedArm([0.0], ArmLimits.usual(1, lag=0.02)), 0.5
    for cycle in range(1, 501):
        arm.follow(np.array([speed * CYCLE * cycle]))
        arm.advance(CYCLE)
    (position,), (velocity,) = arm.read()
    # The setpoint is that of the end of the cycle, and the error is looked at as the cycle begins.
    assert abs(speed * CYCLE * 500 - position - speed * (0.02 - CYCLE)) < 1e-6
    assert abs(velocity - speed) < 1e-6


def test_it_brakes_when_it_is_halted_and_after_a_complaint() -> None:
    arm = SimulatedArm([0.0, 0.0])
    for stop in (arm.halt, lambda: arm.follow(np.array([0.0, 9.0]))):
        arm.recover()
        arm.follow(arm.read()[0] + 1.0)
        for _ in range(50):
            arm.advance(CYCLE)
        assert np.all(arm.read()[1] > 0.5)
        stop()
        for _ in range(100):
            arm.advance(CYCLE)
        np.testing.assert_array_equal(arm.read()[1], 0.0)
    assert arm.complaint == "joint joint_2 would be at 9, its range is -6.28319 to 6.28319"
    rest, _ = arm.read()
    arm.follow(rest + 1.0)
    arm.advance(CYCLE)
    np.testing.assert_array_equal(arm.read()[0], rest)


@pytest.mark.long
def test_the_twin_follows_again_after_a_halt_and_after_a_complaint(kernel: KernelProcess, stubs: Stubs) -> None:
    with virtualrobot.connect(kernel.address) as client:
        arm = client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="arm")
        twin = Twin(arm, timeout=60.0)

        def reach(goal: np.ndarray) -> None:
            def offsets() -> np.ndarray:
                positions, velocities = twin.read()
                return np.abs([positions - goal, velocities])

            while offsets().max() > 1e-3:  # at rest there: on its way through it is elsewhere when the kernel is asked
                twin.follow(goal)
                assert twin.complaint == ""
                threading.Event().wait(CYCLE)

        assert twin.joint_names == tuple(arm.joint_names) and not any(twin.sliding)
        reach(np.full(7, 0.1))
        tcp = twin.tcp()
        assert tcp is not None
        np.testing.assert_allclose(tcp, arm.tcp, atol=0.01)
        twin.follow(np.full(7, 1.0))
        twin.halt()
        reach(np.full(7, 0.2))  # at once, though it may still brake
        while not twin.complaint:
            twin.follow(np.full(7, 3.0))
        assert "a setpoint is refused: joint" in twin.complaint
        twin.recover()
        reach(np.full(7, 0.1))
        twin.close()
        with arm.stream("position", preempt=True, timeout=60.0) as other:
            twin.follow(np.full(7, 0.2))
            assert twin.complaint.startswith(f"'arm' moves in '{other.motion.id}'")


@pytest.mark.long
def test_the_twin_goes_no_faster_than_the_clock_of_its_kernel(kernel: KernelProcess, stubs: Stubs) -> None:
    """A kernel at a fifth of real time, as on a busy machine: a way at 0.8 of the greatest speed is gone whole."""
    with virtualrobot.connect(kernel.address) as client:
        arm = client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="arm")
        client.clock.set_realtime(0.2)
        twin, goal, cycles = Twin(arm), np.zeros(7), 0
        begin = twin.read()[0]
        speed = 0.8 * min(limit.velocity for limit in arm.limits.values())
        while goal[0] < 2.5:
            # It begins at rest, and does not jump.
            cycles += 1
            goal[0] += CYCLE * speed * min(1.0, cycles / 50.0)
            twin.follow(begin + goal)
            assert twin.complaint == ""
            threading.Event().wait(CYCLE)
            twin.advance(CYCLE)
        twin.close()
