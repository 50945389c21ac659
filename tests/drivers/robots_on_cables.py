"""Drivers for the contract suite, each with its counterpart on a cable in the driver's own process."""

from __future__ import annotations

import atexit
import dataclasses
import functools
import shutil
import tempfile
from pathlib import Path
from typing import Protocol

from virtualrobot_plugins.drivers.crs import Crs, CrsSettings
from virtualrobot_plugins.drivers.dynamixel.driver import Dynamixel, DynamixelSettings
from virtualrobot_plugins.drivers.serial_line import SerialLine, SerialLineSettings
from virtualrobot_sdk.drivers import Driver
from virtualrobot_sdk.hookspecs import Register, hookimpl

from tests.drivers.boards import Board
from tests.drivers.cables import Cable
from tests.drivers.rapl import Controller
from tests.drivers.servos import Servo, Servos

api_version = "1.0"
NOBODY = "/dev/ttyNOBODY"
SILENCE = 1.0
"""Silence (s) after which the drivers complain: a busy machine is slow."""


class Counterpart(Protocol):
    """The other end of a cable."""

    def plug(self) -> None:
        """Be there."""

    def unplug(self) -> None:
        """Be gone, as when the cable is pulled."""

    def silence(self, silent: bool) -> None:
        """Say nothing more, or answer again."""


@functools.cache
def folder() -> Path:
    """Return a folder for the cable of this process."""
    path = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, path, True)
    return Path(path)


@functools.cache
def cable() -> Cable:
    """Return the cable of this process, plugged in."""
    return Cable(folder())


class BoardEnd:
    """The board of the page."""

    def __init__(self, **constants: object) -> None:
        """Have other constants."""
        self.constants = constants
        self.board = Board(cable(), folder(), **constants)
        atexit.register(self.unplug)

    def plug(self) -> None:
        """Begin anew, as a board does that gets its power from the cable."""
        cable().plug()
        self.board = Board(cable(), folder(), **self.constants)

    def unplug(self) -> None:
        """Lose its power."""
        self.board.close()
        cable().unplug()

    def silence(self, silent: bool) -> None:
        """Freeze, or go on."""
        self.board.freeze() if silent else self.board.go_on()


class ServosEnd:
    """Servos, which keep their power."""

    def __init__(self) -> None:
        """Plug them in: not much faster than they are sent, since a busy machine may read them just as they go."""
        self.servos = Servos(Servo(1, 2000, speed=400.0), Servo(2, 2100, speed=400.0))
        cable().serve(self.servos)

    def plug(self) -> None:
        """Be plugged in again."""
        cable().plug()
        cable().serve(self.servos)

    def unplug(self) -> None:
        """Be pulled off."""
        cable().unplug()

    def silence(self, silent: bool) -> None:
        """Have one servo answer no more, or again."""
        self.servos.servos[2].answers = not silent


class ControllerEnd:
    """A CRS controller."""

    def __init__(self) -> None:
        """Have a slow arm, so that it may be stopped on its way."""
        self.controller = Controller(speed=4.0)
        cable().serve(self.controller)

    def plug(self) -> None:
        """Be plugged in again."""
        cable().plug()
        cable().serve(self.controller)

    def unplug(self) -> None:
        """Be pulled off."""
        cable().unplug()

    def silence(self, silent: bool) -> None:
        """Say nothing more, or answer again."""
        self.controller.says = not silent


END: list[Counterpart] = []
"""The counterpart of this process, once there is one."""


def _path(port: str, make: type[Counterpart] | functools.partial[Counterpart]) -> str:
    """Return the path of the cable where that is meant, with its counterpart."""
    if port != "cable":
        return port
    if not END:
        END.append(make())
    return str(cable().path)


def board(settings: SerialLineSettings) -> Driver:
    """Return a driver of a board that follows setpoints."""
    path = _path(settings.port, functools.partial(BoardEnd, WATCHDOG_MS=10_000))
    return SerialLine(dataclasses.replace(settings, port=path, silence_seconds=SILENCE))


def jobs(settings: SerialLineSettings) -> Driver:
    """Return a driver of a board that goes to points by itself, slowly."""
    path = _path(settings.port, functools.partial(BoardEnd, WATCHDOG_MS=10_000, JOBS=True, SPEED=4.0))
    return SerialLine(dataclasses.replace(settings, port=path, silence_seconds=SILENCE))


def servos(settings: DynamixelSettings) -> Driver:
    """Return a driver of two servos."""
    path = _path(settings.port, ServosEnd)
    return Dynamixel(dataclasses.replace(settings, port=path, silence_seconds=SILENCE, watchdog_seconds=2.54))


def arm(settings: CrsSettings) -> Driver:
    """Return a driver of a CRS arm."""
    path = _path(settings.port, ControllerEnd)
    return Crs(dataclasses.replace(settings, port=path, silence_seconds=SILENCE, tolerance_degrees=0.05))


@hookimpl
def virtualrobot_register_robot_drivers(register: Register) -> None:
    """Register them; the port `cable` is that of the counterpart."""
    register("board", board, SerialLineSettings)
    register("jobs", jobs, SerialLineSettings)
    register("servos", servos, DynamixelSettings)
    register("arm", arm, CrsSettings)


def breaks(driver: Driver) -> None:
    """Pull the cable."""
    END[0].unplug()


def silences(driver: Driver) -> None:
    """Have the counterpart say nothing more."""
    END[0].silence(True)


def mends(driver: Driver) -> None:
    """Make either good."""
    if cable().path.is_symlink():
        END[0].silence(False)
    else:
        END[0].plug()


def overload(driver: Driver) -> None:
    """Block a servo."""
    counterpart = END[0]
    assert isinstance(counterpart, ServosEnd)
    counterpart.servos.servos[2].overload()
