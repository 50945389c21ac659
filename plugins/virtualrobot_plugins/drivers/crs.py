"""The driver `crs`: a CRS arm whose controller plans by itself, told point after point by RAPL-II over its serial port.

docs/drivers/crs.md says which commands it types, and where their form is known from.
"""

from __future__ import annotations

import math
import re
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.drivers import About, Driver, DriverFault, Mode, Pace, Reading
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.drivers.serial_port import SerialPort

PROMPT = b">>"
CYCLE_BYTES = 1500
"""Bytes of the answers to W2 and STATUS and of a move, with their echoes."""
FASTEST = 10.0
"""Readings a second that are enough."""
PATIENCE_CYCLES = 1.5
"""Cycles within which an answer must have come: a reading that asks twice ends within three."""
STILL = 3
"""Readings in which an arm must not have moved to be said to stand."""
STATUS_EVERY = 5
"""Readings after which the status is looked at again, of an arm that rests or is on its way."""
LOCATION = "#VROBOT"
"""Name of the location in the controller's memory that points are told by, where they are told in pulses."""
NUMBER = re.compile(r"[+-]?\d+\.\d+")
ERROR = re.compile(r"(\d{3})-([A-Z][^\r\n]*)")


@dataclass(frozen=True, slots=True)
class CrsSettings:
    """Settings of a CRS controller on a serial port."""

    port: Annotated[str, Meta(min_length=1, description="Serial port: /dev/ttyUSB0, COM3, or socket://host:4001.")]
    baud: Annotated[int, Meta(gt=0, le=115200, description="Bits a second, as the controller's port is set.")] = 9600
    pulses_per_degree: Annotated[
        tuple[float, ...],
        Meta(
            description="Pulses of each joint's encoder per degree, with sign; none: points are told in radians (MA)."
        ),
    ] = ()
    tolerance_degrees: Annotated[float, Meta(gt=0, le=10, description="Distance at which a point is reached.")] = 0.2
    silence_seconds: Annotated[
        float, Meta(ge=0, le=60, description="Longest time (s) to an answer; 0: 1.5 cycles.")
    ] = 0.0


@dataclass(frozen=True, slots=True)
class _Status:
    """Answer to STATUS, as far as it is needed."""

    name: str
    is_limp: bool
    is_homed: bool
    is_done: bool
    is_manual: bool
    error: str

    def hindrance(self) -> str:
        """Return what keeps the arm from following, and what a person has to do; empty when nothing does."""
        if self.is_manual:
            return "the teach pendant has the arm: end MANUAL there"
        if self.is_limp:
            return "joints are limp: switch ARM POWER on at the controller, and type NOLIMP"
        return "" if self.is_homed else "the arm is not homed: home it at the controller"


