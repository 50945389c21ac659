"""Processes of `virtualrobot serve` that begin with code and plugins loaded, which take five seconds of a core else.

Each is forked from one that has imported `tests.warm`: a process of its own like any other, that does what the command
does. Where there is no fork (Windows), nothing here is used.
"""

from __future__ import annotations

import atexit
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from multiprocessing.connection import Connection
from typing import NoReturn, TextIO

FORKS = "forkserver" in multiprocessing.get_all_start_methods()
"""Ability of this machine to fork."""


class Forked:
    """Process that is forked; it has what tests and clients use of `subprocess.Popen[str]`."""

    def __init__(self, *arguments: str, child: bool = False) -> None:
        """Start `virtualrobot` with these arguments.

        Its output comes by a pipe, and what it writes to the standard error, too. With `child` it is as
        `virtualrobot.child_process` starts it: its input is a pipe, its errors are this process's, and Ctrl-C does not
        reach it.
        """
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(["tests.warm"])
        given, self.stdin = _pipe_to() if child else (os.open(os.devnull, os.O_RDONLY), None)
        read, output = os.pipe()
        self.stdout = open(read, encoding="utf-8")
        ends = [Connection(one) for one in (given, output, os.dup(2 if child else output))]
        about = (list(arguments), dict(os.environ), os.getcwd(), child)
        self._process = context.Process(target=_run, args=(*about, *ends), daemon=True)
        self._process.start()
        for end in ends:
            end.close()
        assert self._process.pid is not None, "it was started"
        self.pid: int = self._process.pid

    @property
    def returncode(self) -> int | None:
        """Return the exit code, or None while it runs."""
        return self._process.exitcode

    def poll(self) -> int | None:
        """Return the exit code, or None while it runs."""
        return self._process.exitcode

    def wait(self, timeout: float | None = None) -> int:
        """Return the exit code; raise `subprocess.TimeoutExpired` after a time (s)."""
        self._process.join(timeout)
        if (code := self._process.exitcode) is None:
            raise subprocess.TimeoutExpired("virtualrobot", timeout or 0.0)
        return code

    def send_signal(self, number: int) -> None:
        """Send a signal to it, if it runs."""
        if self._process.exitcode is None:
            os.kill(self.pid, number)

    def terminate(self) -> None:
        """Ask it to end."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """End it at once."""
        self.send_signal(signal.SIGKILL)


def _pipe_to() -> tuple[int, TextIO]:
    """Return what a process reads from, and what is written to it by."""
    read, write = os.pipe()
    return read, open(write, "w", encoding="utf-8")


def _run(arguments: list[str], environment: dict[str, str], folder: str, child: bool, *ends: Connection) -> NoReturn:
    """Be the process: a command with these arguments, environment, working folder, and ends of three pipes."""
    for number, end in enumerate(ends):
        os.dup2(end.fileno(), number)
        end.close()
    sys.stdin = open(0, encoding="utf-8", closefd=False)
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)
    sys.stderr = open(2, "w", encoding="utf-8", buffering=1, closefd=False)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    if child:
        os.setpgid(0, 0)
    from virtualrobot_kernel import serve
    from virtualrobot_kernel.messages import values

    values.FIRST_EPOCH = int(time.time() * 1000.0)  # as where it is imported: kernels are told from each other by it
    command = {"serve": serve.main, "replay": serve.replay}[arguments[0]]
    try:
        code = command(arguments[1:])
    except SystemExit as told:
        code = told.code
    atexit._run_exitfuncs()  # those of a fork are not run else
    sys.exit(code)
