"""Universal Robots by Real-Time Data Exchange (RTDE), without a library.

`begin` gives the controller a small script, which goes by `servoj` to six registers that each cycle sets. The script
watches that they are set (`rtde_set_watchdog`): where nothing comes the controller stops the robot by itself. Readings
have the controller's clock; one that stays is told as a fault, since a connection that is open proves nothing.
"""

from __future__ import annotations

import secrets
import time
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.drivers import About, Driver, DriverFault, Mode, Pace, Reading, Safety
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.poses import rotation_vector

from virtualrobot_plugins.drivers.ur_rtde.exchange import Exchange
from virtualrobot_plugins.drivers.ur_rtde.words import Dashboard, Primary

CONNECT_SECONDS = 3.0
"""Longest time for each connection, and for agreeing on what is told."""
BEGIN_SECONDS = 5.0
"""Longest time for another program to end, and for the script to start."""
PACKET_SECONDS = 1.0
"""Longest time for a packet where nothing follows yet."""
STOP_DECELERATION = 8.0
"""Deceleration (rad/s^2) of `stopj` where the driver stops the robot."""

_TOLD = {
    "timestamp": "DOUBLE",
    "actual_q": "VECTOR6D",
    "actual_qd": "VECTOR6D",
    "robot_mode": "INT32",
    "safety_mode": "INT32",
    "runtime_state": "UINT32",
    "speed_scaling": "DOUBLE",
    "actual_digital_input_bits": "UINT64",
    "output_int_register_24": "INT32",
}
# Registers from 24 on are those for clients like this one; those below belong to fieldbuses.
_TAKEN = {
    "input_int_register_24": "INT32",
    "input_int_register_25": "INT32",
    **{f"input_double_register_{i}": "DOUBLE" for i in range(24, 30)},
}
_OUTPUTS = {
    "standard_digital_output_mask": "UINT8",
    "standard_digital_output": "UINT8",
    "configurable_digital_output_mask": "UINT8",
    "configurable_digital_output": "UINT8",
}
_MODES = {3: Mode.OFF, 4: Mode.STARTING, 5: Mode.OFF, 6: Mode.HAND_GUIDED, 7: Mode.READY, 8: Mode.STARTING}
"""By robot_mode; the arm is OFF with its brakes closed, too. Those below 3 have no power either."""
_SAFETY = {
    1: (Safety.NORMAL, ""),
    2: (Safety.REDUCED, ""),
    3: (Safety.PROTECTIVE_STOP, "protective stop"),
    4: (Safety.FAULT, "recovery mode: a joint is outside the safety limits; move it back on the pendant"),
    5: (Safety.SAFEGUARD_STOP, "safeguard stop"),
    6: (Safety.EMERGENCY_STOP, "emergency stop of the system"),
    7: (Safety.EMERGENCY_STOP, "emergency stop of the robot"),
    8: (Safety.FAULT, "violation of the safety system"),
    9: (Safety.FAULT, "fault of the safety system"),
}
_PLAYING, _PROTECTIVE_STOP = 2, 3

# It ends once the register 25 has not its own number. The script and that number come by two connections, either first.
_SCRIPT = """\
def virtualrobot_driver():
  rtde_set_watchdog("input_int_register_24", {watchdog:g}, "stop")
  n = 0
  while read_input_integer_register(25) != {session} and n < 250:
    sync()
    n = n + 1
  end
  write_output_integer_register(24, {session})
  while read_input_integer_register(25) == {session}:
    q = [0, 0, 0, 0, 0, 0]
    i = 0
    while i < 6:
      q[i] = read_input_float_register(24 + i)
      i = i + 1
    end
    servoj(q, 0, 0, {period:g}, {lookahead:g}, {gain:g})
  end
  stopj({deceleration:g})
end
"""


class _Told(NamedTuple):
    """The variables of `_TOLD`."""

    stamp: float
    positions: tuple[float, ...]
    velocities: tuple[float, ...]
    robot_mode: int
    safety_mode: int
    runtime: int
    speed_scaling: float
    inputs: int
    session: int

    @classmethod
    def of(cls, flat: tuple) -> _Told:
        """Return them of values in a row."""
        return cls(flat[0], flat[1:7], flat[7:13], *flat[13:])


