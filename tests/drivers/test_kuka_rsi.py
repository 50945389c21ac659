"""The driver `kuka_rsi` against the robot's side of RSI: messages as KUKA has them, and the emulator of RSIPI."""

from __future__ import annotations

import importlib
import importlib.util
import math
import re
import socket
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any, Literal

import numpy as np
import pytest
from virtualrobot_plugins.drivers.kuka_rsi.driver import KukaRsi, KukaRsiSettings
from virtualrobot_plugins.drivers.kuka_rsi.messages import MessageError, read_robot
from virtualrobot_sdk.drivers import DriverFault, Mode, Pace, Reading

from tests.drivers.peers import ADDRESS, Peer, connected, free_port
from tests.tiers import Draws

HOME = [0.0, -90.0, 90.0, 0.0, 45.0, 10.0]


def numbered(letter: str, values: list[float]) -> str:
    return " ".join(f'{letter}{axis}="{value}"' for axis, value in enumerate(values, 1))


class Robot(Peer):
    """A KUKA robot that tells what the test says."""

    def __init__(self, port: int, host: str = ADDRESS) -> None:
        """Stand at HOME, with RSI just switched on."""
        super().__init__(port, host)
        self.joints: list[float] = list(HOME)
        self.external: list[float] = []
        self.commanded: list[float] = []
        self.stamp, self.cycle_ms, self.late = 4_208_163_634, 4, 0
        self.more = ""

    def packet(self) -> bytes:
        """Return the message of another cycle."""
        self.stamp += self.cycle_ms
        parts = [f"<AIPos {numbered('A', self.joints)} />"]
        if self.commanded:
            parts.append(f"<ASPos {numbered('A', self.commanded)} />")
        if self.external:
            parts.append(f"<EIPos {numbered('E', self.external)} />")
        parts += [f'<Delay D="{self.late}" />', self.more, f"<IPOC>{self.stamp}</IPOC>"]
        return f'<Rob Type="KUKA">{"".join(parts)}</Rob>'.encode()

    def cycle(self) -> None:
        """Send the message of another cycle."""
        self.send(self.packet())

    def asked(self) -> list[str]:
        """Return the answers that came since it was last called."""
        return [data.decode() for data in self.answers()]


class Setup:
    """A driver and its robot, in lockstep."""

    def __init__(self, **settings: Any) -> None:  # noqa: ANN401 those of the driver
        """Make both; the driver doesn't listen yet."""
        self.settings = KukaRsiSettings(controller=ADDRESS, address=ADDRESS, port=free_port(), **settings)
        self.robot = Robot(self.settings.port)
        self.driver = KukaRsi(self.settings)

    def connect(self) -> None:
        self.about = connected(self.driver, self.robot.cycle)
        self.read()  # what has come since
        self.robot.asked()

    def read(self) -> Reading:
        """Return the driver's reading after another message."""
        self.robot.cycle()
        return self.driver.read()

    def begin(self) -> None:
        self.robot.cycle()
        self.driver.begin(np.array(self.robot.joints))
        self.robot.asked()

    def close(self) -> None:
        self.driver.close()
        self.robot.close()


@pytest.fixture
def make() -> Iterator[Callable[..., Setup]]:
    """Return a function that makes a setup with these settings."""
    made = []

    def one(**settings: Any) -> Setup:  # noqa: ANN401 those of the driver
        made.append(Setup(**settings))
        return made[-1]

    yield one
    for setup in made:
        setup.close()


@pytest.fixture
def running(make: Callable[..., Setup]) -> Setup:
    """Return a setup that is connected and has begun."""
    setup = make()
    setup.connect()
    setup.begin()
    return setup


