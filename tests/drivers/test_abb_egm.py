"""The driver `abb_egm` against the robot's side of EGM, whose packets are those of the package ABBRobotEGM."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from ABBRobotEGM._egm_protobuf import egm_pb2 as messages
from virtualrobot_plugins.drivers.abb_egm.driver import AbbEgm, AbbEgmSettings
from virtualrobot_plugins.drivers.abb_egm.messages import MessageError, read_robot
from virtualrobot_sdk.drivers import DriverFault, Mode, Pace, Reading, Safety

from tests.drivers.peers import ADDRESS, Peer, connected, free_port
from tests.tiers import Draws
from tests.waiting import until

egm_pb2: Any = messages  # which are made at run time
HOME = [0.0, -30.0, 30.0, 0.0, 45.0, 10.0]


class Robot(Peer):
    """An ABB robot that tells what the test says."""

    def __init__(self, port: int, host: str = ADDRESS) -> None:
        """Stand at HOME, motors on, with the program at EGMRunJoint."""
        super().__init__(port, host)
        self.joints: list[float] = list(HOME)
        self.external: list[float] = []
        self.sequence, self.milliseconds = -1, 1000
        self.motors, self.mci, self.rapid, self.collision, self.digital = 1, 3, 2, False, False

    def packet(self) -> bytes:
        """Return the packet of another cycle."""
        self.sequence += 1
        self.milliseconds += 4
        said = egm_pb2.EgmRobot()
        said.header.seqno, said.header.tm, said.header.mtype = self.sequence, self.milliseconds, 2
        said.feedBack.joints.joints.extend(self.joints)
        said.feedBack.externalJoints.joints.extend(self.external)
        said.feedBack.time.sec, said.feedBack.time.usec = divmod(self.milliseconds * 1000, 1_000_000)
        said.planned.joints.joints.extend(self.joints)
        said.motorState.state, said.mciState.state, said.rapidExecState.state = self.motors, self.mci, self.rapid
        said.CollisionInfo.collsionTriggered = self.collision
        said.RAPIDfromRobot.digVal = self.digital
        said.mciConvergenceMet, said.utilizationRate = True, 12.5
        return said.SerializeToString()

    def cycle(self) -> None:
        """Send the packet of another cycle."""
        self.send(self.packet())

    def asked(self) -> list[Any]:
        """Return the answers, each an EgmSensor, that came since it was last called."""
        return [egm_pb2.EgmSensor.FromString(data) for data in self.answers()]


class Setup:
    """A driver and its robot, in lockstep."""

    def __init__(self) -> None:
        """Make both; the driver doesn't listen yet."""
        self.settings = AbbEgmSettings(controller=ADDRESS, address=ADDRESS, port=free_port())
        self.robot = Robot(self.settings.port)
        self.driver = AbbEgm(self.settings)

    def connect(self) -> None:
        self.about = connected(self.driver, self.robot.cycle)
        self.read()  # what has come since
        self.robot.asked()

    def read(self) -> Reading:
        """Return the driver's reading after another packet."""
        self.robot.cycle()
        return self.driver.read()

    def begin(self) -> None:
        self.robot.cycle()
        self.driver.begin(np.array(HOME))
        self.robot.asked()


@pytest.fixture
def setup() -> Iterator[Setup]:
    made = Setup()
    yield made
    made.driver.close()
    made.robot.close()


@pytest.fixture
def running(setup: Setup) -> Setup:
    """Return a setup that is connected and has begun."""
    setup.connect()
    setup.begin()
    return setup


def test_it_tells_joints_and_units(setup: Setup) -> None:
    setup.robot.external = [250.0, 90.0]
    setup.driver = AbbEgm(AbbEgmSettings(ADDRESS, ADDRESS, setup.settings.port, sliding=(1,)))
    setup.connect()
    assert setup.about.joints == 8 and setup.about.pace is Pace.CONTROLLER and setup.about.rate == 250.0
    degree = math.radians(1.0)
    assert setup.about.units == (*[degree] * 6, 1e-3, degree)
    reading = setup.read()
    np.testing.assert_array_equal(reading.positions, [*HOME, 250.0, 90.0])
    assert reading.mode is Mode.READY and reading.safety is Safety.NORMAL
    assert reading.stamp == pytest.approx(setup.robot.milliseconds / 1000)
    setup.robot.digital = True
    assert setup.read().inputs == 1


def test_a_robot_is_held_until_something_is_begun(setup: Setup) -> None:
    setup.connect()
    setup.robot.joints[0] = 0.02  # it sags, and is asked back to where it was
    setup.read()
    (asked,) = setup.robot.asked()
    assert list(asked.planned.joints.joints) == HOME
    assert asked.header.mtype == egm_pb2.EgmHeader.MSGTYPE_CORRECTION


