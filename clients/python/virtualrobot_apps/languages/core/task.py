"""Tasks: a program at work in a thread, which somebody else may stop."""

from __future__ import annotations

import threading
import time


class TaskStopped(BaseException):
    """The program was stopped; no handler of its own catches it."""


class Task:
    """A program at work. Its code looks at `flags` before each statement, and calls `poll` where there are any."""

    def __init__(self) -> None:
        """Begin without a flag."""
        self.flags: list[str] = []
        self._changed = threading.Condition()

    def stop(self, why: str = "stopped") -> None:
        """End the program before its next statement, or in what it waits for; any thread may call it."""
        with self._changed:
            self.flags.append(why)
            self._changed.notify_all()

    @property
    def stopped(self) -> str:
        """Reason why it was stopped; empty as long as it was not."""
        return self.flags[0] if self.flags else ""

    def poll(self) -> None:
        """Do what the flags ask for: raise TaskStopped."""
        if self.flags:
            raise TaskStopped(self.flags[0])

    def pause(self, seconds: float) -> None:
        """Wait for so long by the wall clock, or until it is stopped; then raise TaskStopped."""
        end = time.monotonic() + seconds
        with self._changed:
            while not self.flags and (left := end - time.monotonic()) > 0:
                self._changed.wait(left)
        self.poll()
