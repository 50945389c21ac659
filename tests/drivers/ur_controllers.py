"""Emulated controllers of Universal Robots in processes of their own, and the driver beside one."""

from __future__ import annotations

import atexit
import functools
import signal
import subprocess
import sys

from virtualrobot_plugins.drivers.ur_rtde.driver import UrRtde, UrRtdeSettings
from virtualrobot_sdk.drivers import measured
from virtualrobot_sdk.hookspecs import Register, hookimpl

from tests.drivers.peers import ADDRESS

api_version = "1.0"
NOBODY = "127.63.255.254"
BUSY = 1.0
"""Watchdog and silence (s) that a busy machine keeps."""


def host(number: int) -> str:
    """Return another address of this process alone, for one of four controllers; the first one's is `ADDRESS`."""
    first, second, *rest = ADDRESS.split(".")
    return ".".join((first, str((int(second) + 64 * number) % 256), *rest))


class ControllerProcess:
    """`virtualrobot emulate ur`, which ends with this process at the latest."""

    def __init__(self, *options: str, host: str = ADDRESS) -> None:
        """Start it, and wait until it listens."""
        self.host, self._options = host, options
        self._start()

    def _start(self) -> None:
        program = "import sys; from virtualrobot.cli import main; sys.exit(main())"
        command = [sys.executable, "-c", program, "emulate", "ur", "--host", self.host, "--until-input-ends"]
        self._process = subprocess.Popen(
            [*command, *self._options], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert "listens at" in line, line

    def order(self, line: str) -> None:
        """Have something happen to it."""
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def freeze(self) -> None:
        """Have it do nothing, its connections open."""
        self._process.send_signal(signal.SIGSTOP)

    def thaw(self) -> None:
        """Have it go on."""
        self._process.send_signal(signal.SIGCONT)

    def kill(self) -> str:
        """End it at once; return what it has said since it listens."""
        self._process.kill()
        return self._process.communicate()[0]

    def mend(self) -> None:
        """Have it go on, or start it anew where it was killed."""
        if self._process.poll() is None:
            self.thaw()
        else:
            self._start()


@functools.cache
def controller() -> ControllerProcess:
    """Return the controller of this process."""
    made = ControllerProcess()
    atexit.register(made.kill)
    return made


def beside(settings: UrRtdeSettings) -> UrRtde:
    """Return the driver, and have its controller run where `host` is `beside`; its process is patient."""
    measured.SILENT_SECONDS = BUSY
    if settings.host == "beside":
        settings = UrRtdeSettings(controller().host, 125, watchdog=BUSY, silence=BUSY)
    return UrRtde(settings)


def breaks(driver: UrRtde) -> None:
    """End the controller at once."""
    controller().kill()


def silences(driver: UrRtde) -> None:
    """Freeze the controller."""
    controller().freeze()


def mends(driver: UrRtde) -> None:
    """Make all well."""
    controller().mend()


def meets(driver: UrRtde) -> None:
    """Have the robot meet something."""
    controller().order("protective stop")


@hookimpl
def virtualrobot_register_robot_drivers(register: Register) -> None:
    """Offer the driver with its controller."""
    register("ur_rtde", beside, UrRtdeSettings)
