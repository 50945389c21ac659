"""XML-RPC in the hub's loop, both ends: what nodes and masters of ROS 1 ask each other."""

from __future__ import annotations

import asyncio
import xmlrpc.client
from collections.abc import Awaitable, Callable
from typing import Any, TypeAlias
from urllib.parse import urlsplit

Answer: TypeAlias = Callable[[str, tuple[Any, ...]], Awaitable[Any]]

MOST_BYTES = 8 << 20
"""Bytes of a call or an answer at most; descriptions of robots are the largest."""

_MOST_HEAD, _MOST_CONNECTIONS = 16 << 10, 256
_CALL_SECONDS, _IDLE_SECONDS = 10.0, 120.0


class XmlRpcError(OSError):
    """A call that nobody has answered, or that was refused; its text is for people."""


async def call(uri: str, method: str, *arguments: Any) -> Any:  # noqa: ANN401 whatever is asked and answered
    """Return what a method answers.

    Raises:
        XmlRpcError: when nobody answers within ten seconds, and for answers that are none or a fault.
    """
    place = urlsplit(uri)
    try:
        body = xmlrpc.client.dumps(arguments, method, allow_none=True).encode()
        host = place.hostname or ""
        head = f"POST {place.path or '/'} HTTP/1.0\r\nHost: {place.netloc}\r\nContent-Type: text/xml\r\n"
        async with asyncio.timeout(_CALL_SECONDS):
            reader, writer = await asyncio.open_connection(host, place.port or 80, limit=_MOST_HEAD)
            try:
                writer.write(f"{head}Content-Length: {len(body)}\r\n\r\n".encode() + body)
                await writer.drain()
                status, fields = await _head(reader)
                if status.split()[1:2] != ["200"]:
                    raise XmlRpcError(f"it answers {status[:60]!r}")
                # What answers as HTTP 1.0 may leave the length to the end of the connection.
                answer = await _body(reader, fields) if "content-length" in fields else await _rest(reader)
            finally:
                writer.close()
        return xmlrpc.client.loads(answer)[0][0]
    except TimeoutError as error:
        raise XmlRpcError(f"{uri[:80]} has not answered {method} after {_CALL_SECONDS:g} s") from error
    except xmlrpc.client.Fault as error:
        raise XmlRpcError(f"{uri[:80]} refuses {method}: {error.faultString[:200]}") from error
    except Exception as error:  # what is no XML raises a lot of kinds
        raise XmlRpcError(f"{uri[:80]} does not answer {method}: {error}") from error


class XmlRpcServer:
    """Server of XML-RPC; `answer` is called with the name of a method and its arguments.

    Attributes:
        uri: where it serves, once it is open.
    """

    def __init__(self, answer: Answer) -> None:
        """Serve nothing yet."""
        self._answer = answer
        self._connections: set[asyncio.Task[None]] = set()
        self.uri = ""

    async def open(self, host: str, port: int) -> None:
        """Serve; port 0 is any. Raises OSError when the address can't be had."""
        self._server = await asyncio.start_server(self._connected, host, port, limit=_MOST_HEAD)
        self.uri = f"http://{host}:{self._server.sockets[0].getsockname()[1]}/"

    async def close(self) -> None:
        """Cut all off."""
        self._server.close()
        for task in self._connections:
            task.cancel()
        await asyncio.gather(*self._connections, return_exceptions=True)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        try:
            if len(self._connections) < _MOST_CONNECTIONS:
                self._connections.add(task)
                async with asyncio.timeout(None) as due:
                    while await self._one(reader, writer, due):
                        pass
        except (OSError, EOFError, ValueError, TimeoutError, asyncio.LimitOverrunError):
            pass  # it has gone, or speaks something else
        finally:
            self._connections.discard(task)
            writer.close()

    async def _one(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, due: asyncio.Timeout) -> bool:
        """Answer one request; return whether more may come."""
        loop = asyncio.get_running_loop()
        due.reschedule(loop.time() + _IDLE_SECONDS)
        request, fields = await _head(reader)
        # A page in a browser says where it comes from; nothing else does, and no page has anything to do here.
        if not request.startswith("POST ") or "origin" in fields:
            writer.write(b"HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
            return False
        body = await _body(reader, fields)
        due.reschedule(None)
        answer = (await self._answered(body)).encode()
        stays = request.endswith("HTTP/1.1") and fields.get("connection", "").lower() != "close"
        head = "HTTP/1.1 200 OK\r\nContent-Type: text/xml\r\n" + ("" if stays else "Connection: close\r\n")
        writer.write(f"{head}Content-Length: {len(answer)}\r\n\r\n".encode() + answer)
        await writer.drain()
        return stays

    async def _answered(self, body: bytes) -> str:
        try:
            if b"<!" in body[:1000]:
                raise ValueError("documents with definitions are not read")
            arguments, method = xmlrpc.client.loads(body)
            answer = await self._answer(method or "", arguments)
            return xmlrpc.client.dumps((answer,), methodresponse=True, allow_none=True)
        except Exception as error:  # what is no XML raises a lot of kinds, and so do wrong arguments
            words = f"{type(error).__name__}: {error}"
            return xmlrpc.client.dumps(xmlrpc.client.Fault(1, words[:300]), methodresponse=True)


async def _head(reader: asyncio.StreamReader) -> tuple[str, dict[str, str]]:
    """Return the first line of a request or an answer, and its fields by their names in small letters."""
    lines = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")
    pairs = (one.partition(":") for one in lines[1:] if one)
    return lines[0], {key.strip().lower(): value.strip() for key, _, value in pairs}


async def _rest(reader: asyncio.StreamReader) -> bytes:
    found = b""
    while len(found) <= MOST_BYTES and (data := await reader.read(1 << 16)):
        found += data
    return found


async def _body(reader: asyncio.StreamReader, fields: dict[str, str]) -> bytes:
    size = int(fields.get("content-length", "-1"))
    if not 0 <= size <= MOST_BYTES:
        raise ValueError(f"{size} bytes; up to {MOST_BYTES} are read, and their number is said before")
    return await reader.readexactly(size)
