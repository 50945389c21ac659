"""Connections that carry the messages of a client of rosbridge, both ways: an interface, and WebSocket."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Protocol

from websockets.asyncio.connection import Connection as WebSocket
from websockets.asyncio.connection import broadcast
from websockets.protocol import State


class Connection(Protocol):
    """A client that is connected: its messages as they come, until it has gone."""

    def __aiter__(self) -> AsyncIterator[str | bytes]:
        """Return the client's messages."""
        ...

    @property
    def is_free(self) -> bool:
        """True where all that was sent has left."""
        ...

    def put(self, data: str | bytes, /) -> None:
        """Send a message while it is free, without waiting."""
        ...

    async def send(self, data: str | bytes, /) -> None:
        """Send a message; wait while too much has not left."""
        ...

    async def close(self, code: int, reason: str) -> None:
        """Cut the client off, and tell it why."""
        ...


class WebSocketConnection:
    """A client by WebSocket, a message in a frame of text or bytes."""

    def __init__(self, socket: WebSocket) -> None:
        """Carry messages by a socket that is open."""
        self._socket = socket
        self.send, self.close = socket.send, socket.close

    def __aiter__(self) -> AsyncIterator[str | bytes]:
        """Return the client's messages."""
        return self._socket.__aiter__()

    @property
    def is_free(self) -> bool:
        """True where it is open and all that was sent has left."""
        return self._socket.state is State.OPEN and self._socket.transport.get_write_buffer_size() == 0

    def put(self, data: str | bytes, /) -> None:
        """Send a message while it is free, without waiting."""
        broadcast((self._socket,), data)
