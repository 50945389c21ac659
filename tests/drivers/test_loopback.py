"""The computed controller: it keeps the laws of drivers in all paces, and has each fault that it is asked for."""

from __future__ import annotations

import dataclasses
import json
import socket
from collections.abc import Iterator
from typing import ClassVar

import numpy as np
import pytest
from virtualrobot_plugins.drivers.loopback.controller import Controller
from virtualrobot_plugins.drivers.loopback.driver import Loopback
from virtualrobot_plugins.drivers.loopback.settings import Fault, LoopbackSettings, What
from virtualrobot_sdk.drivers import DriverFault, Mode, Safety
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.settings import make_settings
from virtualrobot_sdk.testing.robot_drivers import DriverFacts, RobotDriverContract

from tests.contract.components import robot_drivers

CAUSES = robot_drivers.__name__
# Slow and patient, for a busy machine.
SLOW = {"joints": 2, "start": [0.2, -0.4], "rate": 50, "watchdog": 2, "delay": 0.02, "jitter": 0.02, "lag": 0.04}


class _Loopback(RobotDriverContract):
    component = "virtualrobot_plugins.drivers/loopback"
    facts = DriverFacts(
        joints=2,
        moves=True,
        settle_seconds=5.0,
        stands_at=(0.2, -0.4),
        breaks=f"{CAUSES}:cut",
        silences=f"{CAUSES}:silence",
        mends=f"{CAUSES}:mend",
        complains=f"{CAUSES}:meet",
        words="joint 1 met something",
    )


@pytest.mark.long
class TestHost(_Loopback):
    settings: ClassVar = SLOW | {"pace": "HOST", "degrees": True}


@pytest.mark.long
class TestController(_Loopback):
    settings: ClassVar = SLOW | {"pace": "CONTROLLER", "loss": 0.05, "seed": 3}


@pytest.mark.long
class TestJobs(_Loopback):
    settings: ClassVar = SLOW | {"pace": "JOBS", "speed": 0.1}


IDEAL = LoopbackSettings(joints=2, rate=100.0, watchdog=0.0)
RAMP = 0.5
"""Speed of the ramp that most tests send (rad/s)."""


def following(settings: LoopbackSettings, seconds: float) -> Controller:
    """Return a controller that has followed a ramp of its first joint for a time."""
    controller = Controller(settings)
    controller.begin(0.0)
    for i in range(round(seconds * settings.rate)):
        now = i / settings.rate
        controller.setpoint(np.array([RAMP * now, 0.0]), 0, now)
        controller.advance(i + 1)
    return controller


def test_an_ideal_one_is_where_it_was_told_to_be() -> None:
    controller = following(IDEAL, 1.0)
    np.testing.assert_allclose(controller.q, [RAMP * 0.99, 0.0])
    np.testing.assert_allclose(controller.v, [RAMP, 0.0])


def test_it_lags_by_the_speed_times_the_time_constant() -> None:
    # A first-order lag follows a ramp late by its time constant; sampled, by up to a cycle less.
    controller = following(dataclasses.replace(IDEAL, lag=0.05), 1.0)
    assert RAMP * 0.99 - controller.q[0] == pytest.approx(RAMP * 0.05, abs=RAMP * 0.01)


def test_a_delay_is_a_delay() -> None:
    controller = following(dataclasses.replace(IDEAL, delay=0.1), 1.0)
    assert controller.q[0] == pytest.approx(RAMP * 0.9)


def test_jitter_loss_and_noise_are_those_of_the_seed() -> None:
    chancy = dataclasses.replace(IDEAL, jitter=0.05, loss=0.2, noise=0.01, seed=7)
    one, same, other = (following(s, 1.0) for s in (chancy, chancy, dataclasses.replace(chancy, seed=8)))
    found = one.measured()
    np.testing.assert_array_equal(found, same.measured())
    assert (found != other.measured()).any()
    # The newest setpoint is at most 50 ms old, and some that are lost older.
    assert 0.8 * RAMP < one.q[0] <= 0.99 * RAMP


def test_a_stop_brakes_all_joints_alike() -> None:
    controller = Controller(dataclasses.replace(IDEAL, acceleration=5.0))
    controller.begin(0.0)
    for i in range(50):
        controller.setpoint(np.array([1.0, 0.5]) * i / 100, 0, i / 100)
        controller.advance(i + 1)
    stopped = controller.q
    controller.stop()
    controller.advance(200)
    assert not controller.v.any()
    way = controller.q - stopped
    # v^2 / 2a = 0.1 m, less half of a cycle's way for the cycle in which it begins.
    assert way[0] == pytest.approx(0.1, abs=0.011)
    assert way[1] == pytest.approx(way[0] / 2)


