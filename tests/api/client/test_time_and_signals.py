"""Clock and signals through the client."""

from __future__ import annotations

import threading

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot
from virtualrobot.errors import WrongStateError

from tests.api.client.conftest import IIWA
from tests.kernels import KernelProcess


def test_time_goes_on_by_steps(client: Client, iiwa: Robot) -> None:
    client.signals.create("s", True)
    with pytest.raises(virtualrobot.WrongStateError):
        client.clock.step()
    client.clock.set_stepped()
    before = client.clock.read()
    assert (before.mode, before.tick_length, before.stamp.tick_length) == ("stepped", 0.004, 0.004)
    assert before.stamp.simulation_time == pytest.approx(before.stamp.tick * 0.004)
    client.scene.clear()
    assert client.clock.read().stamp.epoch == before.stamp.epoch + 1
    iiwa = client.load_robot(IIWA, name="iiwa")
    client.signals.create("s", True)
    motion = iiwa.move_trajectory([0, 0.1], [np.zeros(7), np.full(7, 0.01)], wait=False)
    seen = client.clock.step(10)
    assert seen.stamp.tick >= before.stamp.tick + 10
    assert 0 < seen.robots["iiwa"].positions[0] < 0.01
    assert seen.signals == {"s": True}
    assert [message.id for message in seen.motions] == [motion.id]
    np.testing.assert_array_equal(seen.robots["iiwa"].positions, iiwa.positions)  # nothing moves meanwhile
    client.clock.step(50)
    motion.wait()
    np.testing.assert_allclose(iiwa.positions, np.full(7, 0.01), atol=1e-9)


def test_a_motion_is_as_far_as_the_step_that_was_made(client: Client, iiwa: Robot) -> None:
    """Whoever steps until the motion has ended makes as many steps in each run."""
    client.clock.set_stepped()
    for _ in range(3):
        iiwa.set_positions(np.zeros(7))
        motion = iiwa.move_joints(np.full(7, 0.05), wait=False)
        steps = 0
        while not motion.phase.ended:
            told = {one.id: one for one in client.clock.step(2).motions}[motion.id]
            assert (motion.phase, motion.progress) == (told.phase, told.progress)
            steps += 1
        assert steps == np.ceil(round(motion.planned_duration / 0.004, 6) / 2)


def test_who_would_wait_for_ever_is_told_how_to_step(client: Client, iiwa: Robot) -> None:
    client.clock.set_stepped()
    with pytest.raises(virtualrobot.WrongStateError, match=r"wait=False .* client\.clock\.run\(motion\)"):
        iiwa.move_joints(np.full(7, 0.1))
    assert client.motions() == [] and not iiwa.positions.any()
    motion = iiwa.move_joints(np.full(7, 0.1), wait=False)
    with pytest.raises(virtualrobot.WrongStateError, match="wait with a timeout"):
        motion.wait()
    before = client.clock.read().stamp.tick
    with pytest.raises(virtualrobot.CallTimeoutError, match=r"has not ended after 0.1 s of simulation time"):
        client.clock.run(motion, timeout=0.1)
    assert client.clock.read().stamp.tick == before + 25
    ended = client.clock.run(motion)
    assert ended.stamp.tick - before == np.ceil(round(motion.planned_duration / 0.004, 6))
    assert motion.wait().phase.name == "SUCCEEDED"
    np.testing.assert_allclose(iiwa.positions, np.full(7, 0.1), atol=1e-9)
    cancelled = iiwa.move_joints(np.zeros(7), wait=False)
    cancelled.cancel("enough")
    with pytest.raises(virtualrobot.MotionCancelledError, match="enough"):
        client.clock.run(cancelled)


def test_who_waits_while_another_steps_is_done_when_it_is(client: Client, iiwa: Robot, kernel: KernelProcess) -> None:
    client.clock.set_stepped()
    motion = iiwa.move_joints(np.full(7, 0.05), wait=False)

    def step() -> None:
        with virtualrobot.connect(kernel.address) as other:
            other.clock.run(*other.motions())

    thread = threading.Thread(target=step)
    thread.start()
    motion.wait(timeout=60)
    thread.join()
    np.testing.assert_allclose(iiwa.positions, np.full(7, 0.05), atol=1e-9)


