"""Importers at work: the endings that they read, and files of foreign formats translated into native ones."""

from __future__ import annotations

import json
import threading
from collections import Counter, OrderedDict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from virtualrobot_sdk.answers import nonsense
from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.importers import NATIVE_FORMATS, Translation
from virtualrobot_sdk.models import Model
from virtualrobot_sdk.registration import ComponentKind

from virtualrobot_kernel.components.catalog import Catalog, Offer
from virtualrobot_kernel.components.running import ComponentHandle, start
from virtualrobot_kernel.errors import KernelError, Reason

KEPT_WITH_SETTINGS = 4
"""Number of importers with settings of their own that are kept; those without are all kept."""


class Importers:
    """Importers that have been asked for; any thread may ask.

    An importer is kept for the next file with the same settings. After a fault it is made anew for the next file,
    since one file says nothing about another.
    """

    def __init__(self, catalog: Catalog) -> None:
        """Take importers from this catalog."""
        self._catalog = catalog
        self._kept: OrderedDict[tuple[str, str], ComponentHandle] = OrderedDict()
        self._lenders: Counter[ComponentHandle] = Counter()
        self._lock = threading.Lock()
        self._closed = False

    @property
    def models(self) -> Mapping[str, Model]:
        """Return the models that are known by name, installed or not."""
        return self._catalog.models

    @property
    def endings(self) -> tuple[str, ...]:
        """Return the endings of the files that can be translated."""
        return tuple(self._by_ending())

    def translate(
        self, data: bytes, uri: str, files: Mapping[str, bytes | None], settings: Mapping[str, Any]
    ) -> Translation:
        """Return the file `uri` in a native format; `settings` are the importer's, as its schema has them.

        Raises:
            FilesNeeded: names files to call again with (see `virtualrobot_sdk.importers`).
            KernelError: with the importer's own words for a broken file; PLUGIN_FAILED when it raises, hangs, crashes
                or returns nonsense; INVALID_ARGUMENT when no importer reads this ending.
        """
        ending = uri[uri.rfind(".") :].lower()
        offers = self._by_ending()
        if ending not in offers:
            raise KernelError(f"{uri}: no importer reads {ending!r}; known: {', '.join(offers)}", file=uri)
        with self._lent(offers[ending], settings) as running:
            return _translated(running, data, uri, files)

    def uses(self) -> tuple[ComponentHandle, ...]:
        """Return the importers that have been asked for, those that failed last included."""
        with self._lock:
            return tuple(self._kept.values())

    def close(self) -> None:
        """End all importers; no other is started."""
        with self._lock:
            self._closed = True
            for running in self._kept.values():
                running.close()
            self._kept.clear()

    def _by_ending(self) -> dict[str, Offer]:
        offers = self._catalog.offers(ComponentKind.IMPORTER).values()
        return {ending: offer for offer in offers for ending in offer.about.endings}

    @contextmanager
    def _lent(self, offer: Offer, settings: Mapping[str, Any]) -> Iterator[ComponentHandle]:
        """Lend an importer; as long as anybody has it, it is not closed to make room for others."""
        key = offer.about.name, json.dumps(settings, sort_keys=True)
        with self._lock:
            if self._closed:
                raise KernelError("the kernel is ending", reason=Reason.SHUTTING_DOWN)
            running = self._usable(key, offer)
        if running is None:
            made = start(offer, settings)  # takes its time, so nobody waits for the lock meanwhile
            with self._lock:
                running = self._usable(key, offer)
                if running is None:
                    if key in self._kept:
                        self._kept[key].close()
                    running = self._kept[key] = made
                    self._lenders[made] += 1
            if running is not made:
                made.close()
        try:
            yield running
        finally:
            with self._lock:
                self._lenders[running] -= 1
                self._make_room()

    def _usable(self, key: tuple[str, str], offer: Offer) -> ComponentHandle | None:
        """Return a kept importer that is well and of this offer, lent from now on."""
        running = self._kept.get(key)
        if running is None or running.latest is not None or running.offer is not offer:
            return None
        self._kept.move_to_end(key)
        self._lenders[running] += 1
        return running

    def _make_room(self) -> None:
        with_settings = [key for key in self._kept if key[1] != "{}"]
        idle = [key for key in with_settings if not self._lenders[self._kept[key]]]
        for key in idle[: max(0, len(with_settings) - KEPT_WITH_SETTINGS)]:
            self._kept.pop(key).close()
        self._lenders = +self._lenders  # forgets those that nobody has


def _translated(running: ComponentHandle, data: bytes, uri: str, files: Mapping[str, bytes | None]) -> Translation:
    """Return what an importer makes of a file, once it is seen to be a Translation."""
    answer = running.call("translate", data, uri, dict(files))
    try:
        if not isinstance(answer, Translation):
            raise nonsense(f"translate returned a {type(answer).__name__}; it must be a Translation")
        if answer.format not in NATIVE_FORMATS or not isinstance(answer.data, bytes):
            valid = ", ".join(NATIVE_FORMATS)
            raise nonsense(f"translate returned {answer.format!r}; it must be bytes of one of {valid}")
    except ComponentFault as fault:
        raise running.failed(fault) from fault
    return answer