def test_its_watchdog_stops_it() -> None:
    controller = following(dataclasses.replace(IDEAL, watchdog=0.1), 0.5)
    controller.advance(59)
    assert controller.mode() is Mode.RUNNING
    controller.advance(61)
    assert controller.mode() is Mode.READY


def test_its_watchdog_stops_jobs_that_nobody_reads() -> None:
    controller = Controller(dataclasses.replace(IDEAL, pace="JOBS", watchdog=0.1))
    controller.begin(0.0)
    controller.run([np.full(2, 10.0)], [1.0], 0)
    for cycle in range(50):
        controller.advance(cycle)
        controller.heard(cycle / 100)
    assert controller.mode() is Mode.RUNNING
    controller.advance(61)
    assert controller.mode() is Mode.READY


def test_a_silent_controller_hears_nothing() -> None:
    controller = Controller(dataclasses.replace(IDEAL, watchdog=0.1))
    controller.begin(0.0)
    controller.cause(Fault("silent", 0))
    for cycle in range(20):
        controller.setpoint(np.full(2, cycle / 100), 0, cycle / 100)
        controller.advance(cycle + 1)
    assert controller.mode() is Mode.READY
    assert not controller.q.any()


def test_jobs_keep_speed_and_acceleration_and_are_counted() -> None:
    settings = dataclasses.replace(IDEAL, pace="JOBS", speed=2.0, acceleration=4.0)
    controller = Controller(settings)
    controller.begin(0.0)
    points = [np.array([1.0, -0.5]), np.array([0.0, 0.0])]
    controller.run(points, [1.0, 0.5], 0)
    speeds, done = [0.0], []
    for i in range(500):
        controller.advance(i + 1)
        speeds.append(float(controller.v[0]))
        done.append(controller.done)
        np.testing.assert_allclose(controller.q[1], -0.5 * controller.q[0], atol=1e-9)
    np.testing.assert_allclose(controller.q, points[1], atol=1e-9)
    assert done[-1] == 2
    # The last cycle before a point goes less than a cycle's way.
    assert np.abs(np.diff(speeds)).max() <= 2 * 4.0 / 100 + 1e-9
    assert max(speeds) == pytest.approx(2.0, rel=0.03)
    assert min(speeds) == pytest.approx(-1.0, rel=0.03)


@pytest.fixture
def driver() -> Iterator[Loopback]:
    found = Loopback(LoopbackSettings(joints=2, rate=1000.0, watchdog=0.0))
    found.connect()
    yield found
    found.close()


def cause(driver: Loopback, what: What, joint: int = 0, value: float | None = None) -> None:
    driver.controller.cause(Fault(what, 0, joint, value))


def test_a_stop_of_the_controller_is_told_and_begin_refused_in_its_words(driver: Loopback) -> None:
    stops: list[tuple[What, Safety, bool]] = [
        ("protective_stop", Safety.PROTECTIVE_STOP, True),
        ("safeguard_stop", Safety.SAFEGUARD_STOP, False),
        ("emergency_stop", Safety.EMERGENCY_STOP, False),
    ]
    for what, safety, clears in stops:
        driver.begin(np.zeros(2))
        cause(driver, what, 1)
        reading = driver.read()
        assert (reading.safety, reading.mode) == (safety, Mode.READY)
        with pytest.raises(DriverFault) as refused:
            driver.begin(np.zeros(2))
        assert (str(refused.value), refused.value.clears) == (reading.text, clears)
        driver.reset()
        assert (driver.read().safety is Safety.NORMAL) == clears
        driver.controller.mend()
    assert driver.read().text == ""


@pytest.mark.parametrize(("what", "mode"), [("hand_guided", Mode.HAND_GUIDED), ("local", Mode.LOCAL)])
def test_a_mode_in_which_it_takes_no_setpoints_is_told(driver: Loopback, what: What, mode: Mode) -> None:
    driver.begin(np.zeros(2))
    cause(driver, what)
    assert driver.read().mode is mode
    with pytest.raises(DriverFault, match=r"somebody|the key"):
        driver.begin(np.zeros(2))


def test_a_joint_is_stuck_displaced_or_no_number(driver: Loopback) -> None:
    cause(driver, "displaced", 1, 0.2)
    np.testing.assert_array_equal(driver.read().positions, [0.0, 0.2])
    driver.controller.mend()
    cause(driver, "nan", 0, 1e9)
    assert np.isnan(driver.read().positions).tolist() == [True, False]
    controller = Controller(dataclasses.replace(IDEAL, faults=(Fault("stuck", 50),)))
    controller.begin(0.0)
    for i in range(100):
        controller.setpoint(np.full(2, i / 200), 0, i / 100)
        controller.advance(i + 1)
    np.testing.assert_allclose(controller.q, [49 / 200, 99 / 200], atol=0.011)
    assert controller.q[0] < 0.26