@dataclass(frozen=True, slots=True)
class UrRtdeSettings:
    """Settings of a controller of Universal Robots."""

    host: Annotated[str, Meta(min_length=1, description="The controller's address or name.")]
    rate: Annotated[
        Literal[125, 250, 500],
        Meta(description="Cycles a second (Hz) of readings and setpoints; older ones than the e-Series have 125."),
    ] = 500
    lookahead: Annotated[
        float, Meta(ge=0.03, le=0.2, description="Time (s) over which servoj smooths; the robot is late by about that.")
    ] = 0.05
    gain: Annotated[float, Meta(ge=100, le=2000, description="How tightly servoj follows.")] = 300.0
    watchdog: Annotated[
        float,
        Meta(ge=0.02, le=1, description="Time (s) without a setpoint after which the controller stops the robot."),
    ] = 0.05
    silence: Annotated[
        float, Meta(ge=0.01, le=1, description="Time (s) without a packet after which the connection is lost.")
    ] = 0.1
    outputs: Annotated[
        tuple[Annotated[int, Meta(ge=0, le=15)], ...],
        Meta(description="Digital outputs that the driver sets: 0 to 7 the standard, 8 to 15 the configurable ones."),
    ] = ()


class UrRtde(Driver):
    """The connection to one controller of Universal Robots."""

    def __init__(self, settings: UrRtdeSettings) -> None:
        """Keep the settings."""
        self._settings = settings
        self._exchange: Exchange | None = None
        self._primary: Primary | None = None
        self._dashboard: Dashboard | None = None
        self._told: _Told | None = None
        self._words = ("", "")
        self._session = self._count = 0
        self._sent: list[float] = [0.0] * 6

    def connect(self) -> About:
        """Connect to the controller's three ports, and agree on what each cycle tells and sets."""
        self.close()
        settings = self._settings
        self._session, self._words = 0, ("", "")
        try:
            exchange = self._exchange = Exchange(settings.host, CONNECT_SECONDS)
            taken = {**_TAKEN, **(_OUTPUTS if settings.outputs else {})}
            version = exchange.agree(float(settings.rate), _TOLD, taken)
            major, minor = version[:2]
            if (major, minor) < ((3, 9) if major < 5 else (5, 3)):
                raise DriverFault(f"the controller runs {major}.{minor}; this driver needs 3.9, or 5.3 and later")
            if major < 5 and settings.rate > 125:
                raise DriverFault(f"a controller with software {major}.{minor} has 125 Hz; set rate to 125")
            self._dashboard = Dashboard(settings.host, CONNECT_SECONDS)
            model, serial = (self._dashboard.ask(f"get {what}") for what in ("robot model", "serial number"))
            self._primary = Primary(settings.host, CONNECT_SECONDS)
            exchange.start()
            self._wait_for_reading()
        except BaseException:
            self.close()
            raise
        return About(
            joints=6,
            rate=float(settings.rate),
            pace=Pace.HOST,
            watchdog=settings.watchdog,
            silence=settings.silence,
            model=f"Universal Robots {model}",
            version=".".join(map(str, version)),
            serial=serial,
            speed_scaling=True,
            inputs=18,
            outputs=16,
        )

    def read(self) -> Reading:
        """Return the newest that the controller has told."""
        exchange = self._connected()
        told = exchange.poll()
        if told is not None:
            self._told = _Told.of(told)
        elif time.monotonic() - exchange.arrived > self._settings.silence:
            raise DriverFault(
                f"the controller at {exchange.here} has been silent for {self._settings.silence:g} s, its connection "
                "open",
                clears=True,
            )
        return self._reading()

    def _reading(self) -> Reading:
        told = self._told
        assert told is not None
        for code, text in self._primary.messages() if self._primary else ():
            self._words = code, text
        mode = _MODES.get(told.robot_mode, Mode.OFF)
        safety, text = _SAFETY.get(told.safety_mode, (Safety.FAULT, f"safety mode {told.safety_mode}"))
        runs = told.runtime == _PLAYING and told.session == self._session != 0
        if runs and mode is Mode.READY:
            mode = Mode.RUNNING
        code, words = self._words
        if safety in (Safety.NORMAL, Safety.REDUCED):
            text = _said(code, words) if words else ""
        elif words:
            text = f"{text}: {_said(code, words)}"
        return Reading(
            told.stamp,
            np.array(told.positions),
            np.array(told.velocities),
            mode=mode,
            safety=safety,
            # Where no program runs the controller tells 0, which slows nothing.
            speed_scaling=float(np.clip(told.speed_scaling, 0.0, 1.0)) if runs else 1.0,
            inputs=told.inputs & 0x3FFFF,
            text=text,
        )

    def begin(self, held: Floats) -> None:
        """Give the controller the script, and wait until it runs; it begins by holding the robot at `held`."""
        self._connected()
        primary, dashboard = self._primary, self._dashboard
        assert primary is not None and dashboard is not None
        told = self._wait_for_reading()
        reading = self._reading()
        if reading.safety not in (Safety.NORMAL, Safety.REDUCED):
            raise DriverFault(f"the robot can't follow: {reading.text}", clears=told.safety_mode == _PROTECTIVE_STOP)
        if reading.mode is not Mode.READY:
            raise DriverFault(
                f"the robot can't follow, it is {reading.mode.name}: switch it on and release its brakes on the pendant"
            )
        if dashboard.ask("is in remote control") == "false":
            raise DriverFault("the controller is in local control: switch it to remote control on the pendant")
        ends = time.monotonic() + BEGIN_SECONDS
        self._sent = [float(one) for one in held]
        self._session = 0
        while told.runtime == _PLAYING:
            if time.monotonic() > ends:
                raise DriverFault("a program runs on the controller: stop it on the pendant")
            told = self._wait_for_reading()
        self._words = ("", "")
        self._session = secrets.randbelow(1 << 30) + 1
        self._write()
        primary.upload(
            _SCRIPT.format(
                watchdog=1.0 / self._settings.watchdog,
                session=self._session,
                period=1.0 / self._settings.rate,
                lookahead=self._settings.lookahead,
                gain=self._settings.gain,
                deceleration=STOP_DECELERATION,
            )
        )
        while self._reading().mode is not Mode.RUNNING:
            if time.monotonic() > ends:
                said = _said(*self._words) or "it says nothing of it"
                self.stop()
                raise DriverFault(f"the controller doesn't run this driver's script: {said}")
            self._write()
            self._wait_for_reading()

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Set the registers that servoj follows; velocities it makes itself."""
        if not self._session:
            return
        self._sent = [float(one) for one in positions]
        self._write(outputs)

    def stop(self) -> None:
        """Have the script end by stopj."""
        self.end()

    def end(self) -> None:
        """Have the script end; the robot, if it moves, comes to rest by stopj."""
        if self._session and self._exchange is not None:
            self._session = 0
            self._write()

    def reset(self) -> None:
        """Unlock a protective stop, which the controller permits 5 s after it came, and close its window."""
        self._connected()
        assert self._dashboard is not None
        if self._wait_for_reading().safety_mode == _PROTECTIVE_STOP:
            self._dashboard.ask("close safety popup")
            said = self._dashboard.ask("unlock protective stop")
            if not said.lower().startswith("protective stop releasing"):
                raise DriverFault(said, clears=True)
            ends = time.monotonic() + BEGIN_SECONDS
            while self._wait_for_reading().safety_mode == _PROTECTIVE_STOP:
                if time.monotonic() > ends:
                    raise DriverFault(f"the controller says {said!r}, and is in its protective stop still", clears=True)
        self._words = ("", "")

    def set_tool(self, mass: float, center: Floats, flange_t_tcp: Floats) -> None:
        """Tell the controller of the tool, by a script beside the one that runs."""
        self._connected()
        assert self._primary is not None
        pose = [*flange_t_tcp[:3, 3], *rotation_vector(flange_t_tcp[:3, :3])]
        values = ", ".join(f"{float(one):.9g}" for one in pose)
        middle = ", ".join(f"{float(one):.9g}" for one in center)
        self._primary.upload(
            f"sec virtualrobot_tool():\n  set_tcp(p[{values}])\n  set_payload({mass:.9g}, [{middle}])\nend\n"
        )

    def close(self) -> None:
        """Have the robot stop if it follows, and give the connections back."""
        try:
            self.end()
        except DriverFault:
            pass  # the controller's watchdog does it
        for one in (self._exchange, self._primary, self._dashboard):
            if one is not None:
                one.close()
        self._exchange = self._primary = self._dashboard = None
        self._session = 0

    def _connected(self) -> Exchange:
        if self._exchange is None:
            raise DriverFault("there is no connection to the controller", clears=True)
        return self._exchange

    def _wait_for_reading(self) -> _Told:
        """Return the controller's next packet, which must come within a second."""
        exchange = self._connected()
        ends = time.monotonic() + PACKET_SECONDS
        while (told := exchange.poll(ends - time.monotonic())) is None:
            if time.monotonic() > ends:
                raise DriverFault(f"the controller at {exchange.here} is silent, its connection open", clears=True)
        self._told = _Told.of(told)
        return self._told

    def _write(self, outputs: int = 0) -> None:
        """Set the registers; without a session the script ends by that, and digital outputs stay."""
        self._count = self._count + 1 & 0x7FFFFFFF
        numbers: list[float] = [self._count, self._session, *self._sent]
        if self._settings.outputs:
            mask = sum(1 << one for one in self._settings.outputs) if self._session else 0
            numbers += [mask & 255, outputs & 255, mask >> 8, outputs >> 8 & 255]
        self._connected().send(numbers)


def _said(code: str, text: str) -> str:
    return f"{code}: {text}" if code else text
