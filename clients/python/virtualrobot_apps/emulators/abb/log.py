"""Event log of an emulated ABB controller."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

MOST = 500
"""Number of the newest messages that are kept."""
KINDS = {"information": 1, "warning": 2, "error": 3}
"""Types of messages."""
TITLES = {
    10002: "Program pointer has been reset",
    10010: "Motors OFF state",
    10011: "Motors ON state",
    10020: "Execution error state",
    10125: "Program stopped",
    10150: "Program started",
    10151: "Program started",
    80001: "User defined error",
    80002: "User defined warning",
    80003: "User defined information",
}
"""Titles of the messages that the controller writes itself, by code (ABB, *Trouble shooting, IRC5*, 3HAC020738)."""


@dataclass(frozen=True, slots=True)
class Message:
    """A message of the log: number, type, code, time, title, and the words that were filled in."""

    number: int
    kind: int
    code: int
    time: datetime
    title: str
    words: tuple[str, ...]


class Log:
    """Messages, the newest last; any thread may write and read."""

    def __init__(self) -> None:
        """Be empty."""
        self._messages: deque[Message] = deque(maxlen=MOST)
        self._number = 0
        self._lock = threading.Lock()

    @property
    def newest(self) -> int:
        """Number of the newest message, 0 before the first."""
        return self._number

    def write(self, code: int, *words: str, kind: str = "information") -> None:
        """Add a message."""
        with self._lock:
            self._number += 1
            title = TITLES.get(code, f"Message {code}")
            self._messages.append(Message(self._number, KINDS[kind], code, datetime.now(), title, words))

    def report(self, kind: str, number: float | None, lines: Sequence[str]) -> None:
        """Add a message of a program: of ErrWrite without a number, of ErrLog with one."""
        codes = {"error": 80001, "warning": 80002, "information": 80003}
        self.write(codes[kind] if number is None else round(number), *lines, kind=kind)

    def since(self, number: int) -> list[Message]:
        """Return the messages after a number, the oldest first."""
        with self._lock:
            return [one for one in self._messages if one.number > number]
