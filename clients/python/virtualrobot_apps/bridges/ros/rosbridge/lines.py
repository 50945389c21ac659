"""The server of lines: operations of rosbridge as lines of JSON by plain TCP, for programs that have no WebSocket."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Mapping
from typing import Any

from virtualrobot_apps.bridges.ros.hub import Hub, HubError
from virtualrobot_apps.bridges.ros.rosbridge.session import Session
from virtualrobot_apps.bridges.ros.rosbridge.subscription import Subscription
from virtualrobot_apps.bridges.ros.rosbridge.wire import MOST_BYTES
from virtualrobot_apps.bridges.ros.transport import Transport, in_address, no_server

TEXTS = ("none", "png")


class LineServer(Transport):
    """Server of lines on one address; `url` is where it serves once it is open."""

    def __init__(self, host: str, port: int, *, token: str = "") -> None:
        """Serve nothing yet; a token is said by the operation `auth`, in the first line."""
        self._host, self._port, self._token = host, port, token
        self._server: asyncio.Server | None = None
        self._running: set[asyncio.Task[None]] = set()
        self.url = ""

    async def open(self, hub: Hub) -> str:
        """Serve a hub."""

        async def handle(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            task = asyncio.create_task(self._serve(hub, reader, writer))
            self._running.add(task)
            task.add_done_callback(self._running.discard)

        try:
            self._server = await asyncio.start_server(handle, self._host, self._port, limit=MOST_BYTES)
        except OSError as error:
            raise no_server("lines can't be served", self._host, self._port, error) from error
        self.url = f"tcp://{in_address(self._host)}:{self._server.sockets[0].getsockname()[1]}"
        return f"rosbridge by lines at {self.url}"

    async def close(self) -> None:
        """Cut all clients off."""
        if self._server is not None:
            self._server.close()
            for task in tuple(self._running):
                task.cancel()
            await asyncio.gather(*self._running, return_exceptions=True)

    async def _serve(self, hub: Hub, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            await _LineSession(hub, _LineConnection(reader, writer), self._token).run()
        except OSError:
            pass  # however it has ended, the session is over
        finally:
            writer.close()


class _LineConnection:
    """A client by TCP, a message in a line; what is no JSON ends it, so that no browser's request is read on."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Carry messages by a connection that is open."""
        self._reader, self._writer = reader, writer

    async def __aiter__(self) -> AsyncIterator[bytes]:
        try:
            while line := await self._line():
                if line.lstrip().startswith(b"{"):
                    yield line
                elif line.strip():
                    await self._refuse("a line is an object of JSON with an 'op'")
                    break
        except asyncio.LimitOverrunError:
            await self._refuse(f"a line has at most {MOST_BYTES} bytes")

    async def _line(self) -> bytes:
        """Return the next line; the last one may have no end, and nothing says that there is no other."""
        try:
            return await self._reader.readuntil()
        except asyncio.IncompleteReadError as end:
            return end.partial

    @property
    def is_free(self) -> bool:
        transport = self._writer.transport
        return not transport.is_closing() and transport.get_write_buffer_size() == 0

    def put(self, data: str | bytes, /) -> None:
        self._writer.write((data.encode() if isinstance(data, str) else data) + b"\n")

    async def send(self, data: str | bytes, /) -> None:
        self.put(data)
        await self._writer.drain()

    async def close(self, code: int, reason: str) -> None:
        await self._refuse(reason)
        self._writer.close()

    async def _refuse(self, words: str) -> None:
        await self.send(json.dumps({"op": "status", "level": "error", "msg": words}))


class _TextSubscription(Subscription):
    def __init__(self, topic: str, op: Mapping[str, Any], ready: Callable[[Subscription], None]) -> None:
        super().__init__(topic, op, ready)
        if (op.get("compression") or "none") not in TEXTS:
            raise HubError(f"'compression' of lines is one of {', '.join(TEXTS)}")


class _LineSession(Session):
    subscription = _TextSubscription
