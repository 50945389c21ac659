"""Work that is done one after the other, away from the hub's loop."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

MOST_WAITING = 1000

_T = TypeVar("_T")


class InOrder(Generic[_T]):
    """Things that `work` is called with in the order in which they come, by a thread that lives while some wait."""

    def __init__(self, name: str, work: Callable[[_T], object]) -> None:
        """Wait for the first one; `name` is in the plural, and `work` raises nothing."""
        self._name, self._work = name, work
        self._changed = threading.Condition()
        self._waiting: deque[_T] = deque()
        self._thread: threading.Thread | None = None

    def put(self, one: _T) -> None:
        """Let one wait for its turn; returns at once.

        Raises:
            ValueError: when a thousand wait already.
        """
        with self._changed:
            if len(self._waiting) >= MOST_WAITING:
                raise ValueError(f"{MOST_WAITING} {self._name} wait already")
            self._waiting.append(one)
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                self._thread.start()

    def _run(self) -> None:
        while True:
            with self._changed:
                if not self._waiting:
                    self._thread = None
                    return
                one = self._waiting.popleft()
            self._work(one)
