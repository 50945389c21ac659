"""The driver `dynamixel`; docs/drivers/dynamixel.md says what it writes to the servos, and when.

Addresses are those of the control table of the X series (ROBOTIS e-Manual, XL430-W250 and XM430-W350, Control Table).
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Annotated

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.drivers import About, Driver, DriverFault, Mode, Reading, Safety
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats

if TYPE_CHECKING:
    from virtualrobot_plugins.drivers.dynamixel.bus import Bus

FIRMWARE, RETURN_DELAY, OPERATING_MODE, LIMITS = (6, 1), (9, 1), (11, 1), (48, 8)
TORQUE, HARDWARE_ERROR, WATCHDOG = (64, 1), (70, 1), (98, 1)
PROFILE_ACCELERATION, PROFILE_VELOCITY, GOAL, STATE = (108, 4), (112, 4), (116, 4), (120, 16)
"""Address and length of what is read and written; STATE is from Realtime Tick to Present Position."""
POSITION_MODES = {3: "position", 4: "extended position", 5: "position by current"}
ERRORS = {0: "input voltage", 2: "overheating", 3: "motor encoder", 4: "electrical shock", 5: "overload"}
"""Bits of Hardware Error Status."""
MIDDLE, TURN = 2048, 4096
"""Position (pulses) in the middle, and of a whole turn."""
VELOCITY = 0.229 / 60.0 * TURN
"""Pulses a second per unit of Present Velocity, which is 0.229 turns a minute."""
CLOCK = 2**15
"""Milliseconds after which Realtime Tick starts at 0 again."""
REBOOT_SECONDS = 5.0
"""Time (s) within which a servo that begins anew answers."""


@dataclass(frozen=True, slots=True)
class DynamixelSettings:
    """Settings of a bus of servos; the first of `ids` is the robot's first joint."""

    port: Annotated[str, Meta(min_length=1, description="Serial port of the bus: /dev/ttyUSB0, COM3.")]
    ids: Annotated[tuple[int, ...], Meta(min_length=1, description="Id of each joint's servo, in order of the joints.")]
    baud: Annotated[int, Meta(gt=0, le=4_500_000, description="Bits a second that the servos are set to.")] = 57600
    rate: Annotated[float, Meta(gt=0, le=1000, description="Cycles a second of readings and setpoints.")] = 20.0
    watchdog_seconds: Annotated[
        float, Meta(ge=0.02, le=2.5, description="Silence (s) after which the servos stop by themselves.")
    ] = 0.2
    keeps_torque: Annotated[
        bool, Meta(description="Whether the servos hold when the robot no longer follows; else an arm may sink.")
    ] = True
    silence_seconds: Annotated[float, Meta(gt=0, le=10, description="Longest time (s) to a servo's answer.")] = 0.034

    def __post_init__(self) -> None:
        """Raise ArgumentError for ids that no servo can have, or two."""
        if len(set(self.ids)) < len(self.ids) or not all(0 <= servo <= 252 for servo in self.ids):
            raise ArgumentError(f"ids are {list(self.ids)}; each must be from 0 to 252, and be there once", field="ids")


