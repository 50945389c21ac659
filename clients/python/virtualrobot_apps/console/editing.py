"""Editors of pages: for each page that asks a process with a language server and a debug adapter, by a WebSocket.

A text of the WebSocket is a message as `virtualrobot_apps.languages.editor.page` has them, `{"lsp": MESSAGE}` or
`{"dap": MESSAGE}`, each way. The process ends with the WebSocket, and so does the program that is debugged in it.
"""

from __future__ import annotations

import asyncio
import os
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

from virtualrobot.session import TOKEN_VARIABLE
from virtualrobot.v1 import token_pb2

from virtualrobot_apps.console.http_calls import Caller, Receive, Send
from virtualrobot_apps.console.refusal import Refusal
from virtualrobot_apps.console.upstream import Upstream
from virtualrobot_apps.console.wires import Limit

EDITOR = "/editor"
"""Path of the WebSockets."""
MOST_EDITORS = 16
"""Editors of all pages at a time: each is a process."""
END_SECONDS = 10.0
"""Time (s of the wall clock) in which a program brakes its robot and ends, when its page is gone; it is killed then."""
_REASON_BYTES = 123
"""Length of the longest reason of a WebSocket's end (RFC 6455, 5.5)."""
_MODULE = "virtualrobot_apps.languages.editor.page"


class PageEditors:
    """The editors of one console."""

    def __init__(self, upstream: Upstream, limit: Limit, address: str, certificate: Path | None) -> None:
        """Run programs on the kernel at an address, each with the token of its page."""
        self._upstream, self._limit = upstream, limit
        self._address, self._certificate = address, certificate
        self._count = 0

    async def run(self, caller: Caller, receive: Receive, send: Send) -> None:
        """Serve one page, by the events of a WebSocket that asks to be accepted, until it is gone."""
        await receive()
        await send({"type": "websocket.accept"})
        try:
            metadata = caller.metadata()
            role = (await self._upstream.info(metadata)).role
            if self._count >= MOST_EDITORS:
                raise Refusal("resource_exhausted", f"{MOST_EDITORS} pages edit programs already: close one of them")
        except Refusal as refusal:
            await _close(send, 1008, refusal.message)
            return
        token = dict(metadata).get("authorization", "").removeprefix("Bearer ")
        self._count += 1
        try:
            async with self._process(token, role) as process:
                await self._pass(process, receive, send)
        finally:
            self._count -= 1

    @asynccontextmanager
    async def _process(self, token: str, role: int) -> AsyncIterator[Process]:
        """Give the process of an editor; at the end of the block it ends, and is killed when it does not."""
        options = ["--address", self._address]
        if self._certificate is not None:
            options += ["--certificate", str(self._certificate)]
        if role < token_pb2.ROLE_OPERATOR:
            has = token_pb2.Role.Name(role).removeprefix("ROLE_").lower()
            options += [
                "--refusal",
                f"this needs the role operator, and the token is one of the role {has}",
            ]
        environment = {**os.environ, TOKEN_VARIABLE: token}
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", _MODULE, *options), stdin=PIPE, stdout=PIPE, env=environment
        )
        try:
            yield process
        finally:
            # The console may be about to end, which cancels this: the process goes on to its own end then.
            assert process.stdin is not None
            process.stdin.close()
            try:
                await asyncio.wait_for(process.wait(), END_SECONDS)
            except TimeoutError:
                process.kill()
                await process.wait()

    async def _pass(self, process: Process, receive: Receive, send: Send) -> None:
        """Pass messages on to the end of the page or of the process."""
        ends = [
            asyncio.create_task(self._from_page(process, receive, send)),
            asyncio.create_task(_to_page(process, send)),
        ]
        try:
            done, _ = await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
            for one in done:
                one.result()
        finally:
            for one in ends:
                one.cancel()
            await asyncio.gather(*ends, return_exceptions=True)

    async def _from_page(self, process: Process, receive: Receive, send: Send) -> None:
        assert process.stdin is not None
        while (event := await receive())["type"] != "websocket.disconnect":
            message = (event.get("text") or "").encode()
            try:
                self._limit.check(len(message))
            except Refusal as refusal:
                await _close(send, 1009, refusal.message)
                return
            with suppress(ConnectionError):  # it has ended, which its output tells
                process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(message) + message)
                await process.stdin.drain()


async def _to_page(process: Process, send: Send) -> None:
    assert process.stdout is not None
    try:
        while True:
            head = await process.stdout.readuntil(b"\r\n\r\n")
            text = await process.stdout.readexactly(int(head.partition(b":")[2]))
            await send({"type": "websocket.send", "text": text.decode()})
    except asyncio.IncompleteReadError:
        await _close(send, 1011, "the editor's process has ended: open the program again")
    except (OSError, RuntimeError):
        pass  # the page has just gone


async def _close(send: Send, code: int, reason: str) -> None:
    with suppress(OSError, RuntimeError):
        cut = reason.encode()[:_REASON_BYTES].decode("utf-8", "ignore")
        await send({"type": "websocket.close", "code": code, "reason": cut})