def test_each_packet_is_answered_by_what_is_sent(running: Setup, rng: np.random.Generator) -> None:
    numbers = []
    for _ in range(20):
        assert running.read().mode is Mode.RUNNING
        assert running.robot.asked() == []  # not by itself any more
        wanted = rng.uniform(-90.0, 90.0, 6)
        outputs = int(rng.integers(2))
        running.driver.send(wanted, np.zeros(6), outputs)
        (asked,) = running.robot.asked()
        np.testing.assert_array_equal(asked.planned.joints.joints, wanted)
        assert asked.RAPIDtoRobot.digVal is bool(outputs)
        assert asked.header.tm == running.robot.milliseconds
        numbers.append(asked.header.seqno)
    assert numbers == list(range(numbers[0], numbers[0] + 20))
    running.driver.end()
    running.driver.send(np.zeros(6), np.zeros(6), 0)
    running.read()
    (asked,) = running.robot.asked()
    np.testing.assert_array_equal(asked.planned.joints.joints, wanted)


def test_who_connects_again_is_not_taken_for_late(running: Setup) -> None:
    """A controller that has not noticed drops what has a lower number than the answer before."""
    running.read()
    running.driver.send(np.array(HOME), np.zeros(6), 0)
    (before,) = running.robot.asked()
    running.driver.close()
    sent = time.monotonic()
    until(lambda: time.monotonic() > sent + 0.05)  # as long as the packets before would have taken
    running.driver = AbbEgm(running.settings)
    connected(running.driver, running.robot.cycle)
    running.robot.asked()
    running.read()
    (after,) = running.robot.asked()
    assert 0 < (after.header.seqno - before.header.seqno) % 2**32 < 2**31


def test_external_axes_are_answered_apart(setup: Setup) -> None:
    setup.robot.external = [250.0]
    setup.connect()
    setup.robot.cycle()
    setup.driver.begin(np.array([*HOME, 250.0]))
    setup.robot.asked()
    setup.read()
    setup.driver.send(np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 251.0]), np.zeros(7), 0)
    (asked,) = setup.robot.asked()
    assert list(asked.planned.joints.joints) == [1, 2, 3, 4, 5, 6] and list(asked.planned.externalJoints.joints) == [
        251
    ]


def test_late_and_doubled_packets_are_dropped(running: Setup) -> None:
    first, second, third = (running.robot.packet() for _ in range(3))
    running.robot.send(second)
    stamp = running.driver.read().stamp
    for late in (first, second):
        running.robot.send(late)
    running.robot.send(third)
    assert running.driver.read().stamp == pytest.approx(stamp + 0.004)
    assert running.driver.dropped == 2
    for again in (first, second, third):
        running.robot.send(again)
    with pytest.raises(DriverFault, match=r"nothing came .* 0.1 s; the last packet was refused: .* came again or late"):
        running.driver.read()


def test_of_packets_that_wait_the_newest_counts(running: Setup) -> None:
    for joint in (1.0, 2.0, 3.0):
        running.robot.joints[0] = joint
        running.robot.cycle()
    assert running.driver.read().positions[0] == 3.0
    running.robot.sequence += 50  # lost ones
    assert running.read().positions[0] == 3.0


def test_numbers_begin_anew_after_the_greatest(setup: Setup) -> None:
    setup.robot.sequence = 2**32 - 5
    setup.connect()
    setup.begin()
    setup.robot.sequence = 2**32 - 2
    setup.read()
    setup.robot.sequence = -1
    setup.robot.joints[0] = 7.0
    assert setup.read().positions[0] == 7.0


def test_strangers_are_not_heard(running: Setup) -> None:
    other_port, other_host = Robot(running.settings.port), Robot(running.settings.port, "127.0.0.1")
    for stranger in (other_port, other_host):
        stranger.sequence, stranger.milliseconds = 10**6, 10**6
        stranger.joints = [9.0] * 6
        stranger.cycle()
    assert list(running.read().positions) == HOME
    running.driver.send(np.array(HOME), np.zeros(6), 0)
    assert other_port.answers() == other_host.answers() == []
    assert len(running.robot.asked()) == 1
    other_host.cycle()
    with pytest.raises(DriverFault, match="3 packets came from others"):
        running.driver.read()
    for stranger in (other_port, other_host):
        stranger.close()


