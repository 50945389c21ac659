"""Registry of listeners to events, called in the order in which they came."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from typing import Generic, ParamSpec

Told = ParamSpec("Told")

log = logging.getLogger(__name__)


class Listeners(Generic[Told]):
    """Functions that are called whenever something happens, the oldest first; any thread may add one.

    One that fails is logged and hurts no other. Whoever ends while all are told may be called once more.
    """

    def __init__(self) -> None:
        """Begin with nobody."""
        self._by_key: Mapping[object, Callable[Told, object]] = {}
        self._changing = threading.Lock()

    def __bool__(self) -> bool:
        """Return whether there is any."""
        return bool(self._by_key)

    def add(self, listener: Callable[Told, object]) -> Callable[[], None]:
        """Have `listener` called from now on; call what this returns to end that."""
        key = object()
        with self._changing:
            self._by_key = {**self._by_key, key: listener}

        def end() -> None:
            with self._changing:
                self._by_key = {other: kept for other, kept in self._by_key.items() if other is not key}

        return end

    def tell(self, *args: Told.args, **options: Told.kwargs) -> None:
        """Call all."""
        for listener in self._by_key.values():
            try:
                listener(*args, **options)
            except Exception:
                log.exception("a listener failed inside the kernel")
