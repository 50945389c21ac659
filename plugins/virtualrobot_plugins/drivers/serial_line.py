"""The driver `serial_line`: lines of text over a serial port to the microcontroller of a small robot.

docs/drivers/serial_line.md has every line, and the microcontroller's side as an example.
"""

from __future__ import annotations

import math
import time
from binascii import crc_hqx
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.drivers import About, Driver, DriverFault, Mode, Pace, Reading, Safety
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.drivers.serial_port import SerialPort

UNITS = {"DEG": math.radians(1.0), "RAD": 1.0, "MM": 0.001, "M": 1.0}
"""rad or m per unit of a board."""
GREETING_SECONDS = 8.0
"""Time (s) that a board has to boot: many begin anew when their port is opened."""
SWITCHING_SECONDS = 5.0
"""Time (s) that a board has to switch its motors on, and to clear a fault."""
NOT_UNDERSTOOD = "1"
"""Code of a board for a line that came damaged; it is asked again."""
DAMAGED = 3
"""Number of damaged lines after which a question is not asked again."""
CLOCK = 2**30
"""Milliseconds after which MicroPython's clock starts at 0 again; it divides those of C's `millis`."""


@dataclass(frozen=True, slots=True)
class SerialLineSettings:
    """Settings of a board on a serial port."""

    port: Annotated[
        str, Meta(min_length=1, description="Serial port: /dev/ttyUSB0, /dev/cu.usbmodem1, COM3, socket://host:4001.")
    ]
    baud: Annotated[int, Meta(gt=0, le=12_000_000, description="Bits a second; boards with USB take any.")] = 115200
    silence_seconds: Annotated[
        float, Meta(ge=0, le=10, description="Longest time (s) to an answer; 0: three cycles of the board.")
    ] = 0.0


