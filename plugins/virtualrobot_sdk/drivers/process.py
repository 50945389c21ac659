"""Process of a driver, as the kernel has it: started, asked, watched and ended."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np

from virtualrobot_sdk.drivers.driver import About, DriverFault, Words
from virtualrobot_sdk.drivers.robot_side import RobotSide
from virtualrobot_sdk.drivers.shared import Floats
from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.worker import Worker

CALL_SECONDS = 15.0
"""Longest time (s) for a call that asks the controller for something; then the process is killed."""

QUICK_SECONDS = 3.0
"""Longest time (s) for one that doesn't."""

_HOST = "virtualrobot_sdk.drivers.host_process:make_host"


class DriverProcess:
    """Process of one robot's driver. One thread calls it, but for `kill`, which any may.

    Each call raises DriverFault with the controller's own words, ArgumentError for settings or joints that are wrong,
    PluginError where the plugin has no such driver, and ComponentFault when the process hangs, dies or is killed.
    """

    def __init__(self, name: str) -> None:
        """Make ready; `name`, as of the robot, stands before what the process prints in the log."""
        self._worker = Worker(name)

    @property
    def pid(self) -> int | None:
        """Number of the process; None while there is none."""
        return self._worker.pid

    @property
    def fault(self) -> ComponentFault | None:
        """Fault that ended the process, if one did."""
        return self._worker.fault or self._worker.death

    def make(
        self,
        entry_point: EntryPoint,
        component: str,
        settings: Mapping[str, Any],
        side: RobotSide,
        ring: Path,
        cell: Path,
    ) -> None:
        """Start the process and make the driver, connected to nothing yet; `ring` and `cell` are the shared files."""
        named = entry_point.name, entry_point.value, entry_point.group
        self._worker.make_from(_HOST, named, component, dict(settings), side, ring, cell)

    def connect(self) -> About:
        """Connect to the controller and return what it is; the robot isn't moved."""
        found = self._worker.call("connect", deadline_seconds=CALL_SECONDS)
        if isinstance(found, Words):
            raise _fault(found)
        return found

    def begin(self) -> None:
        """Let the robot follow its twin: reports say BEGINNING, then ACTIVE."""
        self._done(self._worker.call("begin", deadline_seconds=CALL_SECONDS))

    def end(self) -> None:
        """Let the robot, which is at rest, no longer follow."""
        self._done(self._worker.call("end", deadline_seconds=CALL_SECONDS))

    def reset(self) -> None:
        """Have the controller clear its fault."""
        self._done(self._worker.call("reset", deadline_seconds=CALL_SECONDS))

    def set_tool(self, mass: float, center: Floats, flange_t_tcp: Floats) -> None:
        """Tell the controller of the tool: mass (kg), centre of mass (3,) and TCP (4, 4) in the flange's frame."""
        arguments = mass, np.asarray(center), np.asarray(flange_t_tcp)
        self._done(self._worker.call("set_tool", *arguments, deadline_seconds=CALL_SECONDS))

    def words(self) -> Words:
        """Return the newest words of the controller, or about it."""
        return self._of_host("words")

    def where(self) -> Words:
        """Return where the driver is just now, as of one that is silent; without text it is nowhere."""
        return self._of_host("where")

    def close(self) -> None:
        """Bring the robot to rest, disconnect and end the process."""
        try:
            if self._worker.pid is not None:
                self._worker.call("close", deadline_seconds=CALL_SECONDS)
        except ComponentFault:
            pass  # it has ended
        finally:
            self._worker.close()

    def kill(self) -> None:
        """End the process now, as where it hangs: its controller's own watchdog stops the robot."""
        self._worker.close()

    def _of_host(self, method: str) -> Words:
        """Return what the host tells without the driver, which has no such method: a fault must not name it."""
        try:
            return self._worker.call(method, deadline_seconds=QUICK_SECONDS)
        except ComponentFault as fault:
            reason = fault.reason.removesuffix(f" in {method}").replace(f"{method} gave", "its process gave")
            raise ComponentFault(fault.kind, reason, fault.details) from fault

    def _done(self, words: Words) -> None:
        if words.text:
            raise _fault(words)


def _fault(words: Words) -> DriverFault:
    return DriverFault(words.text, words.code, words.clears)