def test_it_tells_axes_units_and_inputs(make: Callable[..., Setup]) -> None:
    setup = make(external=2, sliding=(1,), inputs_tag="DiL", outputs_tag="DiO", joints=5)
    setup.robot.external, setup.robot.more = [250.0, 90.0], "<DiL>5</DiL>"
    setup.connect()
    about, degree = setup.about, math.radians(1.0)
    assert (about.joints, about.rate, about.pace, about.watchdog) == (7, 250.0, Pace.CONTROLLER, 0.4)
    assert about.units == (*[degree] * 5, 1e-3, degree) and about.inputs == about.outputs == 32
    reading = setup.read()
    np.testing.assert_array_equal(reading.positions, [*HOME[:5], 250.0, 90.0])
    assert reading.inputs == 5 and reading.mode is Mode.READY
    assert reading.stamp == pytest.approx(setup.robot.stamp / 1000)
    setup.begin()
    setup.read()
    setup.driver.send(np.array([1.0, 1.0, 1.0, 1.0, 1.0, 251.5, 92.0]), np.zeros(7), 9)
    (asked,) = setup.robot.asked()
    assert '<EK E1="1.500000" E2="2.000000" />' in asked and "<DiO>9</DiO>" in asked


def test_a_robot_is_held_until_something_is_begun(make: Callable[..., Setup]) -> None:
    setup = make()
    setup.connect()
    setup.robot.joints[0] = 0.3
    setup.read()
    zeros = numbered("A", ["0.000000"] * 6)  # pyright: ignore[reportArgumentType] as they are written
    assert setup.robot.asked() == [f'<Sen Type="ImFree"><AK {zeros} /><IPOC>{setup.robot.stamp}</IPOC></Sen>']


@pytest.mark.parametrize("corrections", ["absolute", "relative"])
def test_each_message_is_answered_once(make: Callable[..., Setup], rng: np.random.Generator, corrections: str) -> None:
    setup = make(corrections=corrections)
    setup.robot.commanded = [0.5, *HOME[1:]]
    setup.connect()
    setup.begin()
    last = start = np.array(setup.robot.commanded)
    for _ in range(20):
        assert setup.read().mode is Mode.RUNNING
        wanted = start + rng.uniform(-5.0, 5.0, 6)
        setup.driver.send(wanted, np.zeros(6), 0)
        setup.driver.send(start, np.zeros(6), 0)  # too much: the message has its answer
        (asked,) = setup.robot.asked()
        got = [float(value) for value in re.findall(r'A\d="([^"]*)"', asked)]
        np.testing.assert_allclose(got, wanted - (start if corrections == "absolute" else last), atol=1e-6)
        assert f"<IPOC>{setup.robot.stamp}</IPOC>" in asked
        last = wanted
        setup.driver.send(wanted, np.zeros(6), 0)
    for stop in (setup.driver.stop, setup.driver.end):
        stop()
        setup.driver.send(start, np.zeros(6), 0)
        setup.read()
        (asked,) = setup.robot.asked()
        got = [float(value) for value in re.findall(r'A\d="([^"]*)"', asked)]
        held = last - start if corrections == "absolute" else np.zeros(6)
        np.testing.assert_allclose(got, held, atol=1e-6)


def test_late_doubled_and_strange_messages_are_dropped(running: Setup) -> None:
    first, second, third = (running.robot.packet() for _ in range(3))
    running.robot.send(second)
    stamp = running.driver.read().stamp
    stranger = Robot(running.settings.port)
    stranger.stamp += 10**6
    stranger.cycle()
    for data in (first, second, third):
        running.robot.send(data)
    assert running.driver.read().stamp == pytest.approx(stamp + 0.004)
    assert running.driver.dropped == 2
    stranger.close()


def test_late_answers_are_told(make: Callable[..., Setup]) -> None:
    for corrections in ("absolute", "relative"):
        setup = make(corrections=corrections)
        setup.connect()
        setup.begin()
        setup.robot.late = 3
        if corrections == "absolute":
            assert setup.read().text == "3 of 100 answers came late"
            assert setup.read().text == ""
        else:
            with pytest.raises(DriverFault, match="3 of 100 answers came late: relative corrections were lost"):
                setup.read()


def test_lost_messages_are_those_that_are_counted(running: Setup) -> None:
    running.robot.stamp += 40
    running.robot.late += 10
    assert running.read().mode is Mode.RUNNING
    running.robot.stamp += 40
    with pytest.raises(DriverFault, match="RSI was switched off and on again"):
        running.read()


