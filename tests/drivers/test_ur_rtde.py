"""The driver `ur_rtde` and an emulated controller, cycle by cycle."""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.ur import exchange, server
from virtualrobot_apps.emulators.ur.controller import Controller, RobotMode, SafetyMode
from virtualrobot_apps.emulators.ur.server import Client, Server
from virtualrobot_plugins.drivers.ur_rtde.driver import UrRtde, UrRtdeSettings
from virtualrobot_plugins.drivers.ur_rtde.words import message
from virtualrobot_sdk.drivers import DriverFault, Mode, Reading, Safety
from virtualrobot_sdk.drivers.driver import finite
from virtualrobot_sdk.poses import rotation_matrix

from tests.drivers.peers import ADDRESS
from tests.drivers.ur_controllers import BUSY, NOBODY
from tests.waiting import repeated

HOME = np.array([0.0, -1.57, 1.57, -1.57, -1.57, 0.0])


class Setup:
    """A driver and its controller, in lockstep."""

    def __init__(self, **controller: object) -> None:
        """Make both; the driver doesn't connect yet."""
        self.arm = SimulatedArm(HOME)
        self.controller = Controller(self.arm, **controller)  # type: ignore[arg-type]
        self.server = Server(self.controller, ADDRESS)
        self.settings = UrRtdeSettings(ADDRESS, 500, watchdog=BUSY, silence=BUSY, outputs=(0, 9))
        self.driver = UrRtde(self.settings)

    def connect(self) -> None:
        with repeated(self.server.cycle):
            self.about = self.driver.connect()

    def begin(self) -> None:
        held = self.arm.read()[0]
        with repeated(self.server.cycle):
            self.driver.begin(held)

    def reset(self) -> None:
        with repeated(self.server.cycle):
            self.driver.reset()

    def cycle(self, count: int = 1) -> Reading:
        """Let the controller go on, and read once it has told all of it."""
        for _ in range(count):
            self.server.cycle()
        now = self.controller.cycles * self.controller.dt
        while (reading := self.driver.read()).stamp < now:
            pass
        return reading

    def follow(self, positions: np.ndarray, outputs: int = 0) -> Reading:
        """Send a setpoint, which the controller has got at the end of its cycle."""
        before = self.controller.inputs.get("input_int_register_24")
        self.driver.send(positions, np.zeros(6), outputs)
        while self.controller.inputs.get("input_int_register_24") == before:
            self.server.cycle()
        return self.cycle(0)

    def close(self) -> None:
        self.driver.close()
        self.server.close()


@pytest.fixture
def setup() -> Iterator[Setup]:
    made = Setup()
    yield made
    made.close()


@pytest.fixture
def running(setup: Setup) -> Setup:
    """Return a setup that is connected and has begun."""
    setup.connect()
    setup.begin()
    return setup


def fault(setup: Setup) -> DriverFault:
    """Return what connecting complains of."""
    with repeated(setup.server.cycle), pytest.raises(DriverFault) as found:
        setup.driver.connect()
    return found.value


def test_it_tells_what_the_controller_is(setup: Setup) -> None:
    setup.connect()
    about = setup.about
    assert (about.joints, about.rate, about.watchdog) == (6, 500.0, BUSY)
    assert (about.model, about.version, about.serial) == ("Universal Robots UR5", "5.26.0.0", "20195500001")
    setup.controller.digital_inputs = 0b100000000000000101
    reading = setup.cycle()
    np.testing.assert_array_equal(reading.positions, HOME)
    assert (reading.mode, reading.safety, reading.text) == (Mode.READY, Safety.NORMAL, "")
    assert reading.inputs == 0b100000000000000101 and reading.speed_scaling == 1.0
    assert reading.stamp == setup.controller.cycles * 0.002


def test_the_arm_follows_and_ends(running: Setup) -> None:
    goal = HOME.copy()
    for _ in range(100):
        goal += 0.0005
        reading = running.follow(goal)
        assert reading.mode is Mode.RUNNING
    # The arm is behind by its lag of 20 ms, at 0.25 rad/s.
    assert np.abs(reading.positions - goal).max() < 0.006
    np.testing.assert_array_equal(reading.velocities, running.arm.read()[1])
    for _ in range(200):
        reading = running.follow(goal)
    np.testing.assert_allclose(reading.positions, goal, atol=1e-4)
    running.driver.end()
    reading = running.cycle(50)
    assert reading.mode is Mode.READY and running.controller.program is None
    running.driver.send(goal + 0.1, np.zeros(6), 0)  # which nobody has begun
    np.testing.assert_allclose(running.cycle(50).positions, goal, atol=1e-4)


