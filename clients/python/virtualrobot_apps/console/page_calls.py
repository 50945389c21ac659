"""All calls of one page in one WebSocket: a browser keeps six connections to a host, which watches would take all.

A frame is the number of the call (four bytes, the first one the highest), a kind (one byte) and what it is about. From
the page: 0 begins a call and is JSON, `{"method": PATH, "json": true, "timeout_ms": 500}`, also with `headers`; 1 is a
request, encoded or, with `json`, JSON; 2 says that no request follows; 3 cancels. To the page: 1 is an answer; 2 is the
end and is JSON, `{}` or `{"error": ERROR}` as Connect says errors.
"""

from __future__ import annotations

import asyncio
import json
import struct
from collections.abc import AsyncIterator
from contextlib import aclosing, suppress

from virtualrobot_apps.console.contract import Method, methods
from virtualrobot_apps.console.http_calls import Caller, Receive, Send
from virtualrobot_apps.console.refusal import Refusal, end_of
from virtualrobot_apps.console.upstream import Metadata, Upstream
from virtualrobot_apps.console.wires import Limit

HEAD = struct.Struct(">IB")
BEGIN, MESSAGE, END, CANCEL = range(4)
MOST_CALLS = 256
"""Calls of one page at a time."""


class PageCalls:
    """The calls of one page; when it is gone they are cancelled at the kernel."""

    def __init__(self, upstream: Upstream, limit: Limit, caller: Caller, receive: Receive, send: Send) -> None:
        """Answer `caller` by the events of a WebSocket that asks to be accepted."""
        self._upstream, self._limit, self._caller = upstream, limit, caller
        self._receive, self._send_event = receive, send
        self._calls: dict[int, _Call] = {}
        self._sending = asyncio.Lock()

    async def run(self) -> None:
        """Answer until the page is gone."""
        await self._receive()
        await self._send_event({"type": "websocket.accept"})
        try:
            while (event := await self._receive())["type"] != "websocket.disconnect":
                frame = event.get("bytes") or b""
                if len(frame) < HEAD.size:
                    reason = "frames are bytes: call, kind, data"
                    await self._send_event({"type": "websocket.close", "code": 1003, "reason": reason})
                    return
                number, kind = HEAD.unpack_from(frame)
                await self._take(number, kind, frame[HEAD.size :])
        finally:
            tasks = [call.task for call in self._calls.values()]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _take(self, number: int, kind: int, data: bytes) -> None:
        call = self._calls.get(number)
        if kind == BEGIN and call is None:
            try:
                self._begin(number, data)
            except Refusal as refusal:
                await self._send(number, END, end_of(refusal))
        elif call is None:
            return  # it has ended meanwhile
        elif kind == CANCEL:
            call.task.cancel()
        elif kind == END:
            call.requests.put_nowait(None)
        elif kind == MESSAGE:
            call.take(data, self._limit)
        else:
            words = f"call {number} has begun already, or no frame has the kind {kind}"
            call.requests.put_nowait(Refusal.of("INVALID_ARGUMENT", words))

    def _begin(self, number: int, data: bytes) -> None:
        try:
            said = json.loads(data)
            method = methods().get(said["method"])
            headers = {str(name).lower(): str(value) for name, value in said.get("headers", {}).items()}
            timeout = said.get("timeout_ms")
            seconds = None if timeout is None else max(0.0, float(timeout)) / 1000.0
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            words = 'a call begins with JSON such as {"method": "/virtualrobot.v1.MotionService/Stop", "json": true}'
            raise Refusal.of("INVALID_ARGUMENT", words) from None
        if method is None:
            raise Refusal("unimplemented", f"the contract has no method {said['method']}")
        if len(self._calls) >= MOST_CALLS:
            metadata = {"limit_name": "calls_of_a_page", "limit": str(MOST_CALLS), "asked": str(MOST_CALLS + 1)}
            words = f"a page may have {MOST_CALLS} calls at a time: cancel one"
            raise Refusal.of("TOO_MANY_CALLS", words, metadata)
        call = _Call(method, bool(said.get("json")))
        metadata = self._caller.metadata(headers)
        call.task = asyncio.create_task(self._answer(number, call, metadata, seconds))
        self._calls[number] = call

    async def _answer(self, number: int, call: _Call, metadata: Metadata, seconds: float | None) -> None:
        refused = None
        try:
            answers = self._upstream.call(call.method, call.encoded_requests(), metadata, seconds)
            async with aclosing(answers):
                async for answer in answers:
                    if call.is_json:
                        await answer.make_json()
                    await self._send(number, MESSAGE, answer.json if call.is_json else answer.data)
        except Refusal as refusal:
            refused = refusal
        except asyncio.CancelledError:
            refused = Refusal("canceled", "the page has cancelled the call")
        finally:
            del self._calls[number]
        await self._send(number, END, end_of(refused))

    async def _send(self, number: int, kind: int, data: bytes) -> None:
        async with self._sending:
            # A page that has just gone is told of by the next event, which ends all of its calls.
            with suppress(OSError, RuntimeError):
                await self._send_event({"type": "websocket.send", "bytes": HEAD.pack(number, kind) + data})


class _Call:
    """A call of a page: its task, and its requests that the kernel has not taken yet."""

    task: asyncio.Task[None]

    def __init__(self, method: Method, is_json: bool) -> None:
        self.method, self.is_json = method, is_json
        self.requests: asyncio.Queue[bytes | Refusal | None] = asyncio.Queue()
        self._waiting_bytes = 0

    def take(self, data: bytes, limit: Limit) -> None:
        """Keep a request until it is the kernel's turn; who sends without end loses the call and not the kernel."""
        try:
            limit.check(len(data))
            self._waiting_bytes += len(data)
            limit.check(self._waiting_bytes)
        except Refusal as refusal:
            self.requests.put_nowait(refusal)
        else:
            self.requests.put_nowait(data)

    async def encoded_requests(self) -> AsyncIterator[bytes]:
        """Yield the requests as the kernel takes them."""
        while (data := await self.requests.get()) is not None:
            if isinstance(data, Refusal):
                raise data
            self._waiting_bytes -= len(data)
            yield await self.method.read_json(data) if self.is_json else data
