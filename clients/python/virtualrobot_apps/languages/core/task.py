"""Tasks: a program at work in a thread, which somebody else may stop."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

from virtualrobot.clock import Observation


class TaskStopped(BaseException):
    """The program was stopped; no handler of its own catches it."""


class Task:
    """A program at work. Its code looks at `flags` before each statement, and calls `poll` where there are any.

    Attributes:
        flags: what the program is asked for.
        passing: has so many seconds of simulation time pass, in a world whose time goes on for this program alone;
            None: time passes by itself.
        at_work: makes what a run of the program is within, where tasks take turns.
        stopped_at: the place (`place`) of the statement before which it was stopped; empty until then.
    """

    def __init__(self) -> None:
        """Begin without a flag."""
        self.flags: list[str] = []
        self.passing: Callable[[float], None] | None = None
        self.at_work: Callable[[], AbstractContextManager[None]] = nullcontext
        self.stopped_at = ""
        self._why = ""
        self._changed = threading.Condition()

    def stop(self, why: str = "stopped") -> None:
        """End the program before its next statement, or in what it waits for; any thread may call it."""
        self._why = self._why or why
        self.ask("stop")

    def ask(self, flag: str) -> None:
        """Have the program call `poll` soon; any thread may call it."""
        with self._changed:
            if flag not in self.flags:
                self.flags.append(flag)
            self._changed.notify_all()

    def poll(self) -> None:
        """Do what the flags ask for: raise TaskStopped, or `serve`."""
        if self._why:
            self.stopped_at = self.place()
            raise TaskStopped(self._why)
        self.flags.clear()
        self.serve()

    def serve(self) -> None:
        """Do what was asked for besides a stop; a language has its own."""

    def passed(self, seen: Observation) -> None:
        """Take notice of the world, of which `passing` tells after each piece of time; a language may."""

    def place(self) -> str:
        """Return file and line of the statement that is done, as `file:line`, or nothing; a language knows it."""
        return ""

    def program_pointer(self) -> str:
        """Return file and line of the statement that is done, as any thread asks for it; a language knows it."""
        return ""

    def motion_pointer(self) -> str:
        """Return file and line of the move that the robot makes, as any thread asks for it; a language knows it."""
        return ""

    def pause(self, seconds: float) -> None:
        """Wait for so long by the wall clock, and do meanwhile what the flags ask for."""
        if self.passing is not None:
            self.rest(seconds)
            if self.flags:
                self.poll()
            return
        end = time.monotonic() + seconds
        while True:
            with self._changed:
                while not self.flags and (left := end - time.monotonic()) > 0:
                    self._changed.wait(left)
            if not self.flags:
                return
            self.poll()

    def rest(self, seconds: float) -> None:
        """Wait for so long by the wall clock, whatever the flags ask for."""
        if self.passing is not None:
            self.passing(seconds)
        else:
            time.sleep(seconds)


def here() -> str:
    """Return file and line of the statement that is being done: the innermost frame that is no file of Python's."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.endswith(".py"):
        frame = frame.f_back
    return f"{frame.f_code.co_filename}:{frame.f_lineno}"
