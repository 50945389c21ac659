"""Watches of the kernel that a hub follows, each on a thread of its own."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Generic, Protocol, TypeVar

from virtualrobot.errors import VirtualRobotError

_AGAIN_SECONDS = 1.0

Change = TypeVar("Change")
Told = TypeVar("Told", covariant=True)


class Watch(Protocol[Told]):
    """Changes as they come, until it is closed, which any thread may do."""

    def __iter__(self) -> Iterator[Told]:
        """Yield all that there is, then each change."""
        ...

    def close(self) -> None:
        """End it."""
        ...


class Following(Generic[Change]):
    """Watch that is followed until it is closed, and begun anew when it ends; a hub's loop opens and closes it."""

    def __init__(
        self,
        name: str,
        watch: Callable[[], Watch[Change]],
        take: Callable[[Change, bool], None],
        soon: Callable[..., None],
    ) -> None:
        """Follow nothing yet.

        Args:
            name: the thread's.
            watch: begins a watch; raises VirtualRobotError when the kernel has gone.
            take: hears each change, and whether it is the first one of a watch; the hub's loop calls it.
            soon: lets that loop call something from any thread.
        """
        self._name, self._begin, self._take, self._soon = name, watch, take, soon
        self._stop: threading.Event | None = None
        self._watch: Watch[Change] | None = None

    def open(self) -> None:
        """Follow it, unless it is followed."""
        if self._stop is None:
            self._stop = threading.Event()
            threading.Thread(target=self._run, args=(self._stop,), name=self._name, daemon=True).start()

    def close(self) -> None:
        """Follow it no more; nothing is taken from now on."""
        if self._stop is not None:
            self._stop.set()
            self._stop = None
        if self._watch is not None:
            self._watch.close()
            self._watch = None

    def _run(self, stop: threading.Event) -> None:
        while not stop.is_set():
            try:
                watch = self._begin()
                self._soon(self._began, stop, watch)
                for number, change in enumerate(watch):
                    self._soon(self._told, stop, change, number == 0)
            except VirtualRobotError:
                pass  # a kernel that has gone is said by others; it is tried again
            stop.wait(_AGAIN_SECONDS)

    def _began(self, stop: threading.Event, watch: Watch[Change]) -> None:
        if stop.is_set():
            watch.close()
        else:
            self._watch = watch

    def _told(self, stop: threading.Event, change: Change, is_first: bool) -> None:
        if not stop.is_set():
            self._take(change, is_first)
