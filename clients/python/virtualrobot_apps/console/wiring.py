"""Connections between signals that the console runs for its pages, as `virtualrobot connections` runs those of a file.

They are the data of such a file. A change is checked as a whole before anything that runs is touched, and then all of
them begin anew; they go on without a page, until they are removed or the console ends.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from pathlib import Path
from threading import Event, Lock, Thread
from typing import Any

from virtualrobot import Client
from virtualrobot.errors import (
    InvalidArgumentError,
    MalformedFileError,
    TooLargeError,
    UnknownNameError,
    VirtualRobotError,
)

from virtualrobot_apps.cell_io.yaml_file import SCHEMA_VERSION, Item, parse, read_text
from virtualrobot_apps.connections.devices import fitted
from virtualrobot_apps.connections.file import FILE_FIELDS, ConnectionFile, connections_of
from virtualrobot_apps.connections.operators import OPERATORS
from virtualrobot_apps.connections.runner import Connections

Connect = Callable[[str], Client]
"""Gives a client of the kernel with a token."""

FIRST_NAME = "connections.yaml"
MOST_LETTERS = 1_000_000
"""Greatest length of a file."""
MOST_WORDS = 20
"""Lines that are kept of what running connections have said."""


class Wiring:
    """The connections of one console. Its methods wait for the kernel, so that they are called in threads."""

    def __init__(self, connect: Connect) -> None:
        """Run none yet."""
        self._connect = connect
        self._changing = Lock()
        self._name, self._data = FIRST_NAME, _empty()
        self._running: _Running | None = None
        self._said: deque[str] = deque(maxlen=MOST_WORDS)

    def state(self) -> dict[str, Any]:
        """Return what there is, as pages are told it: the file, whether it runs, what it has said."""
        running = self._running
        return {
            "name": self._name,
            "file": self._data,
            "running": running is not None and not running.ended,
            "fault": "" if running is None else running.fault,
            "said": list(self._said),
            "operators": [
                {
                    "name": name,
                    "about": made.about,
                    "inputs": made.inputs,
                    "optional": made.optional,
                    "settings": made.settings,
                }
                for name, made in OPERATORS.items()
            ],
        }

    def open_file(self, token: str, path: Path) -> None:
        """Run the connections of a file on this machine; raises as `open` does, or MissingFileError."""
        self.open(token, read_text(path), path.name)

    def open(self, token: str, text: str, name: str) -> None:
        """Run the connections of a file in place of those before.

        Raises TooLargeError, or MalformedFileError for what is no such file or does not fit, with its line; nothing
        has changed then.
        """
        if len(text) > MOST_LETTERS:
            raise TooLargeError(f"{name} has {len(text)} letters; a file of connections has at most {MOST_LETTERS}")
        root = parse(text, name)
        with self._changing:
            self._begin(token, connections_of(root), _plain(root), name)

    def set(self, token: str, target: str, source: Any) -> None:  # noqa: ANN401 any JSON
        """Have a signal driven, as a file says it, in place of what drove it before; raises as `open` does."""
        if not target:
            raise InvalidArgumentError("a connection needs the signal that it drives")
        with self._changing:
            connections = {**self._data.get("connections", {}), target: source}
            self._change(token, connections)

    def remove(self, token: str, target: str) -> None:
        """End the connection that drives a signal, which stays as it is; raise UnknownNameError where none does."""
        with self._changing:
            connections = dict(self._data.get("connections", {}))
            if connections.pop(target, None) is None:
                raise UnknownNameError(f"no connection of this console drives {target!r}")
            self._change(token, connections)

    def run(self, token: str) -> None:
        """Begin again with what there is."""
        with self._changing:
            self._change(token, self._data.get("connections", {}))

    def pause(self) -> None:
        """End what runs and keep it; signals stay as they are."""
        with self._changing:
            self._end()

    close = pause

    def _change(self, token: str, connections: Mapping[str, Any]) -> None:
        data = {**self._data, "connections": dict(connections)}
        try:
            file = connections_of(parse(json.dumps(data), self._name))
            self._begin(token, file, data, self._name)
        except MalformedFileError as error:
            # It has no lines that anybody has seen.
            raise MalformedFileError(str(error).partition(": ")[2], metadata=error.metadata) from None

    def _begin(self, token: str, file: ConnectionFile, data: dict[str, Any], name: str) -> None:
        with self._connect(token) as client:
            fitted(client, file, {one.name: one.value for one in client.signals.read()}, self._said.append)
        before = self._running
        self._end()
        self._said.clear()
        try:
            self._running = _Running(self._connect, token, file, self._said.append)
        except VirtualRobotError:
            if before is not None and not before.fault:
                self._running = _Running(self._connect, before.token, before.file, self._said.append)
            raise
        self._name, self._data = name, data

    def _end(self) -> None:
        if self._running is not None:
            self._running.end()
            self._running = None


class _Running:
    """Connections that run in a thread of their own; `fault` says why they have ended by themselves."""

    def __init__(self, connect: Connect, token: str, file: ConnectionFile, say: Callable[[str], None]) -> None:
        """Begin, and return when all that they drive is set; raises why that could not be."""
        self.token, self.file, self.fault = token, file, ""
        self._connect, self._say = connect, say
        self._ending, self._begun = Event(), Future[None]()
        self._thread = Thread(target=self._run, name="connections", daemon=True)
        self._thread.start()
        self._begun.result()

    @property
    def ended(self) -> bool:
        """True once nothing runs any more."""
        return not self._thread.is_alive()

    def end(self) -> None:
        """End and wait for it."""
        self._ending.set()
        self._thread.join()

    def _run(self) -> None:
        try:
            with self._connect(self.token) as client, Connections(client, self.file, self._say) as connections:
                self._begun.set_result(None)
                connections.run(self._ending.is_set)
        except Exception as error:  # told to who began them, or to pages
            self.fault = str(error) if isinstance(error, VirtualRobotError) else f"{type(error).__name__}: {error}"
            if not self._begun.done():
                self._begun.set_exception(error)


def _empty() -> dict[str, Any]:
    return {"schema_version": SCHEMA_VERSION, "connections": {}}


def _plain(item: Item) -> Any:  # noqa: ANN401 any JSON
    """Return what stands in a file as JSON has it; of the root its fields in the order in which files have them."""
    if item.is_list:
        return [_plain(one) for one in item.items()]
    if not item.is_mapping:
        return item.scalar()
    found = {name: _plain(one) for name, one in item.mapping().items()}
    if item.path:
        return found
    return {name: found[name] for name in FILE_FIELDS if name in found}
