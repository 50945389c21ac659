"""A controller that is an FMU, as a wire of the lockstep: a process of its own loads it."""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

from virtualrobot import errors
from virtualrobot.errors import MissingFileError, WrongStateError

from virtualrobot_apps.lockstep.wire import ProgramWire

_BEGIN_SECONDS = 120.0
"""Longest time (s) until an FMU is loaded: that of large ones, and of tools that have to start."""


class FmuWire:
    """A program that loads an FMU and steps it; so an FMU that crashes or hangs ends the run, and nothing else."""

    def __init__(self, file: Path, period: float) -> None:
        """Load it; it is asked once a period (s).

        Raises:
            MissingFileError: when the file is not there.
            MalformedFileError: when it is no FMU for co-simulation, or has no output that is part of a command.
            WrongStateError: when it can't begin.
            CallTimeoutError: when it hasn't begun after two minutes.
        """
        if not file.is_file():
            raise MissingFileError(f"{file} is not there")
        self._folder = tempfile.mkdtemp(prefix="virtualrobot-fmu-")
        program = [sys.executable, "-m", "virtualrobot_apps.fmi.controller"]
        self._wire = ProgramWire([*program, str(file), self._folder, repr(period)])
        try:
            if self.receive(_BEGIN_SECONDS) is None:
                raise WrongStateError(f"{file.name} has ended as it was loaded")
        except BaseException:
            self.close()
            raise

    def send(self, line: str) -> None:
        """Send a state."""
        self._wire.send(line)

    def receive(self, seconds: float) -> str | None:
        """Return the command after a step; None once it wants to end.

        Raises:
            CallTimeoutError: when the step takes longer than so many seconds.
            InvalidArgumentError: for an input that the state has no value for.
            WrongStateError: when it has failed.
        """
        line = self._wire.receive(seconds)
        if line is not None and line.startswith('{"error"'):
            told = json.loads(line)
            raise getattr(errors, told["error"])(told["message"])
        return line

    def close(self) -> None:
        """End its process, and take away what was unpacked."""
        self._wire.close()
        with suppress(OSError):
            shutil.rmtree(self._folder)