def test_a_controller_without_answers_before_is_refused(
    make: Callable[..., Setup], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("virtualrobot_plugins.drivers.kuka_rsi.driver.BEGIN_SECONDS", 1.0)
    setup = make()
    setup.robot.late = 7
    with pytest.raises(DriverFault, match=r"RSI is on already, with 7 messages unanswered, .* connect, and then"):
        setup.connect()
    assert setup.robot.asked() == []


def test_what_was_corrected_gets_no_answer_until_it_has_broken_off(make: Callable[..., Setup]) -> None:
    setup = make()
    setup.connect()
    setup.begin()
    setup.read()
    setup.driver.send(np.full(6, 3.0), np.zeros(6), 0)
    setup.robot.asked()
    last = setup.robot.stamp
    setup.robot.joints = [1.0] * 6
    connected(setup.driver, setup.robot.cycle)
    first = setup.robot.asked()[0]
    assert 'A1="0.000000"' in first and int(re.findall("<IPOC>(.*)</IPOC>", first)[0]) > last + 400
    setup.begin()
    setup.read()
    setup.driver.send(np.full(6, 3.0), np.zeros(6), 0)
    (asked,) = setup.robot.asked()
    assert 'A1="2.000000"' in asked


def test_the_cycle_of_the_settings_is_compared(make: Callable[..., Setup]) -> None:
    setup = make()
    setup.robot.cycle_ms = 12
    with pytest.raises(DriverFault, match="messages are 12 ms apart; the setting cycle says 4"):
        setup.connect()
    assert make(cycle=12).settings.cycle == 12


def test_messages_without_what_is_needed_are_refused_in_words(running: Setup) -> None:
    for change, words in (
        ({"joints": HOME[:5]}, r"<Rob> has no AIPos\.A6; the sensor's configuration must send it"),
        ({"joints": ["x"] * 6}, r"AIPos\.A1 is 'x', and no number"),
        ({"more": "<!-- -->"}, "no plain element is at '<!-- -->"),
        ({"more": "<a><b/></a>"}, "no plain element is at '<a><b/>"),
        ({"more": "&lol;"}, "no plain element is at '&lol;"),
        ({"more": '<a b="&lol;"/>'}, "no plain element"),
        ({"more": "<x/>" * 5000}, "it has 20.* bytes, and may have 16384"),
        ({"late": 0.5}, "Delay is 0.5, and no whole number"),
    ):
        before = dict(vars(running.robot))
        vars(running.robot).update(change)
        with pytest.raises(DriverFault, match=f"nothing came .* the last packet was refused: .*{words}"):
            running.read()
        vars(running.robot).update({name: before[name] for name in change})
    running.robot.stamp = running.robot.stamp - 32  # as if what was refused had not been sent
    running.robot.joints[2] = math.nan
    running.read()
    assert math.isnan(running.read().positions[2])  # the host refuses it, with its value


def test_bombs_are_no_messages() -> None:
    bomb = '<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><Rob Type="KUKA"><AIPos A1="&b;"/></Rob>'
    with pytest.raises(MessageError, match="no <Rob>: it begins with '<!DOCTYPE"):
        read_robot(bomb.encode())
    with pytest.raises(MessageError, match="invalid start byte"):
        read_robot(b'<Rob Type="KUKA">\xff</Rob>')
    said = read_robot(b' <Rob Type="KUKA">\r\n <RIst X="1" Y = "2"/> <IPOC> 12 </IPOC>\n<Empty></Empty> </Rob>\n')
    assert said == {"RIst": {"X": "1", "Y": "2", "": ""}, "IPOC": {"": " 12 "}, "Empty": {"": ""}}


def test_broken_bytes_are_refused_in_words(rng: np.random.Generator, draws: Draws) -> None:
    robot = Robot(1)
    for _ in range(draws(2000)):
        data = bytearray(robot.packet())
        for _ in range(rng.integers(1, 4)):
            data[rng.integers(len(data))] = rng.integers(256)
        try:
            read_robot(bytes(data))
        except MessageError as error:
            assert str(error).startswith("no <Rob>: ")
    robot.close()


def test_a_controller_that_is_gone_is_a_fault(running: Setup) -> None:
    with pytest.raises(DriverFault, match=r"nothing came from the controller .* for 0\.1 s$"):
        running.driver.read()
    running.driver.close()
    with pytest.raises(DriverFault, match="there is no connection"):
        running.driver.read()


CONFIGURATION = """<ROOT><CONFIG><IP_NUMBER>{address}</IP_NUMBER><PORT>{port}</PORT><SENTYPE>ImFree</SENTYPE>
<ONLYSEND>FALSE</ONLYSEND></CONFIG>
<SEND><ELEMENTS><ELEMENT TAG="DEF_AIPos" TYPE="DOUBLE" INDX="INTERNAL" /><ELEMENT TAG="DEF_ASPos" TYPE="DOUBLE"
INDX="INTERNAL" /><ELEMENT TAG="DEF_Delay" TYPE="LONG" INDX="INTERNAL" /><ELEMENT TAG="DiO" TYPE="LONG" INDX="1" />
</ELEMENTS></SEND><RECEIVE><ELEMENTS>{axes}<ELEMENT TAG="DiO" TYPE="LONG" INDX="7" HOLDON="1" /></ELEMENTS></RECEIVE>
</ROOT>"""


@pytest.fixture
def emulator(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[int, str], Any]:
    """Return a function that makes the controller of RSIPI, which speaks to a port of this process.

    Its package loads pandas and matplotlib, which the emulator has no need of; it writes a log where it is imported,
    and always binds the same port.
    """
    package = ModuleType("RSIPI")
    (place,) = importlib.util.find_spec("RSIPI").submodule_search_locations  # pyright: ignore[reportOptionalMemberAccess, reportGeneralTypeIssues]
    package.__path__ = [str(place)]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("logging.basicConfig", lambda **_: None)
    for name in [name for name in sys.modules if name.partition(".")[0] == "RSIPI"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "RSIPI", package)
    server = importlib.import_module("RSIPI.rsi_echo_server")
    for name in [name for name in sys.modules if name.startswith("RSIPI.")]:
        monkeypatch.setitem(sys.modules, name, sys.modules[name])

    class Elsewhere(socket.socket):
        def bind(self, address: tuple[str, int]) -> None:
            super().bind((ADDRESS, 0))

    def make(port: int, mode: str) -> Any:  # noqa: ANN401 an EchoServer
        axes = "".join(
            f'<ELEMENT TAG="AKorr.A{axis}" TYPE="DOUBLE" INDX="{axis}" HOLDON="1" />' for axis in range(1, 7)
        )
        (tmp_path / "rsi.xml").write_text(CONFIGURATION.format(address=ADDRESS, port=port, axes=axes))
        with monkeypatch.context() as patch:
            patch.setattr("socket.socket", Elsewhere)
            controller = server.EchoServer("rsi.xml", delay_ms=4, mode=mode)
        controller.delay_ms = 60.0  # it waits so long for an answer, and goes on as soon as it has it
        return controller

    return make


@pytest.mark.parametrize("mode", ["absolute", "relative"])
def test_the_emulator_of_rsipi_goes_where_it_is_sent(
    emulator: Callable[[int, str], Any], mode: Literal["absolute", "relative"]
) -> None:
    settings = KukaRsiSettings(
        *(ADDRESS, ADDRESS, free_port()), corrections=mode, axis_tag="AKorr", outputs_tag="DiO", inputs_tag="DiO"
    )
    controller, driver = emulator(settings.port, mode), KukaRsi(settings)
    connected(driver, controller.send_once)
    controller.send_once()
    reading = driver.read()
    assert controller.receive_and_process() is True
    np.testing.assert_array_equal(reading.positions, np.zeros(6))
    controller.send_once()
    driver.begin(reading.positions)
    wanted = np.zeros(6)
    for cycle in range(250):
        assert controller.receive_and_process() is True
        controller.send_once()
        reading = driver.read()
        np.testing.assert_allclose(reading.positions, wanted, atol=0.006)  # it tells two digits
        assert cycle == 0 or reading.inputs == cycle - 1
        wanted = 5.0 * np.sin(0.02 * cycle * np.arange(1, 7))
        driver.send(wanted, np.zeros(6), cycle)
    assert controller.receive_and_process() is True
    assert controller.faulty_packets == 0
    driver.close()
    controller.udp_socket.close()