def test_a_flood_is_a_fault(running: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("virtualrobot_plugins.drivers.datagrams.MOST_AT_ONCE", 100)
    packet = running.robot.packet()
    for _ in range(120):
        running.robot.send(packet)
    with pytest.raises(DriverFault, match=f"more than 100 packets wait at {ADDRESS}:{running.settings.port}"):
        running.driver.read()


def test_another_count_of_joints_is_a_fault(running: Setup) -> None:
    running.robot.joints = HOME[:5]
    for _ in range(2):
        with pytest.raises(DriverFault, match="the controller tells 5 joints; it had 6 before"):
            running.read()
        running.driver.stop()
        running.robot.sequence = -1  # and in a new session, too


def test_what_is_no_number_is_read_and_not_answered(setup: Setup) -> None:
    setup.connect()
    setup.robot.mci = egm_pb2.EgmMCIState.MCI_STOPPED
    setup.robot.joints[2] = math.nan
    assert math.isnan(setup.read().positions[2])  # the host refuses it, with its value
    assert setup.robot.asked() == []


def test_a_controller_that_tells_no_numbers_is_refused(setup: Setup) -> None:
    setup.robot.joints[2] = math.inf
    with pytest.raises(DriverFault, match=r"joints that are no numbers: \[0.0, -30.0, inf"):
        setup.connect()


@pytest.mark.parametrize(
    ("change", "mode", "safety", "text"),
    [
        ({"motors": 2}, Mode.OFF, Safety.PROTECTIVE_STOP, "the motors are off"),
        ({"rapid": 1}, Mode.LOCAL, Safety.PROTECTIVE_STOP, "the robot's program stands"),
        ({"mci": 2}, Mode.STARTING, Safety.PROTECTIVE_STOP, "not at EGMRunJoint"),
        ({"mci": 1}, Mode.RUNNING, Safety.FAULT, "MCI_ERROR"),
        ({"collision": True}, Mode.RUNNING, Safety.PROTECTIVE_STOP, "has seen a collision"),
    ],
)
def test_what_stops_a_robot_is_told(running: Setup, change: dict, mode: Mode, safety: Safety, text: str) -> None:
    vars(running.robot).update(change)
    reading = running.read()
    assert (reading.mode, reading.safety) == (mode, safety)
    assert text in reading.text
    running.driver.stop()
    if mode is Mode.RUNNING or mode is Mode.STARTING:
        return
    running.robot.cycle()
    with pytest.raises(DriverFault, match=text):
        running.driver.begin(np.array(HOME))


def test_a_program_that_begins_anew_is_a_fault_only_while_it_is_followed(running: Setup) -> None:
    running.robot.sequence = -1
    with pytest.raises(DriverFault, match="has ended guided motion, and begun it anew"):
        running.read()
    running.driver.end()
    running.robot.sequence, running.robot.joints = -1, [5.0] * 6
    assert list(running.read().positions) == [5.0] * 6
    (asked,) = running.robot.asked()
    assert list(asked.planned.joints.joints) == [5.0] * 6


def test_a_controller_that_is_gone_is_a_fault_and_reached_again(running: Setup) -> None:
    with pytest.raises(DriverFault, match=f"nothing came from the controller {ADDRESS} at {ADDRESS}:"):
        running.driver.read()
    running.robot.close()
    running.robot = Robot(running.settings.port)
    running.connect()
    assert running.read().mode is Mode.READY


def test_nobody_at_the_port_or_a_port_in_use_is_told(setup: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("virtualrobot_plugins.drivers.abb_egm.driver.BEGIN_SECONDS", 0.05)
    with pytest.raises(DriverFault, match=r"nothing came .* start the robot's program, which has to come to"):
        setup.driver.connect()
    taken = Peer(1)
    driver = AbbEgm(AbbEgmSettings(ADDRESS, ADDRESS, taken.socket.getsockname()[1]))
    with pytest.raises(DriverFault, match=r"cannot be listened at: .*in use"):
        driver.connect()
    with pytest.raises(DriverFault, match=r"'no\.such\.host\.invalid' has no address"):
        AbbEgm(AbbEgmSettings("no.such.host.invalid")).connect()
    taken.close()


def test_broken_bytes_are_refused_in_words(rng: np.random.Generator, draws: Draws) -> None:
    robot = Robot(1)
    for _ in range(draws(2000)):
        data = bytearray(robot.packet())
        for _ in range(rng.integers(1, 4)):
            at = rng.integers(len(data))
            if rng.integers(2):
                data[at] = rng.integers(256)
            else:
                del data[at:]
                break
            if not data:
                break
        try:
            read_robot(bytes(data))
        except MessageError as error:
            assert str(error).startswith("no EgmRobot: ")
    robot.close()
