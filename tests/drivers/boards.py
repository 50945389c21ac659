"""The board of the page of `serial_line`, run under CPython at the other end of a cable."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

from tests.drivers.cables import Cable

PROGRAM = Path(__file__).parents[2] / "docs" / "drivers" / "serial_line" / "board.py"
RUNNER = Path(__file__).with_name("micropython.py")


class Board:
    """A process that runs the program of the page, with other constants."""

    def __init__(self, cable: Cable, folder: Path, **constants: object) -> None:
        """Begin, and wait until the program does."""
        lines = PROGRAM.read_text().splitlines(keepends=True)
        for name, value in constants.items():
            (at,) = (i for i, line in enumerate(lines) if line.startswith(f"{name} = "))
            lines[at] = f"{name} = {value!r}\n"
        program = folder / "main.py"
        program.write_text("".join(lines))
        begun, begins = os.pipe()
        command = [sys.executable, "-S", str(RUNNER), str(program), str(begins)]
        self._process = subprocess.Popen(command, stdin=cable.end, stdout=cable.end, pass_fds=(begins,))
        os.close(begins)
        os.read(begun, 1)
        os.close(begun)

    def freeze(self) -> None:
        """Do nothing more."""
        self._process.send_signal(signal.SIGSTOP)

    def go_on(self) -> None:
        """Go on after a freeze."""
        self._process.send_signal(signal.SIGCONT)

    def close(self) -> None:
        """End; harmless more than once."""
        self._process.kill()
        self._process.wait()
