"""The driver `serial_line` against boards whose answers a test says: damaged ones, wrong ones, none."""

from __future__ import annotations

import math
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import pytest
from virtualrobot_plugins.drivers.serial_line import SerialLine, SerialLineSettings
from virtualrobot_sdk.drivers import DriverFault, Mode, Safety
from virtualrobot_sdk.drivers.driver import finite

from tests.drivers.cables import Cable, by_line
from tests.tiers import Draws

PATIENT = 20.0
"""Silence (s) that tests bear where silence is not what they are about."""
GREETING = "JOINTS 2 RATE 20 UNIT DEG PACE HOST"
HOME = np.zeros(6)


def crc16(text: str) -> str:
    """Return CRC-16 by x^16 + x^12 + x^5 + 1 from 0, by division of the message's polynomial."""
    bits = int.from_bytes(text.encode() + b"\x00\x00", "big")
    while bits.bit_length() > 16:
        bits ^= 0x11021 << (bits.bit_length() - 17)
    return f"{bits:04X}"


Scripts = Callable[..., SerialLine]


@pytest.fixture
def scripted(cable: Cable) -> Iterator[Scripts]:
    """Yield a function that returns a driver of a board which says what a function of the test says."""
    drivers: list[SerialLine] = []

    def start(answer: Callable[[str], str | bytes | None], silence: float = PATIENT) -> SerialLine:
        cable.serve(by_line(answer))
        drivers.append(SerialLine(SerialLineSettings(str(cable.path), silence_seconds=silence)))
        return drivers[-1]

    yield start
    for driver in drivers:
        driver.close()


def usual(line: str, **others: str | bytes | None) -> str | bytes | None:
    """Return what a board of two joints says to a line, or another answer to lines with the word of a name."""
    word = line.partition(" ")[0]
    usually = {"HELLO": GREETING, "READ": f"AT {time.monotonic_ns() // 1_000_000 % 2**30} READY 0 0 10.5 -20"}
    return others.get(word, usually.get(word, f"OK {word}"))


@pytest.mark.parametrize(
    "noise",
    [b"\x00\xff\xfe\n", b"AT 12 READY 0 0 10*0000\r\n", b"OK\r\n", b"AT 5*7777\r\n"],
)
def test_damaged_answers_are_asked_again(scripted: Scripts, noise: bytes) -> None:
    said = iter([noise, noise])
    driver = scripted(lambda line: next(said, None) or usual(line) if line == "READ" else usual(line))
    driver.connect()
    assert driver.read().positions == pytest.approx([10.5, -20.0])
    driver.begin(np.zeros(2))


def test_noise_makes_no_position_wrong(scripted: Scripts, rng: np.random.Generator, draws: Draws) -> None:
    """At times up to three bits of a board's line flip, which is always found, and the board finds a line damaged."""

    def damaged(data: bytes) -> bytes:
        bits = np.unpackbits(np.frombuffer(data, np.uint8))
        # Line ends stay: a line in two may have the check of the whole one time in 65,536.
        places = rng.choice(len(bits) - 8, rng.integers(1, 4), replace=False)
        bits[places] ^= 1
        return np.packbits(bits).tobytes()

    truth = np.zeros(2)
    count = 0

    def answer(line: str) -> bytes:
        nonlocal count
        count += 1
        said = GREETING + " CHECK 1"
        if line != "HELLO":
            body, _, check = line.rpartition("*")
            word = body.partition(" ")[0]
            said = f"AT {count} RUNNING 0 0 {truth[0]} {truth[1]}" if word == "READ" else f"OK {word}"
            said = said if check == crc16(body) and rng.random() < 0.9 else "ERR 1 not understood"
            said = f"{said}*{crc16(said)}"
        whole = f"{said}\n".encode()
        return damaged(whole) if line != "HELLO" and rng.random() < 0.2 else whole

    driver = scripted(answer)
    driver.connect()
    faults = 0
    for _ in range(draws(500)):
        truth[:] = rng.uniform(-180.0, 180.0, 2).round(3)
        try:
            assert driver.read().positions == pytest.approx(truth, abs=1e-9)
        except DriverFault as fault:
            faults += 1
            assert "damaged lines" in fault.text
    # Four times damaged, one after the other: one reading in 180.
    assert faults < 0.2 * draws(500)


