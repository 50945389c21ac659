"""The contract over HTTP: each method is a POST to its path, written as its content type says."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, MutableMapping
from contextlib import aclosing
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from virtualrobot._wire.transport import LEASE_KEY, NAME_KEY

from virtualrobot_apps.console.contract import Method, methods
from virtualrobot_apps.console.door import Token
from virtualrobot_apps.console.refusal import Refusal
from virtualrobot_apps.console.upstream import Metadata, Upstream
from virtualrobot_apps.console.wires import CONTENT_TYPES, Limit, Wire, wire_of

Event = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Event]]
Send = Callable[[Event], Awaitable[None]]

PREFIX = "/virtualrobot.v1."
_UNITS = {"H": 3600.0, "M": 60.0, "S": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9}


@dataclass(frozen=True, slots=True)
class Caller:
    """Sender of a request.

    headers: of the request, names in lower case.
    token: that of the browser's session; None without one.
    place: the machine.
    """

    headers: dict[str, str]
    token: Token | None
    place: str

    def carried(self) -> str:
        """Return the token of its calls: one of its own goes before the session's; "" without one."""
        own = self.headers.get("authorization", "").removeprefix("Bearer ")
        return own or (self.token() if self.token else "")

    def metadata(self, more: Mapping[str, str] = MappingProxyType({})) -> Metadata:
        """Return the metadata of a call; a token of its own goes before the session's; `more` are its own headers."""
        headers = self.headers | dict(more)
        token = headers.get("authorization") or (f"Bearer {session}" if (session := self.carried()) else "")
        name = headers.get("client-name") or headers.get("user-agent", "").split("/")[0] or "web"
        said = f"{name:.120} on {self.place}".encode("ascii", "backslashreplace").decode()
        # Several leases are several headers, which HTTP may join.
        leases = filter(None, (lease.strip() for lease in headers.get(LEASE_KEY, "").split(",")))
        return (
            *([("authorization", token)] if token else []),
            (NAME_KEY, said),
            *((LEASE_KEY, lease) for lease in leases),
        )


def seconds_of(headers: dict[str, str]) -> float | None:
    """Return the deadline (s) that a request has by Connect's or gRPC's header; None: none."""
    try:
        if said := headers.get("connect-timeout-ms"):
            return max(0, int(said)) / 1000.0
        if said := headers.get("grpc-timeout"):
            return max(0, int(said[:-1])) * _UNITS[said[-1]]
    except (ValueError, KeyError):
        raise Refusal.of("INVALID_ARGUMENT", f"{said!r} is no time limit, such as 'connect-timeout-ms: 500'") from None
    return None


class HttpCalls:
    """Answers the calls of one upstream."""

    def __init__(self, upstream: Upstream, limit: Limit) -> None:
        """Pass calls with messages within the limit on."""
        self._upstream, self._limit = upstream, limit

    async def serve(self, path: str, verb: str, caller: Caller, receive: Receive, send: Send) -> None:
        """Make the call of one request; when the client has gone it is cancelled at the kernel."""
        try:
            method = _method(path, verb)
            wire = self._wire(method, caller.headers)
            seconds = seconds_of(caller.headers)
        except Refusal as refusal:
            await refuse(send, refusal)
            return
        body = _Body(receive)
        working = asyncio.create_task(self._answer(method, wire, body, caller.metadata(), seconds, send))
        leaving = asyncio.create_task(body.until_gone())
        try:
            await asyncio.wait({working, leaving}, return_when=asyncio.FIRST_COMPLETED)
            if working.done():
                working.result()
        finally:
            working.cancel()
            leaving.cancel()
            await asyncio.gather(working, leaving, return_exceptions=True)

    def _wire(self, method: Method, headers: dict[str, str]) -> Wire:
        content_type = headers.get("content-type", "")
        wire = wire_of(method, content_type, self._limit)
        if wire is None:
            known = ", ".join(CONTENT_TYPES)
            raise Refusal("unimplemented", f"no content type {content_type!r} for {method.path}: {known}", status=415)
        if headers.get("content-encoding", "identity") != "identity":
            raise Refusal("unimplemented", "bodies are not compressed here: leave content-encoding away", status=415)
        if wire.tells_by_status and headers.get("content-length", "").isdecimal():
            self._limit.check(int(headers["content-length"]))
        return wire

    async def _answer(
        self, method: Method, wire: Wire, body: _Body, metadata: Metadata, seconds: float | None, send: Send
    ) -> None:
        begun = not wire.tells_by_status
        if begun:
            await begin(send, 200, wire.content_type)
        refusal = None
        requests = wire.requests(body.chunks())
        try:
            async with aclosing(self._upstream.call(method, requests, metadata, seconds)) as answers:
                async for answer in answers:
                    if not begun:
                        await begin(send, 200, wire.content_type)
                        begun = True
                    if wire.is_json:
                        await answer.make_json()
                    await _send_body(send, wire.answer(answer), more=True)
        except Refusal as error:
            refusal = error
        if refusal is not None and not begun:
            await refuse(send, refusal)
            return
        if not begun:
            await begin(send, 200, wire.content_type)
        await _send_body(send, wire.end(refusal), more=False)


class _Body:
    """The body of a request, and whether who sent it is still there."""

    def __init__(self, receive: Receive) -> None:
        self._receive = receive
        self._read, self._gone = asyncio.Event(), False

    async def chunks(self) -> AsyncIterator[bytes]:
        more = True
        while more:
            event = await self._receive()
            if event["type"] == "http.disconnect":
                self._gone = True
                self._read.set()
                raise Refusal("canceled", "the client has gone")
            more = event.get("more_body", False)
            if event.get("body"):
                yield event["body"]
        self._read.set()

    async def until_gone(self) -> None:
        await self._read.wait()
        while not self._gone:
            self._gone = (await self._receive())["type"] == "http.disconnect"


async def begin(send: Send, status: int, content_type: str) -> None:
    """Send the head of an answer."""
    headers = [(b"content-type", content_type.encode()), (b"cache-control", b"no-store")]
    await send({"type": "http.response.start", "status": status, "headers": headers})


async def refuse(send: Send, refusal: Refusal) -> None:
    """Send a refusal as Connect's error."""
    await begin(send, refusal.status, "application/json")
    await _send_body(send, refusal.json() + b"\n", more=False)


async def _send_body(send: Send, data: bytes, more: bool) -> None:
    await send({"type": "http.response.body", "body": data, "more_body": more})


def _method(path: str, verb: str) -> Method:
    if (method := methods().get(path)) is None:
        raise Refusal("unimplemented", f"the contract has no method {path}", status=404)
    if verb != "POST":
        raise Refusal("unimplemented", f"methods are called by POST, not by {verb}", status=405)
    return method
