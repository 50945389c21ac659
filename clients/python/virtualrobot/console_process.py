"""The console of a kernel as a child process of this program, which ends with it."""

from __future__ import annotations

import os
import subprocess
import threading
from collections.abc import Callable
from contextlib import suppress
from importlib.metadata import entry_points
from importlib.util import find_spec

from virtualrobot.child_process import end_child, start_child


def console_is_installed() -> bool:
    """Return whether `virtualrobot console` is there, with what it serves with."""
    found = entry_points(group="virtualrobot.commands", name="console")
    return bool(found) and all(find_spec(name) is not None for name in ("uvicorn", "websockets"))


class ConsoleProcess:
    """A console that was started on a free port of this machine; a context manager that ends it.

    Should this program be killed, the console's standard input ends and the console with it.

    Example:
        >>> with ConsoleProcess("127.0.0.1:50500", say=print):
        ...     input("Enter ends the console")
    """

    def __init__(self, address: str, token: str = "", say: Callable[[str], object] | None = None) -> None:
        """Start it for the kernel at `address` and don't wait for it.

        Args:
            address: `host:port` of a kernel of this machine.
            token: of that kernel; "" means the one that the command finds.
            say: gets each line that it prints, the first of which has the link.
        """
        command = ("console", "--address", address, "--end-with-input")
        environment = {**os.environ, "VIRTUALROBOT_TOKEN": token} if token else None
        self._say = say
        self._process = start_child(*command, stderr=subprocess.STDOUT, environment=environment)
        threading.Thread(target=self._read, name="console output", daemon=True).start()

    def close(self, timeout: float = 5.0) -> int:
        """End the console and return its exit code; one that does not end in time (s) is killed."""
        return end_child(self._process, timeout)

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as lines:
            for line in lines:
                if self._say is not None:
                    with suppress(OSError):  # whoever read what this program prints has gone; the console goes on
                        self._say(line.rstrip())

    def __enter__(self) -> ConsoleProcess:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the console."""
        self.close()

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<ConsoleProcess {self._process.pid}>"
