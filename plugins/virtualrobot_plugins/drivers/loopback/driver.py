"""The driver of the computed controller: its clock, its cable, and the port at which faults are asked for."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Sequence
from typing import NoReturn

import numpy as np
from virtualrobot_sdk.drivers import About, Driver, DriverFault, Pace, Reading
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.drivers.loopback.control import ControlPort
from virtualrobot_plugins.drivers.loopback.controller import Controller
from virtualrobot_plugins.drivers.loopback.settings import LoopbackSettings

SILENT_CYCLES = 3
"""Number of cycles without a word of the controller's after which it is told to be silent."""
LATEST_SECONDS = 10.0
"""Longest time (s) by which a driver is late that is to be late."""
FLOOD = 64 * 1024
"""Number of characters that a driver prints each cycle that floods."""


class Loopback(Driver):
    """A controller that is computed: delay, jitter, lag, noise, and faults on demand."""

    def __init__(self, settings: LoopbackSettings) -> None:
        """Switch the controller on; it stays on, whoever connects."""
        self.settings = settings
        self.controller = Controller(settings)
        self._unit = math.radians(1.0) if settings.degrees else 1.0
        self._since = time.perf_counter()
        self._read_at = 0
        self._port: ControlPort | None = None
        self._connected = False

    def connect(self) -> About:
        """Connect, unless the controller has no power."""
        if self._port is None and self.settings.control_port:
            self._port = ControlPort(self.settings.control_port, self.controller)
        self._look()
        if "power" in self.controller.active or "silent" in self.controller.active:
            raise DriverFault("nobody answers at loopback: the controller is off or starting")
        self._connected = True
        # Whoever connects anew has lost the hold that it had.
        self.controller.stop()
        self._read_at = self.controller.cycle
        return About(
            joints=self.settings.joints,
            rate=self.settings.rate,
            pace=Pace[self.settings.pace],
            units=self._unit,
            watchdog=self.settings.watchdog,
            model="loopback",
            version="1",
            speed_scaling=True,
            inputs=64,
            outputs=64,
        )

    def read(self) -> Reading:
        """Return the newest cycle; of CONTROLLER wait for the next one."""
        if self.settings.pace == "CONTROLLER":
            time.sleep(max(0.0, (self._read_at + 1) / self.settings.rate - self._now()))
        self._look()
        controller = self.controller
        if "silent" in controller.active:
            # The last cycle is told again until it is certain.
            if self.settings.pace == "CONTROLLER":
                time.sleep(SILENT_CYCLES / self.settings.rate)
            if self.settings.pace == "CONTROLLER" or controller.cycle - self._read_at >= SILENT_CYCLES:
                self._connected = False
                raise DriverFault(f"loopback has been silent for {1e3 * SILENT_CYCLES / self.settings.rate:.3g} ms")
        else:
            self._read_at = controller.cycle
        if self.settings.pace == "JOBS":
            # Setpoints tell that somebody is there; of jobs, whoever asks how far they are.
            controller.heard(self._now())
        return Reading(
            stamp=self._read_at / self.settings.rate,
            positions=controller.measured() / self._unit,
            velocities=controller.v / self._unit,
            mode=controller.mode(),
            safety=controller.safety(),
            speed_scaling=controller.value("slow") if "slow" in controller.active else 1.0,
            inputs=controller.inputs,
            text=controller.words(),
            done=controller.done,
        )

    def begin(self, held: Floats) -> None:
        """Follow."""
        self._look()
        self.controller.begin(self._now())

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Go there in the next cycle, after the delay."""
        self._answering()
        self.controller.setpoint(np.asarray(positions) * self._unit, outputs, self._now())

    def run(self, points: Sequence[Floats], speeds: Sequence[float], outputs: int) -> None:
        """Go to points."""
        self._answering()
        self.controller.run([np.asarray(point) * self._unit for point in points], speeds, outputs)

    def stop(self) -> None:
        """Come to rest."""
        self.controller.stop()

    def end(self) -> None:
        """Follow no longer."""
        if "raises_at_end" in self.controller.active:
            del self.controller.active["raises_at_end"]
            raise RuntimeError("loopback raises as it ends, as it was asked to")
        if "hangs_at_end" in self.controller.active:
            _hang()
        self.controller.stop()

    def reset(self) -> None:
        """Clear a protective stop; switch the motors on after a loss of power."""
        self._look()
        self._answering()
        self.controller.reset()

    def close(self) -> None:
        """Disconnect; the robot comes to rest."""
        self.controller.stop()
        self._connected = False
        if self._port is not None:
            self._port.close()
            self._port = None

    def _now(self) -> float:
        """Return the controller's time (s)."""
        return time.perf_counter() - self._since

    def _look(self) -> None:
        """Have the controller make the cycles that are due, take what was asked for, and behave as its faults say."""
        if self._port is not None:
            self._port.serve()
        controller = self.controller
        if "late" in controller.active:
            late = controller.value("late")
            del controller.active["late"]
            time.sleep(min(max(0.0, late), LATEST_SECONDS))
        controller.advance(int(self._now() * self.settings.rate))
        if "raises" in controller.active:
            del controller.active["raises"]
            raise RuntimeError("loopback raises, as it was asked to")
        if "hangs" in controller.active:
            _hang()
        if "dies" in controller.active:
            os._exit(1)
        if "floods" in controller.active:
            print("loopback floods " * (FLOOD // 16))
        if self._connected:
            self._answering()

    def _answering(self) -> None:
        """Raise DriverFault where the controller has no power: nothing answers then."""
        if self._connected and "power" in self.controller.active:
            self._connected = False
        if not self._connected:
            raise DriverFault("the connection to loopback is lost: connection reset by peer")


def _hang() -> NoReturn:
    while True:
        time.sleep(3600.0)
