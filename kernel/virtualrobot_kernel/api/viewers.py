"""People who stand in the cell with headsets: where their heads are, for one another.

They are not in the world: nothing of it depends on who looks. The API's thread alone reads and changes them.
"""

from __future__ import annotations

import asyncio
import itertools
import math
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from contextlib import aclosing, suppress

from virtualrobot.v1 import view_pb2

from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.values import pose, pose_message
from virtualrobot_kernel.world.listeners import Listeners

MOST = 64
"""Greatest number of heads at once: each is told to all others."""

PAUSE_SECONDS = 0.05
"""Shortest time between two messages to one of them."""

Requests = AsyncIterator[view_pb2.MeetViewersRequest]


class Viewers:
    """Heads of people by the streams that tell them; each goes with its stream."""

    def __init__(self) -> None:
        """Begin with nobody."""
        self._heads: dict[str, view_pb2.Viewer] = {}
        self._numbers = itertools.count(1)
        self._listeners: Listeners[object] = Listeners()

    async def meet(
        self, requests: Requests, name: str, publications: Publications
    ) -> AsyncGenerator[view_pb2.MeetViewersResponse, None]:
        """Yield the heads of the others, at once and when they move, and tell them that of `requests`.

        Raises KernelError for what is no head, and for one more than there may be.
        """
        id, told = f"viewer-{next(self._numbers)}", None
        reading = asyncio.create_task(self._read(requests, id, name))
        try:
            async with aclosing(publications.each(self._subscribe)) as woken:
                async for _ in woken:
                    if reading.done():
                        reading.result()  # raises what was wrong with it
                    others = [head for other, head in self._heads.items() if other != id]
                    if others != told:
                        yield view_pb2.MeetViewersResponse(viewers=others)
                        told = others
                        await asyncio.sleep(PAUSE_SECONDS)
        finally:
            reading.cancel()
            with suppress(asyncio.CancelledError, KernelError):
                await reading
            self._put(id, None)

    def _subscribe(self, listener: Callable[[object], None]) -> Callable[[], None]:
        return self._listeners.add(listener)

    async def _read(self, requests: Requests, id: str, name: str) -> None:
        """Take in where a head is, until its stream has ended; it is gone then."""
        try:
            async for request in requests:
                self._put(id, _head(request, id, name) if request.HasField("world_t_head") else None)
        finally:
            self._put(id, None)

    def _put(self, id: str, head: view_pb2.Viewer | None) -> None:
        if head is None:
            self._heads.pop(id, None)
        elif id not in self._heads and len(self._heads) >= MOST:
            raise KernelError(
                f"{MOST} people are in the room already, which is the most; wait until one has left",
                reason=Reason.TOO_LARGE,
                most=MOST,
            )
        else:
            self._heads[id] = head
        self._listeners.tell(None)


def _head(request: view_pb2.MeetViewersRequest, id: str, name: str) -> view_pb2.Viewer:
    scale = request.scale or 1.0
    if not (math.isfinite(scale) and scale > 0.0):
        raise KernelError(f"scale is {scale:g}; valid: above 0, such as 1", field="scale")
    world_t_head = pose_message(pose(request.world_t_head, "world_t_head"))
    return view_pb2.Viewer(id=id, name=name, world_t_head=world_t_head, scale=scale)
