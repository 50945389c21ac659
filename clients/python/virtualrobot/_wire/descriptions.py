"""Descriptions of robots and tools: read once, and kept while the structure of the world is the same."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Hashable
from typing import Any, Protocol, TypeVar

from virtualrobot.v1 import geometry_pb2

TRUSTED_SECONDS = 1.0
"""Longest time since a question whose answer told of the structure: after it a description is read again."""


class _Stamped(Protocol):
    @property
    def stamp(self) -> geometry_pb2.Stamp: ...


Description = TypeVar("Description", bound=_Stamped)


class Descriptions:
    """Answers that stay true while the structure's revision is the same.

    Every answer and every message of a watch has a stamp with that revision, and passes through `saw`. So what `get`
    returns is never older than anything that this client has been told, and never older than `TRUSTED_SECONDS`,
    whoever has changed the world.
    """

    def __init__(self) -> None:
        """Begin with none."""
        self._lock = threading.Lock()
        self._kept: dict[Hashable, Any] = {}
        self._newest = (0, 0)
        self._asked_at = -math.inf

    def saw(self, stamp: geometry_pb2.Stamp, asked_at: float = -math.inf) -> None:
        """Take notice of the structure that an answer tells of, to a question of the time `asked_at` (monotonic)."""
        revision = stamp.epoch, stamp.structure_revision
        with self._lock:
            if revision != self._newest:
                # A lower one is late; a kernel that was started again has a higher epoch.
                self._kept.clear()
                self._newest = max(self._newest, revision)
            self._asked_at = max(self._asked_at, asked_at)

    def get(self, key: Hashable, read: Callable[[], Description]) -> Description:
        """Return the description of this key: the one that is kept, or what `read` asks the kernel for."""
        with self._lock:
            if key in self._kept and time.monotonic() - self._asked_at < TRUSTED_SECONDS:
                return self._kept[key]
        answer = read()
        with self._lock:
            if (answer.stamp.epoch, answer.stamp.structure_revision) == self._newest:
                self._kept[key] = answer
        return answer