class Dynamixel(Driver):
    """Dynamixel servos of the X series on one serial port."""

    def __init__(self, settings: DynamixelSettings) -> None:
        """Take the settings; the port is opened by `connect`."""
        self.settings = settings
        self._bus: Bus | None = None
        self._follows = False
        self._raw = np.zeros(len(settings.ids))
        self._lower, self._upper = np.full((2, len(settings.ids)), math.nan)
        self._clock: int | None = None
        self._stamp = self._heard = 0.0

    def connect(self) -> About:
        """Ask each servo who it is, and refuse those that are not set to positions."""
        if find_spec("dynamixel_sdk") is None:
            raise DriverFault("Dynamixel servos need dynamixel-sdk: pip install 'virtualrobot[dynamixel]'")
        from virtualrobot_plugins.drivers.dynamixel.bus import Bus

        self.close()
        settings = self.settings
        self._bus = bus = Bus(settings.port, settings.baud, settings.ids, settings.silence_seconds)
        self._follows, self._clock = False, None
        models = {servo: bus.ping(servo) for servo in settings.ids}
        if absent := [str(servo) for servo, model in models.items() if model is None]:
            there = ", ".join(str(servo) for servo, model in models.items() if model is not None) or "none"
            raise DriverFault(
                f"servo {', '.join(absent)} doesn't answer on {bus.path} at {bus.baud} baud; of {list(bus.ids)} "
                f"answers {there}"
            )
        modes = self._numbers(OPERATING_MODE)
        for servo, mode in zip(bus.ids, modes, strict=True):
            if mode not in POSITION_MODES:
                right = ", ".join(f"{number} ({name})" for number, name in POSITION_MODES.items())
                raise DriverFault(f"servo {servo} is in operating mode {mode}; it must be one of {right}")
        limits = np.array([(_number(data[4:]), _number(data[:4])) for data in bus.read(*LIMITS)], dtype=np.float64)
        # Limits hold in the mode of one turn; in the others a servo turns 256 times each way.
        several = np.array(modes) != 3
        self._lower = np.where(several, -256.0 * TURN, limits[:, 0])
        self._upper = np.where(several, 256.0 * TURN, limits[:, 1])
        self._check_rate()
        return About(
            joints=len(bus.ids),
            rate=settings.rate,
            units=2.0 * math.pi / TURN,
            watchdog=_steps(settings.watchdog_seconds) * 0.02,
            model="Dynamixel " + ", ".join(str(model) for model in models.values()),
            version=", ".join(str(version) for version in self._numbers(FIRMWARE)),
        )

    def read(self) -> Reading:
        """Read clock, velocity and position of all servos at once, and the words of a hardware error."""
        late = time.monotonic() - self._heard
        data = self._open().read(*STATE)
        self._heard = time.monotonic()
        if self._follows and late > _steps(self.settings.watchdog_seconds) * 0.02:
            self._follows = False
            raise DriverFault(f"the servos were told nothing for {late:.2g} s: their watchdog has stopped them")
        clock = int.from_bytes(data[0][0:2], "little")
        self._stamp += 0.0 if self._clock is None else (clock - self._clock) % CLOCK / 1000.0
        self._clock = clock
        self._raw = np.array([_number(one[12:16]) for one in data], dtype=np.float64)
        text = self._errors() if self._open().alerts else ""
        return Reading(
            self._stamp,
            self._raw - MIDDLE,
            velocities=np.array([_number(one[8:12]) for one in data]) * VELOCITY,
            mode=Mode.RUNNING if self._follows else Mode.READY,
            safety=Safety.FAULT if text else Safety.NORMAL,
            text=text,
        )

    def begin(self, held: Floats) -> None:
        """Have the servos hold where they are, with torque, and stop by themselves when nothing is said."""
        if text := self._errors():
            raise DriverFault(text, clears=True)
        self._write(WATCHDOG, 0)
        self.read()
        self._write(PROFILE_ACCELERATION, 0)
        self._write(PROFILE_VELOCITY, 0)
        self._goal(self._raw)
        self._write(TORQUE, 1)
        self._write(WATCHDOG, _steps(self.settings.watchdog_seconds))
        off = [str(servo) for servo, on in zip(self.settings.ids, self._numbers(TORQUE), strict=True) if on != 1]
        if off:
            raise DriverFault(f"servo {', '.join(off)} doesn't switch its torque on", clears=True)
        self._follows, self._heard = True, time.monotonic()

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Write the goals of all servos at once."""
        if not self._follows:
            return
        goals = np.asarray(positions) + MIDDLE
        for servo, goal, low, high in zip(self.settings.ids, goals, self._lower, self._upper, strict=True):
            if not low <= round(goal) <= high:
                raise DriverFault(f"servo {servo} to {goal:.0f} pulses: it goes from {low:.0f} to {high:.0f}")
        self._goal(goals)

    def stop(self) -> None:
        """Have the servos hold where they were at the last reading."""
        was, self._follows = self._follows, False
        if was:
            self._goal(self._raw)

    def end(self) -> None:
        """Leave the servos to themselves, with torque where the settings say so."""
        self._follows = False
        self._write(WATCHDOG, 0)
        if not self.settings.keeps_torque:
            self._write(TORQUE, 0)

    def reset(self) -> None:
        """Begin the servos with an error anew; they have no torque then."""
        bus = self._open()
        broken = [servo for servo, error in zip(bus.ids, self._numbers(HARDWARE_ERROR), strict=True) if error]
        for servo in broken:
            bus.reboot(servo)
        deadline = time.monotonic() + REBOOT_SECONDS
        while any(bus.ping(servo) is None for servo in broken):
            if time.monotonic() > deadline:
                raise DriverFault(f"of servo {broken} not all answer {REBOOT_SECONDS:g} s after they began anew")

    def close(self) -> None:
        """Close the port."""
        if self._bus is not None:
            self._bus.close()
        self._bus = None

    def _open(self) -> Bus:
        if self._bus is None:
            raise DriverFault(f"{self.settings.port} isn't connected")
        return self._bus

    def _numbers(self, field: tuple[int, int]) -> list[int]:
        return [int.from_bytes(data, "little") for data in self._open().read(*field)]

    def _write(self, field: tuple[int, int], value: int) -> None:
        self._open().write(*field, [value] * len(self.settings.ids))

    def _goal(self, raw: Floats) -> None:
        self._open().write(*GOAL, [round(value) for value in raw])

    def _errors(self) -> str:
        """Return the hardware errors of all servos in words; empty when there are none."""
        told = zip(self.settings.ids, self._numbers(HARDWARE_ERROR), strict=True)
        return "; ".join(
            f"servo {servo}: {', '.join(name for bit, name in ERRORS.items() if error >> bit & 1) or hex(error)}"
            for servo, error in told
            if error
        )

    def _check_rate(self) -> None:
        """Raise DriverFault where the bus can't carry the rate: the bytes of a cycle, and the servos' return delay."""
        settings, k = self.settings, len(self.settings.ids)
        count = (14 + k) + k * (STATE[1] + 11) + (14 + k * (GOAL[1] + 1))
        cycle = count * 10.0 / settings.baud + sum(self._numbers(RETURN_DELAY)) * 2e-6
        if cycle > 1.0 / settings.rate:
            raise DriverFault(
                f"{settings.rate:g} Hz is too fast for {k} servos at {settings.baud} baud: a cycle of {count} bytes "
                f"takes {1e3 * cycle:.3g} ms, which is {math.floor(1.0 / cycle)} Hz at most"
            )


def _number(data: bytes) -> int:
    return int.from_bytes(data, "little", signed=True)


def _steps(seconds: float) -> int:
    """Return a time in the steps of Bus Watchdog, 20 ms each."""
    return min(127, max(1, round(seconds / 0.02)))
