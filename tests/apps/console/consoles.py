"""Consoles for tests: processes of the command, reached by HTTP and WebSockets as strangers would."""

from __future__ import annotations

import http.client
import json
import os
import re
import ssl
import struct
import subprocess
import sys
from collections import defaultdict, deque
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from websockets.sync.client import connect
from websockets.sync.connection import Connection

HEAD = struct.Struct(">IB")
BEGIN, MESSAGE, END, CANCEL = range(4)
PATIENCE_SECONDS = 120.0


@dataclass(frozen=True)
class Reply:
    """An answer in HTTP."""

    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:  # noqa: ANN401
        return json.loads(self.body)

    @property
    def reason(self) -> str:
        return self.json["details"][0]["debug"]["reason"]

    @property
    def metadata(self) -> dict[str, str]:
        return self.json["details"][0]["debug"]["metadata"]


@dataclass
class Console:
    """A console in a process of its own: where it is, and what it prints."""

    process: subprocess.Popen[str]
    link: str = ""
    tls: ssl.SSLContext | None = None
    """Authorities that are trusted; None for those of the system."""

    @property
    def port(self) -> int:
        return urlsplit(self.link).port or 0

    @property
    def url(self) -> str:
        return self.link.partition("/?key=")[0]

    def line(self) -> str:
        assert self.process.stdout
        return self.process.stdout.readline()

    @contextmanager
    def begun(
        self, path: str, body: bytes = b"{}", verb: str = "POST", **headers: str
    ) -> Iterator[http.client.HTTPResponse]:
        """Send a request and give the answer as it begins; at the end of the block the client is gone."""
        if self.link.startswith("https:"):
            connection = http.client.HTTPSConnection("127.0.0.1", self.port, timeout=PATIENCE_SECONDS, context=self.tls)
        else:
            connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE_SECONDS)
        said = {"content-type": "application/json"} | {name.replace("_", "-"): value for name, value in headers.items()}
        path = path if path.startswith("/") else f"/virtualrobot.v1.{path}"
        with closing(connection):
            connection.request(verb, path, body if verb == "POST" else None, said)
            with connection.getresponse() as response:
                yield response

    def ask(self, path: str, body: bytes | dict[str, Any] = b"{}", verb: str = "POST", **headers: str) -> Reply:
        """Send a request and return the whole answer."""
        said = json.dumps(body).encode() if isinstance(body, dict) else body
        with self.begun(path, said, verb, **headers) as response:
            return Reply(response.status, {n.lower(): v for n, v in response.getheaders()}, response.read())

    @contextmanager
    def page(self, **headers: str) -> Iterator[Page]:
        """Open the WebSocket of a page."""
        with connect(f"ws://127.0.0.1:{self.port}/calls", additional_headers=headers, max_size=None) as socket:
            yield Page(socket)

    def end(self) -> None:
        self.process.terminate()
        self.process.wait(PATIENCE_SECONDS)
        if self.process.stdout:
            self.process.stdout.close()


class Page:
    """All calls of a page, as JSON."""

    def __init__(self, socket: Connection) -> None:
        """Speak through a WebSocket that is open."""
        self.socket = socket
        self._count = 0
        self._kept: defaultdict[int, deque[tuple[int, Any]]] = defaultdict(deque)

    def put(self, number: int, kind: int, said: Any = None) -> None:  # noqa: ANN401
        self.socket.send(HEAD.pack(number, kind) + (b"" if said is None else json.dumps(said).encode()))

    def open(self, method: str, request: Any = None, **begin: Any) -> int:  # noqa: ANN401
        """Begin a call, send its first request where one is given, and return its number."""
        self._count += 1
        self.put(self._count, BEGIN, {"method": f"/virtualrobot.v1.{method}", "json": True, **begin})
        if request is not None:
            self.put(self._count, MESSAGE, request)
        return self._count

    def take(self) -> tuple[int, int, Any]:
        """Return the next frame: call, kind, what it says."""
        frame = self.socket.recv(PATIENCE_SECONDS)
        assert isinstance(frame, bytes)
        number, kind = HEAD.unpack_from(frame)
        return number, kind, json.loads(frame[HEAD.size :])

    def answers(self, number: int) -> Iterator[Any]:
        """Yield what a call is answered, to its end; frames of other calls are kept for these."""
        while True:
            if not self._kept[number]:
                of, kind, said = self.take()
                self._kept[of].append((kind, said))
                continue
            kind, said = self._kept[number].popleft()
            if kind != END:
                yield said
            elif "error" in said:
                raise PageRefused(said["error"])
            else:
                return

    def ask(self, method: str, request: Any = None, **begin: Any) -> Any:  # noqa: ANN401
        """Make a call with one answer."""
        (answer,) = self.answers(self.open(method, request or {}, **begin))
        return answer


class PageRefused(Exception):
    """A call of a page that was refused; its argument is Connect's error."""


@contextmanager
def consoles(address: str, *options: str, token: str = "") -> Iterator[Console]:
    """Give a console of the kernel at an address, on a free port."""
    command = [sys.executable, "-m", "virtualrobot", "console", "--address", address, "--port", "0", *options]
    environment = {**os.environ, "VIRTUALROBOT_TOKEN": token}
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment, bufsize=1
    )
    console = Console(process)
    try:
        said = console.line()
        found = re.match(r"console at (\S+/\?key=\S+)$", said)
        assert found, said + (process.stdout.read() if process.stdout else "")
        console.link = found[1]
        assert "good once" in console.line()
        yield console
    finally:
        console.end()
