"""Channels of messages: JSON behind a header with its length.

Source: Language Server Protocol 3.17, Base Protocol; messages of the Debug Adapter Protocol have the same header.
"""

from __future__ import annotations

import json
import os
import re
import socket
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any, BinaryIO, Protocol

import click

LONGEST = 64 * 1024 * 1024
"""Length (bytes) of the longest message that is read."""
_LONGEST_LINE = 1024


class ChannelError(Exception):
    """Bytes that are no message; the channel can't be read on."""


class Channel(Protocol):
    """Messages to and from an editor; any thread may send."""

    def read(self) -> Any | None:  # noqa: ANN401 JSON
        """Return the next message, or None at the end.

        Raises:
            ChannelError: where what comes is no message.
            ValueError: for a text that is no JSON; the next message can be read.
        """
        ...

    def send(self, message: dict[str, Any]) -> None:
        """Send a message; one that nobody reads any more is lost."""
        ...


class Streams:
    """Channel by streams of bytes."""

    def __init__(self, source: BinaryIO, sink: BinaryIO) -> None:
        """Read from one stream and write to another one."""
        self._source, self._sink = source, sink
        self._lock = threading.Lock()

    def read(self) -> Any | None:  # noqa: ANN401 JSON
        """Return the next message, or None at the end.

        Raises:
            ChannelError: where no header with a length comes.
            ValueError: for a text that is no JSON; the next message can be read.
        """
        length: int | None = None
        while True:
            line = self._source.readline(_LONGEST_LINE)
            if not line:
                return None
            if not line.strip():
                if length is not None:
                    break
                continue
            name, colon, value = line.decode("ascii", "replace").partition(":")
            if not colon or not line.endswith(b"\n"):
                raise ChannelError(f"a header as 'Content-Length: 100' is expected, not {line[:60]!r}")
            if name.strip().lower() == "content-length":
                if re.fullmatch(r"\d{1,12}", value.strip()) is None or int(value) > LONGEST:
                    raise ChannelError(f"the length of a message is 0 to {LONGEST}, not {value.strip()[:60]!r}")
                length = int(value)
        text = self._source.read(length)
        return None if len(text) < length else json.loads(text)

    def send(self, message: dict[str, Any]) -> None:
        """Send a message; one that nobody reads any more is lost."""
        text = json.dumps(message, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "replace")
        with self._lock, suppress(OSError, ValueError):
            self._sink.write(b"Content-Length: %d\r\n\r\n" % len(text) + text)
            self._sink.flush()


def serve(session: Callable[[Channel], int], port: int | None) -> int:
    """Serve an editor on the standard streams, or one after the other at a port of this machine; return the exit code.

    What else is written to the standard output goes to standard error meanwhile. Port 0 is one that is free; the first
    line on standard error tells it.
    """
    if port is None:
        source, sink = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
        os.dup2(2, 1)
        sys.stdout = sys.stderr
        code = 1
        with suppress(OSError), source, sink:
            code = session(Streams(source, sink))
        return code
    with socket.create_server(("127.0.0.1", port)) as server:
        click.echo(f"listening at 127.0.0.1:{server.getsockname()[1]}", err=True)
        while True:
            editor, _ = server.accept()
            editor.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            # An editor that has gone leaves what it didn't read.
            with suppress(OSError), editor, editor.makefile("rb") as source, editor.makefile("wb") as sink:
                session(Streams(source, sink))