class SerialLine(Driver):
    """A robot whose microcontroller speaks lines of text over a serial port."""

    def __init__(self, settings: SerialLineSettings) -> None:
        """Take the settings; the port is opened by `connect`."""
        self.settings = settings
        self._port: SerialPort | None = None
        self._checks = self._follows = False
        self._patience = SWITCHING_SECONDS
        self._queue = 1
        self._waiting: deque[str] = deque()
        self._sent = self._outputs = 0
        self._clock: int | None = None
        self._stamp = 0.0

    def connect(self) -> About:
        """Open the port, and greet the board until it answers."""
        self.close()
        self._waiting.clear()
        self._port = SerialPort(self.settings.port, self.settings.baud)
        self._checks, self._follows, self._clock, self._outputs = False, False, None, 0
        about, self._checks, self._queue = _about(self._greeting())
        self._patience = self.settings.silence_seconds or 3.0 / about.rate
        self._joints, self._inputs = about.joints, about.inputs
        return about

    def read(self) -> Reading:
        """Ask for the state; of JOBS, tell the points that the board has room for."""
        words = self._ask("READ", "AT", self._patience)
        try:
            clock, said, done, inputs = int(words[0]), words[1], int(words[2]), int(words[3])
            positions = np.array([float(word) for word in words[4:]])
            mode = Mode[said] if said in Mode.__members__ else Mode.READY
            safety = Safety.NORMAL if said in Mode.__members__ else Safety[said]
        except (ValueError, IndexError, KeyError) as error:
            raise DriverFault(f"the board says {' '.join(words)!r} after AT, which is no reading: {error}") from error
        if done < 0 or not 0 <= inputs < 1 << self._inputs:
            raise DriverFault(f"the board says {done} points done and inputs {inputs}; it has {self._inputs} inputs")
        if len(positions) != self._joints:
            raise DriverFault(f"the board says {len(positions)} positions; it was greeted as one of {self._joints}")
        self._stamp += 0.0 if self._clock is None else (clock - self._clock) % CLOCK / 1000.0
        self._clock = clock
        while self._waiting and self._sent - done < self._queue:
            self._ask(f"MOVE {self._sent + 1} {self._waiting[0]}", "OK MOVE", self._patience)
            self._waiting.popleft()
            self._sent += 1
        return Reading(self._stamp, positions, mode=mode, safety=safety, inputs=inputs, done=done)

    def begin(self, held: Floats) -> None:
        """Have the board switch its motors on."""
        self._waiting.clear()
        self._sent = self._outputs = 0
        self._ask("ON", "OK ON", SWITCHING_SECONDS)
        self._follows = True

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Send the setpoint; what the board says to it is heard with the next reading."""
        if self._follows:
            self._tell(f"GO {_numbers(positions)}")
            self._set(outputs)

    def run(self, points: Sequence[Floats], speeds: Sequence[float], outputs: int) -> None:
        """Keep the points, which the board is told one by one as readings say that it has room."""
        if self._follows:
            parts = zip(points, speeds, strict=True)
            self._waiting.extend(f"{max(1, round(100.0 * speed))} {_numbers(point)}" for point, speed in parts)
            self._set(outputs)

    def stop(self) -> None:
        """Have the board stop, and forget the points that it has not been told. It is said twice: one may be lost."""
        self._waiting.clear()
        self._follows = False
        if self._port is not None:
            self._tell("STOP")
            self._ask("STOP", "OK STOP", self._patience)

    def end(self) -> None:
        """Have the board hold, and follow nothing more."""
        self.stop()

    def reset(self) -> None:
        """Have the board clear its fault."""
        self._ask("RESET", "OK RESET", SWITCHING_SECONDS)

    def close(self) -> None:
        """Close the port."""
        if self._port is not None:
            self._port.close()
        self._port = None

    def _set(self, outputs: int) -> None:
        if outputs != self._outputs:
            self._ask(f"OUT {outputs}", "OK OUT", self._patience)
            self._outputs = outputs

    def _open(self) -> SerialPort:
        if self._port is None:
            raise DriverFault(f"{self.settings.port} isn't connected")
        return self._port

    def _tell(self, line: str) -> None:
        self._open().write((f"{line}*{_check(line)}\n" if self._checks else f"{line}\n").encode("ascii"))

    def _hear(self, seconds: float) -> str | None:
        """Return the next line; empty if it is damaged, None when there is none."""
        data = self._open().until(b"\n", seconds)
        return None if data is None else self._read_line(data)

    def _read_line(self, data: bytes) -> str:
        line = data.decode("ascii", "replace").strip()
        body, star, check = line.rpartition("*")
        if not star:
            return "" if self._checks else line
        return body if check.upper() == _check(body) else ""

    def _greeting(self) -> str:
        deadline = time.monotonic() + GREETING_SECONDS
        said = ""
        while time.monotonic() < deadline:
            # The empty line ends what the board may have got half.
            self._open().write(b"\nHELLO\n")
            while (line := self._hear(0.5)) is not None and time.monotonic() < deadline:
                if line.startswith("JOINTS "):
                    return line
                said = line or said
        heard = f"the last that it said is {said!r}" if said else "it says nothing"
        raise DriverFault(
            f"no board answers to HELLO on {self.settings.port} at {self.settings.baud} baud within "
            f"{GREETING_SECONDS:g} s; {heard}"
        )

    def _ask(self, question: str, answer: str, seconds: float) -> list[str]:
        """Return the words after `answer` in the board's answer; answers to former lines are passed over.

        Raises DriverFault with the words of an ERR, when the board is silent, and when its lines come damaged.
        """
        for data in self._open().whole(b"\n"):
            _raise_fault(self._read_line(data))
        self._tell(question)
        deadline = time.monotonic() + seconds
        damaged = 0
        while (left := deadline - time.monotonic()) > 0.0 and (line := self._hear(left)) is not None:
            _raise_fault(line)
            if f"{line} ".startswith(f"{answer} "):
                return line[len(answer) :].split()
            if not line or not line.startswith(("OK ", "AT ")):
                damaged += 1
                if damaged > DAMAGED:
                    raise DriverFault(
                        f"{self.settings.port} brings damaged lines, the last instead of {answer}: {line!r}"
                    )
                self._tell(question)
        raise DriverFault(f"the board on {self.settings.port} gives no answer to {question} within {seconds:g} s")


def _about(greeting: str) -> tuple[About, bool, int]:
    """Return what a greeting says: the controller, whether lines have checks, and how many points it takes ahead."""
    words = greeting.split()
    said = dict(zip(words[0::2], words[1::2], strict=False))
    try:
        units = tuple(UNITS[unit] for unit in said["UNIT"].split(","))
        about = About(
            joints=int(said["JOINTS"]),
            rate=float(said["RATE"]),
            pace={"HOST": Pace.HOST, "JOBS": Pace.JOBS}[said.get("PACE", "HOST")],
            units=units[0] if len(units) == 1 else units,
            watchdog=float(said.get("WATCHDOG", 0.0)),
            model=said.get("MODEL", ""),
            version=said.get("VERSION", ""),
            serial=said.get("SERIAL", ""),
            inputs=int(said.get("INPUTS", 0)),
            outputs=int(said.get("OUTPUTS", 0)),
        )
        checks, queue = said.get("CHECK") == "1", int(said.get("QUEUE", 1))
    except (KeyError, ValueError) as error:
        raise DriverFault(f"the board greets by {greeting!r}: {error} is missing or wrong") from error
    for name, right, wanted in (
        ("JOINTS", about.joints >= 1, "1 at least"),
        ("RATE", 0.0 < about.rate <= 1000.0, "above 0 and at most 1000"),
        ("UNIT", len(units) in (1, about.joints), "one for all joints or one each"),
        ("QUEUE", queue >= 1, "1 at least"),
        ("WATCHDOG", 0.0 <= about.watchdog <= 3600.0, "seconds, 0 to 3600"),
        ("INPUTS", 0 <= about.inputs <= 64, "0 to 64"),
        ("OUTPUTS", 0 <= about.outputs <= 64, "0 to 64"),
    ):
        if not right:
            raise DriverFault(f"the board greets by {greeting!r}: {name} must be {wanted}")
    return about, checks, queue


def _raise_fault(line: str) -> None:
    words = line.split()
    if words[:1] == ["ERR"] and words[1:2] != [NOT_UNDERSTOOD]:
        raise DriverFault(" ".join(words[2:]) or "the board has an error", "".join(words[1:2]), clears=True)


def _check(line: str) -> str:
    """Return the check of a line: CRC-16 by x^16 + x^12 + x^5 + 1 from 0 (XMODEM), as four hexadecimal digits."""
    return f"{crc_hqx(line.encode('ascii', 'replace'), 0):04X}"


def _numbers(values: Floats) -> str:
    return " ".join(f"{value:.5f}" for value in values)
