"""The parent's hold on a worker process: starts it, passes on what it prints, ends it."""

from __future__ import annotations

import contextlib
import io
import logging
import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterable

import psutil

from virtualrobot_sdk.worker import boot

log = logging.getLogger("virtualrobot_sdk.worker")

_ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "BLIS_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "NUMEXPR_NUM_THREADS",
    ),
    "1",
)
"""Small matrices gain nothing from threads, and those of several workers fight; the user's own setting wins."""
_PIPE_BYTES = 1 << 20
_LINES_KEPT = 60
LOG_BYTES = 1 << 18
"""Bytes of a process's prints that are logged at once, and _LOG_BYTES_A_SECOND more: no log grows without bound."""
_LOG_BYTES_A_SECOND = 1 << 12
_LAST_WORDS_SECONDS = 1.0
"""Time (s) for a process that hangs to say where."""
_REST_OF_IT_SECONDS = 0.05
"""Time (s) for the rest of what it says to arrive."""
_REAP_SECONDS = 5.0


class Process:
    """Owns a worker process, its pipes and the thread that reads its error output."""

    def __init__(self, name: str) -> None:
        """Start the process; `name` stands before what it prints."""
        self.name = name
        self._popen = subprocess.Popen(
            boot.command("virtualrobot_sdk.worker.child"),
            bufsize=0,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**_ONE_THREAD, **os.environ},
            pipesize=_PIPE_BYTES,
            # A group of its own: so what it starts itself can be ended with it.
            process_group=None if sys.platform == "win32" else 0,
        )
        self.pid = self._popen.pid
        self.requests, self.answers, self._errors = map(
            _raw, (self._popen.stdin, self._popen.stdout, self._popen.stderr)
        )
        self._killing = threading.Lock()
        self._gone = False
        self._said_all = False
        self._last_lines: deque[str] = deque(maxlen=_LINES_KEPT)
        self._lines = 0
        self._log_room = float(LOG_BYTES)
        self._log_filled = time.monotonic()
        self._left_out = 0
        self._reader = threading.Thread(target=self._read_errors, name=f"worker-errors-{name}", daemon=True)
        self._reader.start()

    def ask_where(self) -> None:
        """Let it print what each of its threads is doing, where the system can; takes about a second at most."""
        if sys.platform == "win32" or self._popen.poll() is not None:
            return
        before = self._lines
        self._popen.send_signal(signal.SIGUSR1)
        end = time.monotonic() + _LAST_WORDS_SECONDS
        while self._lines == before and time.monotonic() < end:
            time.sleep(_REST_OF_IT_SECONDS)
        time.sleep(_REST_OF_IT_SECONDS)

    def kill(self) -> None:
        """End it now, with all that it started."""
        with self._killing:
            if self._gone:
                return
            descendants = self._descendants()
            if sys.platform == "win32":
                self._popen.kill()
            else:
                # Nobody is left in the group; macOS says it by the second error while the process is a zombie.
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(self.pid, signal.SIGKILL)
            _kill(descendants)
            # From now on the number may be another's.
            self._gone = self._popen.poll() is not None

    def end(self, grace_seconds: float = 0.0) -> None:
        """Close the question pipe, wait `grace_seconds` for the process to end, kill it, and give everything back."""
        descendants = self._descendants()
        self.requests.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._popen.wait(grace_seconds)
        self.kill()
        _kill(descendants)  # those that left the group and outlived it
        self._popen.wait(_REAP_SECONDS)
        # Only a process whose parents were gone before can still hold the pipe; then the thread stays with it.
        self._reader.join(_REAP_SECONDS)
        self.answers.close()
        if not self._reader.is_alive():
            self._errors.close()

    def _descendants(self) -> list[psutil.Process]:
        """Return the processes that it has started, and that these have, in whatever group or session."""
        with contextlib.suppress(psutil.Error):
            return psutil.Process(self.pid).children(recursive=True) if self._popen.poll() is None else []
        return []

    def has_ended(self) -> str:
        """Return how it has ended, as `how_it_ended`; empty while it lives. It waits for nothing."""
        code = self._popen.poll() if self._said_all else None
        return "" if code is None else _ended_with(code)

    def how_it_ended(self) -> str:
        """Return `ended with SIGSEGV` or `ended with exit code 3`; waits for the end of its output too."""
        try:
            code = self._popen.wait(_REAP_SECONDS)
        except subprocess.TimeoutExpired:
            return "closed its pipe"
        self.kill()
        self._reader.join(_REAP_SECONDS)
        return _ended_with(code)

    def last_lines(self) -> str:
        """Return the last lines that it printed."""
        return "\n".join(self._last_lines)

    def _read_errors(self) -> None:
        """Log what the process prints until the pipe ends; a piece at a time, so that a flood of lines costs little."""
        rest = b""
        while piece := self._errors.read(_PIPE_BYTES):
            lines, newline, last = (rest + piece).rpartition(b"\n")
            # A line without an end is passed on when it is as long as a piece.
            rest = last if len(last) < _PIPE_BYTES else b""
            self._log(lines + newline + (b"" if rest else last))
        self._log(rest)
        if self._left_out:
            log.warning("%s: %s", self.name, self._said_left_out())
        self._said_all = True

    def _log(self, text: bytes) -> None:
        lines = text.decode("utf-8", errors="backslashreplace").splitlines()
        if not lines:
            return
        self._last_lines.extend(lines)
        self._lines += len(lines)
        now = time.monotonic()
        self._log_room = min(LOG_BYTES, self._log_room + (now - self._log_filled) * _LOG_BYTES_A_SECOND)
        self._log_filled = now
        logged = []
        for line in lines:
            if len(line) < self._log_room:
                if self._left_out:
                    logged.append(self._said_left_out())
                logged.append(line)
                self._log_room -= len(line) + 1
            else:
                self._log_room = 0.0
                self._left_out += 1
        if logged:
            log.warning("%s", "\n".join(f"{self.name}: {line}" for line in logged))

    def _said_left_out(self) -> str:
        said, self._left_out = f"({self._left_out:,} lines that it printed are left out)", 0
        return said


def _ended_with(code: int) -> str:
    if code < 0:
        names = {s.value: s.name for s in signal.Signals}
        return f"ended with {names.get(-code, f'signal {-code}')}"
    return f"ended with exit code {code}"


def _kill(processes: Iterable[psutil.Process]) -> None:
    for process in processes:
        with contextlib.suppress(psutil.Error):
            process.kill()


def _raw(pipe: object) -> io.FileIO:
    if not isinstance(pipe, io.FileIO):
        raise TypeError(f"a pipe of subprocess is {type(pipe).__name__}; without a buffer it is a FileIO")
    return pipe
