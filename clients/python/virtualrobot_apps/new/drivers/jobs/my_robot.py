"""Driver of the robot my_robot: lines of text on a serial port, told in README.md."""

import math
from dataclasses import dataclass

import numpy as np
import serial
from virtualrobot_sdk.drivers import About, Driver, DriverFault, Mode, Pace, Reading
from virtualrobot_sdk.hookspecs import hookimpl

api_version = "1.0"


@dataclass(frozen=True)
class Settings:
    port: str
    silence_seconds: float = 0.1


class MyRobot(Driver):
    """The robot my_robot, by lines of text on a serial port."""

    def __init__(self, settings):
        self.settings, self.line = settings, serial.Serial()

    def connect(self):
        self.close()
        try:
            port, patience = self.settings.port, self.settings.silence_seconds
            self.line = serial.serial_for_url(port, 115200, timeout=patience, exclusive=True)
            joints, rate, watchdog = map(float, self.ask("hello"))
        except (OSError, ValueError) as error:  # no port, or somebody else answers there
            raise DriverFault(f"{self.settings.port}: {error}") from error
        return About(int(joints), rate, Pace.JOBS, units=math.radians(1.0), watchdog=watchdog)

    def read(self):
        stamp, mode, done, *degrees = self.ask("read")
        return Reading(float(stamp), np.array(degrees, dtype=float), mode=Mode[mode], done=int(done))

    def begin(self, held):
        self.ask("on")

    def run(self, points, speeds, outputs):
        for point, speed in zip(points, speeds, strict=True):
            self.ask("move", 100.0 * speed, *point)

    def stop(self):
        self.ask("stop")

    def end(self):
        self.ask("off")

    def reset(self):
        self.ask("reset")

    def close(self):
        self.line.close()

    def ask(self, *words):
        """Say a line and return the words of the answer; no cable, silence and an error are a DriverFault."""
        try:
            self.line.write((" ".join(map(str, words)) + "\n").encode())
            answer = self.line.readline().decode("ascii", "replace")
        except OSError as error:
            raise DriverFault(f"{self.settings.port}: {error}") from error
        if not answer.endswith("\n"):
            raise DriverFault(f"{self.settings.port} is silent")
        kind, *rest = answer.split() or [""]
        if kind == "error":
            raise DriverFault(" ".join(rest[1:]), code=" ".join(rest[:1]), clears=True)
        return rest


@hookimpl
def virtualrobot_register_robot_drivers(register):
    register("my_robot", MyRobot, Settings)