def test_the_clock_is_watched_and_set(client: Client) -> None:
    watch = client.clock.watch(max_rate=50)
    assert next(watch).mode == "realtime"
    client.clock.speed_factor = 2.0
    assert client.clock.speed_factor == 2.0
    client.clock.set_stepped()
    assert next(state for state in watch if state.mode == "stepped").tick_length == 0.004
    with pytest.raises(virtualrobot.VirtualRobotError, match="1000"):
        client.clock.set_realtime(1000)


def test_time_is_stepped_while_somebody_holds_it(client: Client) -> None:
    """By one at a time; what somebody sets meanwhile stays."""
    client.clock.set_realtime(2.0)
    with client.clock.hold_stepped() as hold:
        assert client.clock.step(3).ticks == 3
        assert client.clock.mode == "stepped"
        with pytest.raises(WrongStateError, match=r"time is stepped by .*; one at a time holds the clock"):
            client.clock.hold_stepped()
        hold.close()
    state = client.clock.read()
    assert (state.mode, state.speed_factor) == ("realtime", 2.0)
    with client.clock.hold_stepped():
        client.clock.set_realtime(3.0)
    assert client.clock.speed_factor == 3.0
    client.clock.set_stepped()
    with client.clock.hold_stepped():
        pass
    assert client.clock.mode == "stepped"


def test_signals_are_like_a_dictionary(client: Client) -> None:
    signals = client.signals
    signals.create("a")
    signals.create("b", True, description="what b is for")
    assert dict(signals) == {"a": False, "b": True}
    assert len(signals) == 2
    assert "c" not in signals
    assert signals.get("c") is None
    signals["a"] = True
    signals.set({"a": False, "b": False})
    assert dict(signals) == {"a": False, "b": False}
    assert {signal.name: signal.description for signal in signals.read()}["b"] == "what b is for"
    del signals["b"]
    assert list(signals) == ["a"]
    with pytest.raises(virtualrobot.UnknownNameError):
        signals["b"] = True
    with pytest.raises(KeyError):
        _ = signals["b"]
    with pytest.raises(virtualrobot.NameTakenError):
        signals.create("a")


def test_signals_are_waited_for(client: Client, kernel: KernelProcess) -> None:
    client.signals.create("ready")
    client.signals.wait_for("ready", False)
    with pytest.raises(virtualrobot.CallTimeoutError, match="'ready' was not on within"):
        client.signals.wait_for("ready", timeout=0.1)

    def say() -> None:
        with virtualrobot.connect(kernel.address) as other:
            other.signals["ready"] = True

    thread = threading.Thread(target=say)
    thread.start()
    client.signals.wait_for("ready", timeout=30)
    thread.join()
    with pytest.raises(virtualrobot.UnknownNameError):
        client.signals.wait_for("raedy", timeout=1)


def test_every_change_of_a_signal_is_told(client: Client) -> None:
    client.signals.create("pulse")
    watch = client.signals.watch(["pulse"])
    assert next(watch) == {"pulse": False}
    for value in (True, False, True):
        client.signals["pulse"] = value
    assert [next(watch)["pulse"] for _ in range(3)] == [True, False, True]


def test_numbers_of_numpy_are_signals(client: Client) -> None:
    client.signals.create("on", np.bool_(True))
    client.signals.create("count", np.int64(3))
    client.signals.create("size", np.float64(0.5))
    client.signals.create("group", np.array([True, False]))
    client.signals.set({"count": np.uint8(7), "size": np.float32(0.25)})
    assert dict(client.signals) == {"on": True, "count": 7, "size": 0.25, "group": (True, False)}
    client.signals.wait_for("on", np.bool_(True), timeout=30.0)
    client.signals.wait_for("size", np.float32(0.1), comparison=">=", timeout=30.0)
    client.signals.wait_for("group", [True, False], timeout=30.0)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="value is None; it must be True or False, "):
        client.signals["on"] = None  # type: ignore[assignment]  # pyright: ignore[reportArgumentType]