class Crs(Driver):
    """A CRS robot (A255, A465) on its C500 controller, by RAPL-II commands."""

    def __init__(self, settings: CrsSettings) -> None:
        """Take the settings; the port is opened by `connect`."""
        self.settings = settings
        self._port: SerialPort | None = None
        rate = min(FASTEST, settings.baud / 10.0 / CYCLE_BYTES)
        self._rate, self._patience = rate, settings.silence_seconds or PATIENCE_CYCLES / rate
        self._waiting: deque[tuple[Floats, float]] = deque()
        self._going: Floats | None = None
        self._was = np.empty(0)
        self._follows = False
        self._done = self._read = self._still = self._speed = 0
        self._last: _Status | None = None

    def connect(self) -> About:
        """Open the port, and ask for the status and where the arm is."""
        self.close()
        self._waiting.clear()
        self._going, self._follows, self._was = None, False, np.empty(0)
        self._port = SerialPort(self.settings.port, self.settings.baud)
        # An empty line ends what was typed before.
        self._port.write(b"\r")
        status = self._last = self._status()
        self._was = self._where()
        pulses = self.settings.pulses_per_degree
        if len(pulses) not in (0, len(self._was)):
            raise DriverFault(
                f"pulses_per_degree has {len(pulses)} numbers; the controller tells {len(self._was)} joints"
            )
        version, _, model = status.name.partition("  ")
        return About(
            joints=len(self._was),
            rate=self._rate,
            pace=Pace.JOBS,
            units=math.radians(1.0),
            model=model.strip(),
            version=version,
        )

    def read(self) -> Reading:
        """Ask where the arm is; when it has reached a point, have it go to the next."""
        positions = self._where()
        self._still = self._still + 1 if np.all(positions == self._was) else 0
        self._was, going = positions, self._going
        near = going is not None and np.abs(positions - going).max() <= self.settings.tolerance_degrees
        stands = going is not None and self._still >= STILL
        self._read += 1
        status = self._last
        if status is None or near or stands or self._read % STATUS_EVERY == 0:
            status = self._last = self._status()
            if near and status.is_done:
                self._done, self._going = self._done + 1, None
            elif going is not None and stands and status.is_done:
                raise DriverFault(
                    f"the arm stands at {_numbers(positions)} and not at point {self._done + 1}, {_numbers(going)} "
                    f"degrees; the controller's last error is {status.error or 'none'}",
                    status.error[:3],
                )
        if self._going is None and self._waiting:
            self._go(*self._waiting.popleft())
            self._still = 0
        on = Mode.LOCAL if status.is_manual else Mode.RUNNING if self._follows else Mode.READY
        mode = Mode.OFF if status.is_limp else on
        return Reading(time.monotonic(), positions, mode=mode, text=status.hindrance(), done=self._done)

    def begin(self, held: Floats) -> None:
        """See that the arm has power and is homed."""
        self._last = self._status()
        if hindrance := self._last.hindrance():
            raise DriverFault(hindrance)
        self._waiting.clear()
        self._going, self._done, self._speed, self._follows = None, 0, 0, True

    def run(self, points: Sequence[Floats], speeds: Sequence[float], outputs: int) -> None:
        """Keep the points; the controller is told the next one as a reading says that it has reached one."""
        if self._follows:
            self._waiting.extend(zip(points, speeds, strict=True))

    def stop(self) -> None:
        """Type HALT, and forget the points."""
        self._waiting.clear()
        self._going, self._follows = None, False
        if self._port is not None:
            self._port.write(b"HALT\r")

    def end(self) -> None:
        """Tell no more points."""
        self._follows = False

    def close(self) -> None:
        """Close the port."""
        if self._port is not None:
            self._port.close()
        self._port = None

    def _go(self, point: Floats, speed: float) -> None:
        percent = min(100, max(1, round(100.0 * speed)))
        if percent != self._speed:
            self._order(f"SPEED {percent}")
            self._speed = percent
        if self.settings.pulses_per_degree:
            pulses = np.asarray(point) * self.settings.pulses_per_degree
            self._order(f"POINT {LOCATION} {', '.join(str(round(pulse)) for pulse in pulses)}")
            self._order(f"MOVE {LOCATION}")
        else:
            self._order(f"MA {','.join(f'{math.radians(value):.5f}' for value in point)}")
        self._going = np.array(point)

    def _order(self, command: str) -> None:
        """Type a command; raise the error that the controller answers by."""
        if found := ERROR.search(self._ask(command)):
            raise DriverFault(f"{found[2].strip()} (to {command})", found[1])

    def _ask(self, command: str) -> str:
        """Return what the controller says to a command, up to its prompt; answers to former ones are passed over."""
        if self._port is None:
            raise DriverFault(f"{self.settings.port} isn't connected")
        self._port.write(f"{command}\r".encode("ascii"))
        deadline = time.monotonic() + self._patience
        while (data := self._port.until(PROMPT, max(0.0, deadline - time.monotonic()))) is not None:
            echo, _, said = data.decode("ascii", "replace").strip().partition("\r")
            if echo == command:
                return said
        raise DriverFault(
            f"the controller on {self.settings.port} was silent for {self._patience:.3g} s after {command}"
        )

    def _where(self) -> Floats:
        """Return the actual position (degrees) of each joint."""
        said = self._ask("W2")
        values = NUMBER.findall(said.partition("JOINTS")[2].partition("WORLD")[0])
        if not values or len(self._was) not in (0, len(values)):
            raise DriverFault(f"the controller answers W2 by {said!r}, which tells {len(values)} joints")
        return np.array([float(value) for value in values])

    def _status(self) -> _Status:
        said = self._ask("STATUS")
        rows = {row.split()[0]: row.split()[1:] for row in said.splitlines() if row.strip()}
        try:
            limp, homed, done = rows["LIMP"], rows["HOMED"], rows["DONE"]
        except KeyError as error:
            raise DriverFault(f"the controller answers STATUS by {said!r}: there is no row {error}") from error
        last = re.search(r"LAST ERROR CODE: *(\d{3}-[^\r\n]*)", said)
        return _Status(
            name=said.strip().splitlines()[0],
            is_limp="Y" in limp,
            is_homed="N" not in homed,
            is_done="N" not in done,
            is_manual="MANUAL MODE STATUS IS ON" in said,
            error="" if last is None else last[1].strip(),
        )


def _numbers(values: Floats) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