def test_whatever_a_board_says_is_a_reading_or_a_fault(
    scripted: Scripts, rng: np.random.Generator, draws: Draws
) -> None:
    words = [
        "AT",
        "OK",
        "ERR",
        "1",
        "5",
        "-7",
        "1e999",
        "nan",
        "9" * 400,
        "READY",
        "RUNNING",
        "FAULT",
        "*",
        "\x00",
        "٣",
    ]

    def answer(line: str) -> bytes:
        if line == "HELLO":
            return f"{GREETING}\n".encode()
        usual = ["AT", "5", "READY", "0", "0", "1", "2"]
        for _ in range(rng.integers(0, 4)):
            usual[rng.integers(len(usual))] = words[rng.integers(len(words))]
        said = " ".join(usual[: rng.integers(1, 9)]).encode() + b"\n"
        return said if rng.random() < 0.8 else rng.bytes(int(rng.integers(1, 200)))

    driver = scripted(answer, silence=0.02)
    driver.connect()
    for _ in range(draws(200)):
        try:
            reading = driver.read()
        except DriverFault as fault:
            assert str(fault)
        else:
            assert reading.done >= 0
            assert reading.inputs == 0


def test_a_line_that_stays_damaged_is_told(scripted: Scripts) -> None:
    driver = scripted(partial(usual, READ=b"\x80\x00\x80\n"))
    driver.connect()
    with pytest.raises(DriverFault, match=r"ttyROBOT brings damaged lines, the last instead of AT: '.\\x00.'"):
        driver.read()


def test_a_flood_without_lines_is_told(scripted: Scripts) -> None:
    driver = scripted(partial(usual, READ=b"U" * 5000))
    driver.connect()
    with pytest.raises(DriverFault, match=r"ttyROBOT sends \d+ bytes without b'\\n': is 115200 its baud rate"):
        driver.read()


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ("ERR 12 motor 3 is hot", r"^12: motor 3 is hot$"),
        ("ERR", r"^the board has an error$"),
        ("AT 5 READY 0 0 1", r"^the board says 1 positions; it was greeted as one of 2$"),
        ("AT 5 READY 0 0 1 x", r"'5 READY 0 0 1 x' after AT, which is no reading: could not convert .* 'x'"),
        ("AT 5 READY 0 1 1 2", r"^the board says 0 points done and inputs 1; it has 0 inputs$"),
        ("AT 5 READY -1 0 1 2", r"^the board says -1 points done"),
        ("AT 5 DANCING 0 0 1 2", r"'5 DANCING 0 0 1 2' after AT, which is no reading: 'DANCING'"),
        ("AT 5 REA", r"'5 REA' after AT, which is no reading"),
        ("AT", r"'' after AT, which is no reading"),
    ],
)
def test_wrong_readings_are_told(scripted: Scripts, answer: str, said: str) -> None:
    driver = scripted(partial(usual, READ=answer))
    driver.connect()
    with pytest.raises(DriverFault, match=said):
        driver.read()


def test_no_number_is_found_by_the_host(scripted: Scripts) -> None:
    driver = scripted(partial(usual, READ="AT 5 READY 0 0 nan 2"))
    joints = driver.connect().joints
    assert "must be finite" in finite(driver.read(), joints)


def test_stops_of_its_safety_are_told(scripted: Scripts) -> None:
    driver = scripted(partial(usual, HELLO=f"{GREETING} INPUTS 2", READ="AT 5 EMERGENCY_STOP 0 3 1 2"))
    driver.connect()
    reading = driver.read()
    assert (reading.safety, reading.inputs) == (Safety.EMERGENCY_STOP, 3)


