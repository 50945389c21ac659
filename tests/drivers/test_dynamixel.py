"""The driver `dynamixel`, by its makers' library, against servos that are written from the e-Manual."""

from __future__ import annotations

import math
import resource
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from dynamixel_sdk import Protocol2PacketHandler
from virtualrobot_plugins.drivers.dynamixel.driver import Dynamixel, DynamixelSettings
from virtualrobot_sdk.drivers import DriverFault, Mode, Safety
from virtualrobot_sdk.errors import ArgumentError

from tests.drivers.cables import Cable
from tests.drivers.servos import GOAL, HARDWARE_ERROR, OPERATING_MODE, TORQUE, WATCHDOG, Servo, Servos, crc
from tests.tiers import Draws

PATIENT = 20.0
"""Silence (s) that tests bear where silence is not what they are about."""
ZERO = np.zeros(3)


@pytest.fixture
def servos(cable: Cable) -> Servos:
    """Return a bus of three servos on the cable."""
    servos = Servos(Servo(1, 2000), Servo(2, 2048), Servo(7, 3000))
    cable.serve(servos)
    return servos


@pytest.fixture
def settings(cable: Cable) -> DynamixelSettings:
    """Return settings for these, in another order."""
    return DynamixelSettings(
        str(cable.path), (2, 7, 1), baud=1_000_000, rate=100.0, watchdog_seconds=2.54, silence_seconds=PATIENT
    )


@pytest.fixture
def driver(servos: Servos, settings: DynamixelSettings) -> Iterator[Dynamixel]:
    """Return a driver of the servos."""
    driver = Dynamixel(settings)
    yield driver
    driver.close()


def test_the_check_is_that_of_the_makers(rng: np.random.Generator) -> None:
    for size in (1, 7, 200):
        data = rng.bytes(size)
        assert crc(data) == Protocol2PacketHandler().updateCRC(0, list(data), size)


def test_it_says_what_it_is(driver: Dynamixel) -> None:
    about = driver.connect()
    assert (about.joints, about.rate, about.watchdog) == (3, 100.0, 2.54)
    assert about.units == pytest.approx(2 * math.pi / 4096)
    assert (about.model, about.version) == ("Dynamixel 1060, 1060, 1060", "45, 45, 45")
    reading = driver.read()
    assert reading.positions == pytest.approx([0, 952, -48])
    assert (reading.mode, reading.safety) == (Mode.READY, Safety.NORMAL)


def test_it_follows_in_the_order_of_the_joints(driver: Dynamixel, servos: Servos) -> None:
    driver.connect()
    held = driver.read().positions
    driver.begin(held)
    # With the torque comes no motion.
    assert driver.read().positions == pytest.approx(held)
    goal = np.array([300.0, -300.0, -2000.4])
    driver.send(goal, ZERO, 0)
    while np.abs(driver.read().positions - goal).max() > 0.5:
        pass
    assert [servos.servos[number].get(GOAL, 4) for number in (2, 7, 1)] == [2348, 1748, 48]
    assert driver.read().mode is Mode.RUNNING


def test_velocities_are_those_of_the_way(driver: Dynamixel, servos: Servos) -> None:
    servos.servos[2].speed = 200.0
    driver.connect()
    driver.begin(driver.read().positions)
    driver.send(np.array([1900.0, 952.0, -48.0]), ZERO, 0)
    driver.read()
    told = driver.read().velocities
    assert told is not None
    # They are told in steps of 15.6 pulses a second.
    assert told == pytest.approx([200.0, 0.0, 0.0], abs=8.0)


def test_a_stop_holds_and_follows_nothing_more(driver: Dynamixel, servos: Servos) -> None:
    driver.connect()
    driver.stop()
    driver.begin(driver.read().positions)
    for servo in servos.servos.values():
        servo.speed = 200.0
    driver.send(np.array([1900.0, 952.0, -48.0]), ZERO, 0)
    while driver.read().positions[0] < 5.0:
        pass
    driver.stop()
    rest = driver.read().positions
    driver.send(np.array([1900.0, 952.0, -48.0]), ZERO, 0)
    while np.any(driver.read().velocities):
        pass
    assert driver.read().positions[0] < 1000.0
    assert driver.read().mode is Mode.READY
    driver.begin(rest)
    assert driver.read().mode is Mode.RUNNING


@pytest.mark.parametrize("keeps", [True, False])
def test_torque_is_kept_as_the_settings_say(settings: DynamixelSettings, servos: Servos, keeps: bool) -> None:
    driver = Dynamixel(replace(settings, keeps_torque=keeps))
    driver.connect()
    driver.begin(driver.read().positions)
    assert all(servo.table[WATCHDOG] == 127 for servo in servos.servos.values())
    driver.end()
    driver.read()
    assert [servo.table[TORQUE] for servo in servos.servos.values()] == [int(keeps)] * 3
    assert [servo.table[WATCHDOG] for servo in servos.servos.values()] == [0] * 3
    driver.close()
    driver.close()


def test_an_overload_is_told_in_words_and_cleared(driver: Dynamixel, servos: Servos) -> None:
    driver.connect()
    driver.begin(driver.read().positions)
    servos.servos[7].overload()
    reading = driver.read()
    assert (reading.safety, reading.text) == (Safety.FAULT, "servo 7: overload")
    driver.stop()
    with pytest.raises(DriverFault, match=r"^servo 7: overload$") as fault:
        driver.begin(reading.positions)
    assert fault.value.clears
    assert driver.connect().joints == 3
    driver.reset()
    assert servos.servos[7].table[HARDWARE_ERROR] == 0
    assert driver.read().safety is Safety.NORMAL
    driver.begin(driver.read().positions)


