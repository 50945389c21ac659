"""Backlog of a reader who wants all: what waits for him, in order; of what is too much the oldest is dropped."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")

MOST_BYTES = 256 * 1024 * 1024
"""Greatest size of what waits for one reader, as `size_of` tells it."""

MOST_ITEMS = 10_000
"""Greatest number of what waits for one reader: as many as a Step has ticks."""


class Backlog(Generic[T]):
    """Items that wait for one reader. One thread puts in and another takes out; neither waits for the other."""

    def __init__(self, size_of: Callable[[T], int], most_items: int = MOST_ITEMS, most_bytes: int = MOST_BYTES) -> None:
        """Begin empty; `size_of` tells about how many bytes an item keeps from being freed."""
        self._size_of = size_of
        self._most_items, self._most_bytes = most_items, most_bytes
        self._waiting: deque[tuple[T, int]] = deque()
        self._put_bytes = self._taken_bytes = self._dropped_bytes = 0

    def __len__(self) -> int:
        """Return how many wait."""
        return len(self._waiting)

    def put(self, item: T) -> None:
        """Add the newest; drop the oldest where too many wait, or too large ones."""
        size = self._size_of(item)
        self._waiting.append((item, size))
        self._put_bytes += size
        while len(self._waiting) > 1 and (len(self._waiting) > self._most_items or self._bytes > self._most_bytes):
            try:
                self._dropped_bytes += self._waiting.popleft()[1]
            except IndexError:  # its reader has just taken the rest
                break

    def take(self, most: int = MOST_ITEMS) -> list[T]:
        """Return what waits, the oldest first, at most so many."""
        taken: list[T] = []
        while len(taken) < most:
            try:
                item, size = self._waiting.popleft()
            except IndexError:
                break
            self._taken_bytes += size
            taken.append(item)
        return taken

    @property
    def _bytes(self) -> int:
        return self._put_bytes - self._taken_bytes - self._dropped_bytes