@pytest.mark.parametrize(
    ("greeting", "said"),
    [
        ("JOINTS two RATE 20 UNIT DEG", r"'two' is missing or wrong"),
        ("JOINTS 2 UNIT DEG", r"'RATE' is missing or wrong"),
        ("JOINTS 2 RATE 20 UNIT GRAD", r"'GRAD' is missing or wrong"),
        ("JOINTS 2 RATE 20 UNIT DEG PACE CONTROLLER", r"'CONTROLLER' is missing or wrong"),
        ("JOINTS 0 RATE 20 UNIT DEG", r"JOINTS must be 1 at least"),
        ("JOINTS 2 RATE nan UNIT DEG", r"RATE must be above 0 and at most 1000"),
        ("JOINTS 2 RATE 20 UNIT DEG,MM,MM", r"UNIT must be one for all joints or one each"),
        ("JOINTS 2 RATE 20 UNIT DEG QUEUE 0", r"QUEUE must be 1 at least"),
        ("JOINTS 2 RATE 20 UNIT DEG WATCHDOG nan", r"WATCHDOG must be seconds, 0 to 3600"),
        ("JOINTS 2 RATE 20 UNIT DEG INPUTS 65", r"INPUTS must be 0 to 64"),
    ],
)
def test_wrong_greetings_are_told(scripted: Scripts, greeting: str, said: str) -> None:
    with pytest.raises(DriverFault, match=said) as fault:
        scripted(partial(usual, HELLO=greeting)).connect()
    assert greeting in fault.value.text


def test_a_board_that_boots_is_waited_for(scripted: Scripts) -> None:
    said = iter([b"\x00garbage of a boot loa", b"MicroPython v1\r\n", None])
    driver = scripted(lambda line: next(said, None) or GREETING if line == "HELLO" else usual(line))
    assert driver.connect().joints == 2


def test_silence_is_told(scripted: Scripts) -> None:
    driver = scripted(partial(usual, READ=None), silence=0.05)
    driver.connect()
    with pytest.raises(DriverFault, match=r"the board on .*ttyROBOT gives no answer to READ within 0\.05 s"):
        driver.read()


def test_a_board_that_never_ends_speaking_is_told(scripted: Scripts, cable: Cable) -> None:
    driver = scripted(partial(usual, READ=None), silence=0.05)
    driver.connect()
    with subprocess.Popen(["yes", "OK GO"], stdout=cable.end) as babble:
        with pytest.raises(DriverFault, match=r"gives no answer to READ within 0\.05 s"):
            driver.read()
        babble.kill()


def test_unplugged_is_told_and_replugged_connects_again(scripted: Scripts, cable: Cable) -> None:
    driver = scripted(partial(usual, HELLO=f"{GREETING} PACE JOBS"))
    driver.connect()
    driver.begin(np.zeros(2))
    driver.run([np.zeros(2), np.ones(2)], [1.0, 1.0], 0)
    driver.read()
    cable.unplug()
    with pytest.raises(DriverFault, match=r"ttyROBOT is gone"):
        driver.read()
    with pytest.raises(DriverFault, match=r"ttyROBOT can't be opened: No such file or directory; this machine has "):
        driver.connect()
    with pytest.raises(DriverFault, match=r"isn't connected"):
        driver.read()
    cable.plug()
    heard: list[str] = []
    cable.serve(by_line(lambda line: heard.append(line) or usual(line)))
    assert driver.connect().joints == 2
    # What was not told before is forgotten.
    assert [driver.read().mode for _ in range(3)] == [Mode.READY] * 3
    assert set(heard) == {"HELLO", "READ"}


def test_settings_of_each_joint(scripted: Scripts) -> None:
    about = scripted(partial(usual, HELLO="JOINTS 2 RATE 20 UNIT DEG,MM")).connect()
    assert about.units == (math.radians(1.0), 0.001)


def test_a_board_in_the_network() -> None:
    answer = by_line(usual)
    with socket.create_server(("127.0.0.1", 0)) as server:
        driver = SerialLine(
            SerialLineSettings(f"socket://127.0.0.1:{server.getsockname()[1]}", silence_seconds=PATIENT)
        )

        def serve() -> None:
            near, _ = server.accept()
            with near:
                while data := near.recv(4096):
                    near.sendall(answer(data))
                    if b"STOP" in data:
                        return

        board = threading.Thread(target=serve)
        board.start()
        assert driver.connect().joints == 2
        assert driver.read().positions == pytest.approx([10.5, -20.0])
        driver.begin(np.zeros(2))
        driver.send(np.zeros(2), np.zeros(2), 0)
        assert driver.read().mode is Mode.READY
        with pytest.raises(DriverFault, match=r"socket://127\.0\.0\.1:\d+ is gone"):
            driver.stop()
            driver.read()
        board.join()
        driver.close()
    with pytest.raises(DriverFault, match=r"socket://127\.0\.0\.1:\d+ can't be opened: .*refused"):
        driver.connect()