def test_damaged_answers_are_asked_again(driver: Dynamixel, servos: Servos) -> None:
    driver.connect()
    servos.damage = 2
    assert driver.read().positions == pytest.approx([0, 952, -48])
    servos.damage = 10
    with pytest.raises(DriverFault, match=r"servo 2 on .*ttyROBOT doesn't answer: Incorrect status packet"):
        driver.read()


def test_whatever_comes_is_a_reading_or_a_fault(
    cable: Cable, settings: DynamixelSettings, rng: np.random.Generator, draws: Draws
) -> None:
    servos = Servos(Servo(1, 2000), Servo(2, 2048), Servo(7, 3000))
    mangles = False

    def answer(data: bytes) -> bytes:
        said = servos(data)
        if not (mangles and said) or rng.random() < 0.1:
            return said
        mangled = bytearray(said)
        for _ in range(rng.integers(1, 4)):
            place = int(rng.integers(len(mangled)))
            mangled[place : place + rng.integers(0, 3)] = rng.bytes(int(rng.integers(0, 4)))
        return bytes(mangled)

    cable.serve(answer)
    driver = Dynamixel(settings)
    driver.connect()
    mangles, driver._open()._port.silence_ms = True, 20.0
    for _ in range(draws(200)):
        try:
            assert driver.read().positions == pytest.approx([0, 952, -48])
        except DriverFault as fault:
            assert "ttyROBOT doesn't answer" in str(fault)
    driver.close()


def test_bytes_that_look_like_a_header_are_taken_apart(driver: Dynamixel, servos: Servos) -> None:
    """Position 0x00fdffff: the packet has a byte stuffed."""
    servos.servos[2].put(OPERATING_MODE, 1, 4)
    servos.servos[2].at = float(0x00FDFFFF)
    driver.connect()
    assert driver.read().positions[0] == 0x00FDFFFF - 2048


def test_a_servo_that_is_gone_is_told(settings: DynamixelSettings, servos: Servos) -> None:
    """The library alone asks the port without end: a second of waiting is a second of a core."""
    driver = Dynamixel(replace(settings, silence_seconds=1.0))
    driver.connect()
    servos.servos[7].answers = False
    before = resource.getrusage(resource.RUSAGE_THREAD)
    with pytest.raises(DriverFault, match=r"^-3001: servo 7 on .*ttyROBOT doesn't answer: There is no status packet$"):
        driver.read()
    after = resource.getrusage(resource.RUSAGE_THREAD)
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 0.5
    with pytest.raises(DriverFault, match=r"servo 7 doesn't answer on .* at 1000000 baud; of \[2, 7, 1\] answers 2, 1"):
        driver.connect()
    servos.servos[7].answers = True
    assert driver.connect().joints == 3
    driver.close()


def test_the_watchdog_of_the_servos_is_told(settings: DynamixelSettings, servos: Servos) -> None:
    driver = Dynamixel(replace(settings, watchdog_seconds=0.02))
    driver.connect()
    driver.begin(driver.read().positions)
    while servos.servos[2].table[WATCHDOG] != 0xFF:
        servos.servos[2].advance()
        servos.servos[2].heard -= 1.0
        driver._heard -= 1.0
    with pytest.raises(DriverFault, match="their watchdog has stopped them"):
        driver.read()
    driver.begin(driver.read().positions)
    assert driver.read().mode is Mode.RUNNING
    driver.close()


def test_settings_that_the_servos_cannot_do_are_refused(settings: DynamixelSettings, servos: Servos) -> None:
    with pytest.raises(
        DriverFault, match=r"1000 Hz is too fast for 3 servos at 57600 baud: a cycle of 127 bytes takes"
    ):
        Dynamixel(replace(settings, baud=57600, rate=1000.0)).connect()
    with pytest.raises(DriverFault, match=r"no 12345 baud"):
        Dynamixel(replace(settings, baud=12345)).connect()
    servos.servos[7].put(OPERATING_MODE, 1, 1)
    with pytest.raises(DriverFault, match=r"servo 7 is in operating mode 1; it must be one of 3 \(position\), 4"):
        Dynamixel(settings).connect()
    with pytest.raises(ArgumentError, match=r"ids are \[1, 1\]"):
        replace(settings, ids=(1, 1))


def test_goals_beyond_a_servos_limits_are_refused(driver: Dynamixel) -> None:
    """A servo would ignore them without a word."""
    driver.connect()
    driver.begin(driver.read().positions)
    with pytest.raises(DriverFault, match=r"servo 7 to 4148 pulses: it goes from 0 to 4095"):
        driver.send(np.array([0.0, 2100.0, 0.0]), ZERO, 0)


def test_unplugged_is_told_and_replugged_connects_again(driver: Dynamixel, servos: Servos, cable: Cable) -> None:
    driver.connect()
    cable.unplug()
    with pytest.raises(DriverFault, match=r"ttyROBOT is gone"):
        driver.read()
    with pytest.raises(DriverFault, match=r"ttyROBOT can't be opened: .*; this machine has "):
        driver.connect()
    cable.plug()
    cable.serve(servos)
    assert driver.connect().joints == 3
    assert driver.read().positions == pytest.approx([0, 952, -48])