def test_a_silent_controller_is_told_after_three_cycles(driver: Loopback) -> None:
    last = driver.read()
    cause(driver, "silent")
    with pytest.raises(DriverFault, match="silent for 3 ms"):
        while True:
            assert driver.read().stamp == last.stamp
    with pytest.raises(DriverFault, match="nobody answers"):
        driver.connect()
    driver.controller.mend()
    driver.connect()
    assert driver.read().stamp > last.stamp


def test_without_power_all_is_lost_but_its_place(driver: Loopback) -> None:
    driver.begin(np.zeros(2))
    driver.controller.q[:] = 0.1, 0.2
    cause(driver, "power", value=1e9)
    for call in (driver.read, lambda: driver.send(np.zeros(2), np.zeros(2), 0)):
        with pytest.raises(DriverFault, match="connection to loopback is lost"):
            call()
    with pytest.raises(DriverFault, match="nobody answers"):
        driver.connect()
    driver.controller.mend()
    driver.connect()
    reading = driver.read()
    assert reading.mode is Mode.OFF
    np.testing.assert_array_equal(reading.positions, [0.1, 0.2])
    with pytest.raises(DriverFault, match="motors are off") as refused:
        driver.begin(reading.positions)
    assert refused.value.clears
    driver.reset()
    driver.begin(reading.positions)
    assert driver.read().mode is Mode.RUNNING


def test_a_fault_of_the_settings_comes_once_at_its_cycle() -> None:
    settings = dataclasses.replace(IDEAL, faults=(Fault("power", 40, value=5), Fault("protective_stop", 20, 1)))
    controller = Controller(settings)
    controller.advance(100)
    controller.begin(1.0)
    controller.advance(119)
    assert controller.safety() is Safety.NORMAL
    controller.advance(120)
    assert controller.safety() is Safety.PROTECTIVE_STOP
    controller.reset()
    controller.advance(139)
    assert controller.safety() is Safety.NORMAL
    controller.advance(141)
    assert controller.mode() is Mode.OFF
    controller.advance(146)
    assert not controller.active


def test_it_raises_once(driver: Loopback) -> None:
    cause(driver, "raises")
    with pytest.raises(RuntimeError, match="as it was asked to"):
        driver.read()
    driver.read()


def test_it_floods(driver: Loopback, capsys: pytest.CaptureFixture[str]) -> None:
    cause(driver, "floods")
    driver.read()
    assert len(capsys.readouterr().out) > 60_000


def test_a_teacher_asks_for_faults_by_lines() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    settings = LoopbackSettings(joints=2, control_port=port)
    driver = Loopback(settings)
    driver.connect()
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as teacher:
            teacher.settimeout(60.0)

            def said(line: str) -> str:
                teacher.sendto(line.encode(), ("127.0.0.1", port))
                driver.reset()
                return teacher.recv(4096).decode()

            assert said("displaced 1 0.05") == said("slow 0.25") == said("inputs 18446744073709551615") == "ok"
            reading = driver.read()
            assert (reading.speed_scaling, reading.inputs) == (0.25, 2**64 - 1)
            np.testing.assert_array_equal(reading.positions, [0.0, 0.05])
            state = json.loads(said("state"))
            assert (state["mode"], state["safety"], state["faults"]) == ("READY", "NORMAL", ["displaced", "slow"])
            assert said("mend") == "ok"
            assert json.loads(said("state"))["faults"] == []
            for wrong in ("", "explode", "stuck 2", "stuck 0.5", "stuck nan", "slow 2", "displaced 0 inf", "mend 1"):
                assert said(wrong).startswith("error: "), wrong
            assert json.loads(said("state"))["faults"] == []
            with pytest.raises(DriverFault, match=f"control_port {port} on 127.0.0.1 cannot be used"):
                Loopback(settings).connect()
    finally:
        driver.close()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"joints": 2, "start": [0.0]}, "start has 1 values; there are 2 joints"),
        ({"joints": 2, "faults": [{"what": "stuck", "cycle": 1, "joint": 2}]}, "a fault strikes joint 2; there are 2"),
        ({"faults": [{"what": "slow", "cycle": 1, "value": 2.0}]}, "value of 'slow' is 2"),
        ({"faults": [{"what": "explodes", "cycle": 1}]}, "it must be one of 'dies', 'displaced'"),
        ({"rate": 0}, "setting 'rate'"),
        ({"joint": 3}, "did you mean 'joints'"),
    ],
)
def test_wrong_settings_are_refused(given: dict, said: str) -> None:
    with pytest.raises(ArgumentError, match=said):
        make_settings(LoopbackSettings, given)