def test_a_stop_in_motion_comes_to_rest_and_it_begins_again(running: Setup) -> None:
    goal = HOME.copy()
    for _ in range(200):
        goal += 0.001
        running.follow(goal)
    running.driver.stop()
    rest = running.cycle(500)
    assert rest.velocities is not None and np.abs(rest.velocities).max() < 1e-6
    # From 0.5 rad/s with at least 4 rad/s^2 it is at rest within 31 mrad, and the lag was 10.
    assert np.abs(rest.positions - goal).max() < 0.045
    running.begin()
    np.testing.assert_allclose(running.follow(rest.positions).positions, rest.positions, atol=1e-4)


def test_the_controllers_watchdog_stops_a_robot_whose_driver_is_silent(running: Setup) -> None:
    goal = HOME.copy()
    for _ in range(50):
        goal += 0.001
        running.follow(goal)
    reading = running.cycle(round(BUSY * 500) + 50)
    assert reading.mode is Mode.READY and "RTDE watchdog: input_int_register_24" in reading.text
    assert np.abs(running.cycle(500).positions - goal).max() < 0.01
    assert running.controller.program is None


def test_outputs_of_the_settings_alone_are_set(running: Setup) -> None:
    running.controller.digital_outputs = 0b10  # somebody else's
    running.follow(HOME, 0b1111111111111111)
    assert running.controller.digital_outputs == 0b1000000011
    running.follow(HOME, 0)
    assert running.controller.digital_outputs == 0b10
    running.follow(HOME, 1)
    running.driver.end()
    running.cycle(20)
    assert running.controller.digital_outputs == 0b11  # which stay


def test_a_protective_stop_in_motion_is_told_and_unlocked(running: Setup) -> None:
    goal = HOME.copy()
    for _ in range(50):
        goal += 0.001
        running.follow(goal)
    running.controller.protective_stop("Position deviates from path: Elbow", 153, 2)
    reading = running.cycle(300)
    assert reading.safety is Safety.PROTECTIVE_STOP and reading.mode is not Mode.RUNNING
    assert reading.text == "protective stop: C153A2: Position deviates from path: Elbow"
    rest = reading.positions
    with pytest.raises(DriverFault, match="C153A2: Position deviates from path: Elbow") as refused:
        running.begin()
    assert refused.value.clears
    running.reset()
    reading = running.cycle()
    assert (reading.safety, reading.text) == (Safety.NORMAL, "")
    np.testing.assert_allclose(running.cycle(100).positions, rest, atol=1e-6)
    running.begin()


@pytest.mark.parametrize(
    ("safety", "expected", "words"),
    [
        (SafetyMode.REDUCED, Safety.REDUCED, ""),
        (SafetyMode.RECOVERY, Safety.FAULT, "recovery mode"),
        (SafetyMode.SAFEGUARD_STOP, Safety.SAFEGUARD_STOP, "safeguard stop"),
        (SafetyMode.SYSTEM_EMERGENCY_STOP, Safety.EMERGENCY_STOP, "emergency stop of the system"),
        (SafetyMode.ROBOT_EMERGENCY_STOP, Safety.EMERGENCY_STOP, "emergency stop of the robot"),
        (SafetyMode.VIOLATION, Safety.FAULT, "violation"),
        (SafetyMode.FAULT, Safety.FAULT, "fault of the safety system"),
    ],
)
def test_what_the_safety_system_says_is_told(setup: Setup, safety: SafetyMode, expected: Safety, words: str) -> None:
    setup.connect()
    setup.controller.safety = safety
    reading = setup.cycle()
    assert reading.safety is expected and words in reading.text
    if expected is not Safety.REDUCED:
        with pytest.raises(DriverFault, match=words) as refused:
            setup.begin()
        assert not refused.value.clears


def test_what_keeps_it_from_following_is_told(setup: Setup) -> None:
    setup.connect()
    setup.controller.power_off()
    assert setup.cycle().mode is Mode.OFF
    with pytest.raises(DriverFault, match="it is OFF: switch it on and release its brakes"):
        setup.begin()
    setup.controller.power_on()
    assert setup.cycle().mode is Mode.STARTING
    setup.controller.release_brakes()
    assert setup.cycle(100).mode is Mode.READY
    setup.controller.mode = RobotMode.BACKDRIVE
    assert setup.cycle().mode is Mode.HAND_GUIDED
    setup.controller.mode = RobotMode.RUNNING
    setup.controller.remote = False
    with pytest.raises(DriverFault, match="is in local control"):
        setup.begin()
    setup.controller.remote = True
    setup.begin()


def test_the_tool_is_told(running: Setup, rng: np.random.Generator) -> None:
    tcp = np.eye(4)
    tcp[:3, :3], tcp[:3, 3] = rotation_matrix(rng.uniform(-1.0, 1.0, 3)), rng.uniform(-0.2, 0.2, 3)
    center = rng.uniform(-0.1, 0.1, 3)
    running.driver.set_tool(1.25, center, tcp)
    while not running.controller.mass:
        running.follow(HOME)
    np.testing.assert_allclose(running.controller.tcp, tcp, atol=1e-7)
    np.testing.assert_allclose(running.controller.center, center, atol=1e-7)
    assert running.cycle().mode is Mode.RUNNING  # the program has gone on


