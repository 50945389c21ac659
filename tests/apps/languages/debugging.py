"""Client of the Debug Adapter Protocol, written after the protocol's specification.

Each message, to and fro, is compared with the protocol's own JSON schema, which Microsoft's debugpy has with it.
"""

from __future__ import annotations

import json
import queue
import re
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from jsonschema import Draft4Validator

from tests.waiting import PATIENCE_SECONDS


class Failed(Exception):
    """A request that was refused."""


@cache
def schema(kind: str) -> Draft4Validator:
    """Return what validates messages of a kind, as StoppedEvent."""
    found = find_spec("debugpy")
    assert found is not None and found.submodule_search_locations
    folder = Path(found.submodule_search_locations[0]) / "_vendored/pydevd/_pydevd_bundle/_debug_adapter"
    definitions = json.loads((folder / "debugProtocol.json").read_text())["definitions"]
    assert kind in definitions
    return Draft4Validator({"$ref": f"#/definitions/{kind}", "definitions": definitions})


def kind_of(message: dict[str, Any]) -> str:
    """Return the name that the schema has for the kind of a message."""
    name = message["event"] if message["type"] == "event" else message["command"]
    if message["type"] == "response" and not message["success"]:
        return "ErrorResponse"
    return f"{name[0].upper()}{name[1:]}{message['type'].capitalize()}"


COMMAND = [sys.executable, "-m", "virtualrobot", "editor", "dap"]


@contextmanager
def adapters() -> Iterator[int]:
    """Give the port of a process that serves debug adapters."""
    process = subprocess.Popen([*COMMAND, "--port", "0"], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
    try:
        assert process.stderr is not None
        told = process.stderr.readline().decode()
        assert told.startswith("listening at 127.0.0.1:")
        yield int(told.rpartition(":")[2])
        process.stderr.close()
    finally:
        process.kill()
        process.wait()


@contextmanager
def editors(port: int) -> Iterator[Editor]:
    """Give an editor that is connected; what it has heard is compared with the schema at the end."""
    with socket.create_connection(("127.0.0.1", port), PATIENCE_SECONDS) as connection:
        with connection.makefile("rb") as source, connection.makefile("wb") as sink:
            editor = Editor(source, sink)
            yield editor
            with suppress(OSError, ValueError):
                connection.shutdown(socket.SHUT_RDWR)
    for message in editor.heard:
        schema(kind_of(message)).validate(message)


class Editor:
    """An editor's side of the protocol."""

    def __init__(self, source: Any, sink: Any) -> None:  # noqa: ANN401 binary streams
        """Speak by two streams."""
        self._source, self._sink = source, sink
        self._number = 0
        self.events: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
        self.lines: list[str] = []
        self.heard: list[dict[str, Any]] = []
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        with suppress(OSError, ValueError):
            while header := self._source.readline():
                length = re.fullmatch(rb"Content-Length: (\d+)\r\n", header)
                assert length is not None and self._source.readline() == b"\r\n"
                message = json.loads(self._source.read(int(length[1])))
                self.heard.append(message)
                if message["type"] == "response":
                    self._answers.put(message)
                elif message["event"] == "output":
                    self.lines.append(message["body"]["output"].rstrip("\n"))
                else:
                    self.events.put(message)
        self._answers.put(None)

    def send(self, text: bytes) -> None:
        """Send a message."""
        self._sink.write(b"Content-Length: %d\r\n\r\n" % len(text) + text)
        self._sink.flush()

    def ask(self, command: str, **arguments: Any) -> dict[str, Any]:  # noqa: ANN401 JSON
        """Return the body of the answer to a request; raises Failed for a refusal."""
        self._number += 1
        request = {"seq": self._number, "type": "request", "command": command, "arguments": arguments}
        self.send(json.dumps(request).encode())
        answer = self._answers.get(timeout=PATIENCE_SECONDS)
        assert answer is not None and (answer["command"], answer["request_seq"]) == (command, self._number)
        if not answer["success"]:
            assert answer["body"]["error"]["variables"]["told"] == answer["message"]
            raise Failed(answer["message"])
        schema(kind_of(request)).validate(request)
        return answer.get("body", {})

    def event(self, name: str) -> dict[str, Any]:
        """Return the body of the next event, which has a name."""
        found = self.events.get(timeout=PATIENCE_SECONDS)
        assert found["event"] == name, found
        return found.get("body", {})

    def launch(self, file: Path, *lines: int, **more: Any) -> list[dict[str, Any]]:  # noqa: ANN401 JSON
        """Begin a program with breakpoints, and return what became of these."""
        assert self.ask("initialize", adapterID="rapid")["supportsConditionalBreakpoints"]
        self.ask("launch", program=str(file), **more)
        self.event("initialized")
        found = self.breakpoints(file, *({"line": one} for one in lines))
        self.ask("configurationDone")
        return found

    def breakpoints(self, file: Path, *asked: dict[str, Any]) -> list[dict[str, Any]]:
        """Set breakpoints, and return what became of them."""
        return self.ask("setBreakpoints", source={"path": str(file)}, breakpoints=list(asked))["breakpoints"]

    def stack(self) -> list[tuple[str, int]]:
        """Return routines and lines of the call stack."""
        return [(one["name"], one["line"]) for one in self.ask("stackTrace", threadId=1)["stackFrames"]]

    def stops(self, reason: str) -> list[tuple[str, int]]:
        """Wait until the program stops for a reason, and return its call stack."""
        found = self.event("stopped")
        assert (found["reason"], found["threadId"]) == (reason, 1), found
        return self.stack()

    def step(self, command: str) -> list[tuple[str, int]]:
        """Make a step, and return the call stack after it."""
        self.ask(command, threadId=1)
        return self.stops("step")

    def scopes(self, frame: int = 0) -> dict[str, int]:
        """Return the numbers of the scopes of an entry of the call stack."""
        number = self.ask("stackTrace", threadId=1)["stackFrames"][frame]["id"]
        return {one["name"]: one["variablesReference"] for one in self.ask("scopes", frameId=number)["scopes"]}

    def variables(self, number: int) -> dict[str, str]:
        """Return the values of variables."""
        return {one["name"]: one["value"] for one in self.ask("variables", variablesReference=number)["variables"]}

    def value(self, expression: str, frame: int = 0) -> str:
        """Return the value of an expression in an entry of the call stack."""
        number = self.ask("stackTrace", threadId=1)["stackFrames"][frame]["id"]
        return self.ask("evaluate", expression=expression, frameId=number, context="watch")["result"]

    def ends(self, code: int = 0) -> list[str]:
        """Wait until the program has ended, and return what it has written."""
        assert self.event("exited") == {"exitCode": code}
        self.event("terminated")
        return self.lines
