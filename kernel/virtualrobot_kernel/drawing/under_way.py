"""Work that somebody waits for, such as planning and loading: calls say what they do, and the page what takes long."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

AFTER_SECONDS = 0.5
"""Time from which on work is shown."""


class UnderWay:
    """Work that is under way; any thread may begin some, and any may ask for it."""

    def __init__(self) -> None:
        """Begin with none."""
        self._begun: dict[object, tuple[str, float]] = {}

    @contextmanager
    def doing(self, what: str) -> Iterator[None]:
        """Count this block as work, which `what` names."""
        key = object()
        self._begun[key] = what, time.monotonic()
        try:
            yield
        finally:
            del self._begun[key]

    def long(self) -> tuple[str, ...]:
        """Return what has been under way for `AFTER_SECONDS`, each name once, the oldest first."""
        before = time.monotonic() - AFTER_SECONDS
        # Copied as a whole, which no other thread comes between.
        return tuple(dict.fromkeys(what for what, began in tuple(self._begun.values()) if began <= before))
