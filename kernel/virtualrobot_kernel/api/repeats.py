"""Repeated calls: a client that has lost an answer asks again with the same `request_id`, and nothing is done twice."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Callable, Coroutine
from hashlib import sha256
from typing import Any, TypeVar

from virtualrobot_kernel.errors import KernelError

MOST_REMEMBERED = 1_000
LONGEST_ID = 200
"""Greatest length of a `request_id`, in characters."""

Answer = TypeVar("Answer")


class Repeats:
    """Answers of one servicer by `request_id`; used in the API's event loop alone."""

    def __init__(self) -> None:
        """Remember nothing yet."""
        self._calls: OrderedDict[str, tuple[bytes, asyncio.Task[Any]]] = OrderedDict()

    async def once(self, request: Any, work: Callable[[], Coroutine[Any, Any, Answer]]) -> Answer:  # noqa: ANN401 any message with a request_id
        """Return what `work` does, or what it did for an equal request of the same `request_id`.

        A call that fails is forgotten, so that it may be tried again; one that is under way goes on when its client is
        gone. Raises KernelError for an id that is too long, or that another request had.
        """
        id = request.request_id
        if not id:
            return await work()
        if len(id) > LONGEST_ID:
            raise KernelError(
                f"request_id may have {LONGEST_ID} characters, not {len(id)}", field="request_id", limit=LONGEST_ID
            )
        # A request may have megabytes; its digest is enough to tell it from another.
        digest = sha256(type(request).__name__.encode() + request.SerializeToString(deterministic=True)).digest()
        if id not in self._calls:
            self._calls[id] = digest, asyncio.ensure_future(work())
            self._calls[id][1].add_done_callback(lambda task: self._forget(id, task))
        first, task = self._calls[id]
        if first != digest:
            raise KernelError(
                f"request_id {id!r} belongs to another request; give each its own", field="request_id", value=id
            )
        return await asyncio.shield(task)

    def _forget(self, id: str, task: asyncio.Task[Any]) -> None:
        if task.cancelled() or task.exception() is not None:
            del self._calls[id]
        elif len(self._calls) > MOST_REMEMBERED:
            oldest = next(iter(self._calls))
            if self._calls[oldest][1].done():
                del self._calls[oldest]