def test_speed_scaling_is_told_while_it_follows(running: Setup) -> None:
    running.controller.slider = 0.4
    assert running.follow(HOME).speed_scaling == pytest.approx(0.4)


def test_packets_may_come_in_pieces(running: Setup, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> None:
    whole = Client.send

    def in_pieces(client: Client, data: bytes = b"") -> None:
        client.waiting += data
        if client.port == server.RTDE and client.waiting:
            data = bytes(client.waiting[: rng.integers(1, 300)])
            del client.waiting[: len(data)]
            client.connection.sendall(data)
        else:
            whole(client)

    monkeypatch.setattr(Client, "send", in_pieces)
    stamps = []
    for _ in range(300):
        running.driver.send(HOME, np.zeros(6), 0)
        running.server.cycle()
        reading = running.driver.read()
        np.testing.assert_allclose(reading.positions, HOME, atol=1e-9)
        stamps.append(reading.stamp)
    # Each piece is 150 bytes on the average, and a packet 143.
    assert np.all(np.diff(stamps) >= 0.0) and stamps[-1] > stamps[0] + 0.2


def test_what_is_no_number_is_found_by_the_host(running: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running.arm, "read", lambda: (np.full(6, np.nan), np.zeros(6)))
    assert "they must be finite" in finite(running.cycle(), 6)


def test_a_silent_controller_is_told_and_a_closed_one_at_once(setup: Setup) -> None:
    setup.driver = UrRtde(replace(setup.settings, silence=0.1))
    setup.connect()
    with pytest.raises(DriverFault, match=rf"{ADDRESS}:30004 has been silent for 0.1 s, its connection open") as found:
        while True:
            setup.driver.read()
    assert found.value.clears
    setup.connect()
    setup.server.close()
    with pytest.raises(DriverFault, match=r"has closed the connection|is lost"):
        setup.driver.read()


def test_nobody_is_told(setup: Setup) -> None:
    with pytest.raises(DriverFault, match=rf"no controller of Universal Robots answers at {NOBODY}:30004"):
        UrRtde(UrRtdeSettings(NOBODY)).connect()
    with pytest.raises(DriverFault, match=r"answers at no\.such\.host\.invalid:30004"):
        UrRtde(UrRtdeSettings("no.such.host.invalid")).connect()


def test_wrong_controllers_are_refused(setup: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    setup.controller.version = (3, 4, 0, 1)
    assert str(fault(setup)) == "the controller runs 3.4; this driver needs 3.9, or 5.3 and later"
    setup.controller.version = (3, 15, 0, 1)
    assert "set rate to 125" in str(fault(setup))
    setup.controller.version = (5, 11, 0, 1)
    told = exchange.values.OUTPUTS
    monkeypatch.setitem(told, "actual_q", "DOUBLE")
    assert "has actual_q as DOUBLE; it must be VECTOR6D" in str(fault(setup))
    monkeypatch.delitem(told, "actual_q")
    assert "has actual_q as NOT_FOUND" in str(fault(setup))
    monkeypatch.undo()
    monkeypatch.setattr(exchange.Session, "take", lambda *_: exchange.packet(exchange.VERSION, b"\0"))
    assert "doesn't speak version 2 of RTDE" in str(fault(setup))


def test_two_programs_do_not_set_the_same(setup: Setup) -> None:
    setup.connect()
    other = UrRtde(setup.settings)
    with repeated(setup.server.cycle), pytest.raises(DriverFault, match="another program sets input_int_register_24"):
        other.connect()
    setup.driver.close()
    with repeated(setup.server.cycle):
        other.connect()
    other.close()


def test_one_that_accepts_and_is_silent_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("virtualrobot_plugins.drivers.ur_rtde.driver.CONNECT_SECONDS", 0.2)
    host = ADDRESS.replace("127.", "127.128.", 1).rsplit(".", 1)[0]
    with (
        socket.create_server((host, 30004)),
        pytest.raises(DriverFault, match="has accepted the connection and is silent"),
    ):
        UrRtde(UrRtdeSettings(host)).connect()


def test_each_kind_of_message_is_read() -> None:
    head = struct.pack(">QB", 1, 2)
    assert message(server.message(7, 153, 2, "Elbow")[5:]) == ("C153A2", "Elbow")
    assert message(server.message(7, 0, 0, "Emergency stop")[5:]) == ("", "Emergency stop")
    key = head + b"\7" + struct.pack(">iiB", 4, 5, 5) + b"Title" + b"and text"
    assert message(key) == ("C4A5", "Title: and text")
    assert message(head + b"\12" + struct.pack(">ii", 3, 9) + b"name_error\n") == ("", "line 3, column 9: name_error")
    assert message(head + b"\3" + b"URControl") is None
    assert message(b"\0") is None
