"""The kernel behind the console: any call by its path, in bytes; watches that many pages ask for are made once."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from contextlib import aclosing
from pathlib import Path
from typing import Any

import grpc
from virtualrobot._wire.transport import way_to
from virtualrobot.session import split_address
from virtualrobot.v1 import kernel_pb2

from virtualrobot_apps.console.contract import Answer, Method, methods
from virtualrobot_apps.console.refusal import Refusal

Metadata = tuple[tuple[str, str], ...]

INFO_SECONDS = 10.0
_GET_INFO = "/virtualrobot.v1.KernelService/GetInfo"

MOST_BEHIND = 8
"""Answers of a shared watch that wait for one page. A page that is further behind goes on with how everything is."""


class Upstream:
    """Calls to one kernel, whose token, lease and name each call brings itself."""

    def __init__(self, address: str, root_certificate: Path | None) -> None:
        """Prepare calls to the kernel at `address`; must be made where an event loop runs."""
        self._address = address
        options, credentials = way_to(split_address(address)[0], root_certificate)
        if credentials is None:
            self._channel = grpc.aio.insecure_channel(address, options)
        else:
            self._channel = grpc.aio.secure_channel(address, credentials, options)
        self._watches: dict[tuple[str, bytes, Metadata], SharedWatch] = {}

    @property
    def watch_count(self) -> int:
        """Number of shared watches that are open at the kernel."""
        return len(self._watches)

    async def call(
        self, method: Method, requests: AsyncIterator[bytes], metadata: Metadata, seconds: float | None = None
    ) -> AsyncGenerator[Answer, None]:
        """Make a call and yield its answers; closing the iterator cancels the call at the kernel.

        Args:
            method: which one.
            requests: encoded requests as they come; of a method with one request the first one counts.
            metadata: of the call.
            seconds: its deadline; None: none.

        Raises:
            Refusal: when the kernel refuses it, or can't be reached, or `requests` raises one.
        """
        request = requests if method.streams_requests else await anext(requests, b"")
        if isinstance(request, bytes) and seconds is None and method.is_shared(request):
            answers = self._share(method, request, metadata)
        else:
            answers = self._direct(method, request, metadata, seconds)
        try:
            async for answer in answers:
                yield answer
        except grpc.aio.AioRpcError as error:
            raise Refusal.of_kernel(error, self._address) from None
        finally:
            await answers.aclose()

    async def info(self, metadata: Metadata) -> kernel_pb2.GetInfoResponse:
        """Return what the kernel says of itself and of the token of `metadata`.

        Raises:
            Refusal: when it is refused, or the kernel can't be reached.
        """

        async def nothing() -> AsyncIterator[bytes]:
            yield b""

        found = kernel_pb2.GetInfoResponse()
        async with aclosing(self.call(methods()[_GET_INFO], nothing(), metadata, INFO_SECONDS)) as answers:
            async for answer in answers:
                found.ParseFromString(answer.data)
        return found

    async def close(self) -> None:
        """End all calls."""
        await self._channel.close()

    async def _direct(
        self, method: Method, request: bytes | AsyncIterator[bytes], metadata: Metadata, seconds: float | None
    ) -> AsyncGenerator[Answer, None]:
        refused: list[Refusal] = []

        async def send(requests: AsyncIterator[bytes]) -> None:
            try:
                async for one in requests:
                    await running.write(one)
                await running.done_writing()
            except Refusal as refusal:
                refused.append(refusal)
                running.cancel()
            except (grpc.aio.AioRpcError, asyncio.InvalidStateError):
                pass  # the call has ended, which its answers tell
            except Exception:
                running.cancel()
                raise

        arity = f"{_arity(method.streams_requests)}_{_arity(method.streams_answers)}"
        made = getattr(self._channel, arity)(method.path)
        first = [request] if isinstance(request, bytes) else []
        running: Any = made(*first, metadata=metadata, timeout=seconds)
        # Given an iterator, gRPC would go on waiting for its next request when the call has ended.
        sending = None if isinstance(request, bytes) else asyncio.create_task(send(request))
        try:
            if method.streams_answers:
                async for data in running:
                    yield Answer(method, data)
            else:
                yield Answer(method, await running)
        except (asyncio.CancelledError, grpc.aio.AioRpcError):
            if refused:
                raise refused[0] from None
            raise
        finally:
            running.cancel()
            if sending is not None:
                sending.cancel()
                await asyncio.gather(sending, return_exceptions=True)

    def _share(self, method: Method, request: bytes, metadata: Metadata) -> AsyncGenerator[Answer, None]:
        # What a page calls itself makes no other answers; its token may.
        token = tuple(entry for entry in metadata if entry[0] == "authorization")
        key = method.path, request, token
        if key not in self._watches:

            def ended(watch: SharedWatch) -> None:
                if self._watches.get(key) is watch:
                    del self._watches[key]

            self._watches[key] = SharedWatch(lambda: self._direct(method, request, metadata, None), ended)
        return self._watches[key].read()


class SharedWatch:
    """One watch at the kernel for all who ask for the same; it ends with its last reader.

    Who comes later, or is too slow, asks the kernel once how everything is and goes on with what is newer than that.
    """

    def __init__(self, begin: Callable[[], AsyncGenerator[Answer, None]], ended: Callable[[SharedWatch], None]) -> None:
        """Begin nothing yet: `begin` asks the kernel; `ended` is told when nobody may join any more."""
        self._begin, self._ended = begin, ended
        self._readers: set[_Reader] = set()
        self._reading: asyncio.Task[None] | None = None

    async def read(self) -> AsyncGenerator[Answer, None]:
        """Yield how everything is, then what changes."""
        reader = _Reader(behind=self._reading is not None)
        self._readers.add(reader)
        if self._reading is None:
            self._reading = asyncio.create_task(self._read_all())
        newest = (0, 0)
        try:
            while True:
                if reader.behind:
                    reader.catch_up()
                    whole = await self._whole()
                    newest = whole.moment
                    yield whole
                else:
                    answer = await reader.next()
                    if answer.moment >= newest:
                        yield answer
        except StopAsyncIteration:
            return
        finally:
            self._readers.discard(reader)
            if not self._readers:
                self._ended(self)
                self._reading.cancel()

    async def _read_all(self) -> None:
        answers = self._begin()
        end: BaseException = StopAsyncIteration()
        try:
            async for answer in answers:
                for reader in self._readers:
                    reader.put(answer)
        except Exception as error:
            end = error
        finally:
            self._ended(self)
            for reader in self._readers:
                reader.put_end(end)
            await answers.aclose()

    async def _whole(self) -> Answer:
        answers = self._begin()
        try:
            return await anext(answers)
        finally:
            await answers.aclose()


class _Reader:
    """Answers that wait for one reader of a shared watch."""

    def __init__(self, behind: bool) -> None:
        self.behind = behind
        self._waiting: deque[Answer] = deque()
        self._end: BaseException | None = None
        self._came = asyncio.Event()

    def put(self, answer: Answer) -> None:
        if len(self._waiting) >= MOST_BEHIND:
            self.behind = True
            self._waiting.clear()
        self._waiting.append(answer)
        self._came.set()

    def put_end(self, end: BaseException) -> None:
        self._end = end
        self._came.set()

    def catch_up(self) -> None:
        """Forget what waits: how everything is will be asked for."""
        self.behind = False
        self._waiting.clear()

    async def next(self) -> Answer:
        while not self._waiting:
            if self._end is not None:
                raise self._end
            self._came.clear()
            await self._came.wait()
        return self._waiting.popleft()


def _arity(streams: bool) -> str:
    return "stream" if streams else "unary"
