"""Orders of a task of asyncio, each done by a thread of its own meanwhile."""

from __future__ import annotations

import asyncio
import warnings
from collections.abc import Awaitable, Callable, Coroutine, Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from types import TracebackType
from typing import Any, Generic, TypeVar, cast

from virtualrobot._wire.interruptions import Interruption

Result = TypeVar("Result")
MOST_AT_ONCE = 1000
"""Largest number of orders of one client that are under way at once; others wait for their turn."""


class Workers:
    """Threads of one client, which do what its tasks order; as many as orders are under way."""

    def __init__(self) -> None:
        """Begin without a thread."""
        self._pool = ThreadPoolExecutor(MOST_AT_ONCE, thread_name_prefix="virtualrobot order")

    async def do(self, work: Callable[[], Result]) -> Result:
        """Return what `work` returns, done in a thread.

        A task that is cancelled takes it back as Ctrl-C does, and goes on when the thread has come to its end.
        """
        order = Interruption()
        done = asyncio.wrap_future(self._pool.submit(order.run, work))
        try:
            return await asyncio.shield(done)
        except asyncio.CancelledError:
            order.take_back()
            with suppress(BaseException):
                await asyncio.shield(done)
            raise


class Order(Coroutine[Any, Any, Result], Generic[Result]):
    """Order that has not been given yet: `await` gives it and returns its answer.

    Where the answer is a context manager, `async with` gives the order and enters it; where it is a sequence of
    states or events, `async for` reads it. It is a coroutine, so `asyncio.create_task` and task groups take it.
    """

    def __init__(self, give: Callable[[], Coroutine[Any, Any, Result]], name: str, *, is_told: bool = True) -> None:
        """Keep what gives it; `is_told`: whether one that is never given is warned about."""
        self._give, self._name, self._is_told = give, name, is_told
        self._given: Coroutine[Any, Any, Result] | None = None
        self._entered: Any = None

    @property
    def _running(self) -> Coroutine[Any, Any, Result]:
        if self._given is None:
            self._given = self._give()
        return self._given

    def send(self, value: Any) -> Any:  # noqa: ANN401 as coroutines have it
        """Go on, as a coroutine does."""
        return self._running.send(value)

    def throw(self, *error: Any) -> Any:  # noqa: ANN401
        """Raise an error where it waits, as a coroutine does."""
        return self._running.throw(*error)

    def close(self) -> None:
        """End it, as a coroutine does."""
        self._is_told = False
        if self._given is not None:
            self._given.close()

    def __await__(self) -> Generator[Any, Any, Result]:
        """Give the order and return its answer."""
        return self._running.__await__()

    async def __aenter__(self) -> Result:
        """Give the order and enter its answer."""
        self._entered = await self
        return cast("Result", await self._entered.__aenter__())

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool | None:
        """Leave the answer."""
        leave = cast("Callable[..., Awaitable[bool | None]]", self._entered.__aexit__)
        return await leave(kind, error, trace)

    def __aiter__(self) -> Reader:
        """Give the order and read its answer, one after the other."""
        return Reader(self)

    def __del__(self) -> None:
        """Warn of an order that was never given."""
        if self._given is None and self._is_told:
            warnings.warn(f"{self._name} was never awaited", RuntimeWarning, source=self, stacklevel=2)

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Order {self._name}: {'not given yet' if self._given is None else 'given'}>"


class Reader:
    """Reads what an order's answer tells, one after the other."""

    def __init__(self, order: Order[Any]) -> None:
        """Read the answer of an order, which is given at the first step."""
        self._order = order
        self._source: Any = None

    def __aiter__(self) -> Reader:
        """Return itself."""
        return self

    async def __anext__(self) -> Any:  # noqa: ANN401 whatever the answer has
        """Return the next one."""
        if self._source is None:
            self._source = (await self._order).__aiter__()
        return await self._source.__anext__()
