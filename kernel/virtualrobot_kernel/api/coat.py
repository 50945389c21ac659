"""ViewService's calls about coats: what a process leaves on nodes, in colours."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import aclosing

import numpy as np
from virtualrobot.v1 import view_pb2

from virtualrobot_kernel.api.convert.coats import changes, coat_of
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.sensing.coats import Coats, Shown

PERIOD = 0.1
"""Shortest time (s) from one message of a watch to the next one."""


class CoatCalls:
    """Calls of ViewService about coats."""

    _kernel: KernelServices

    @property
    def _coats(self) -> Coats:
        return self._kernel.sensing.looks.coats

    async def SetCoat(self, request: view_pb2.SetCoatRequest, context: object) -> view_pb2.SetCoatResponse:
        """Put a coat on a node."""
        structure = self._kernel.world.snapshot.structure
        coat = await self._kernel.in_worker(coat_of, request.coat, structure)
        self._coats.set(coat, structure.nodes.keys())
        return view_pb2.SetCoatResponse()

    async def PaintCoat(self, request: view_pb2.PaintCoatRequest, context: object) -> view_pb2.PaintCoatResponse:
        """Give a coat new values."""
        given = request.values
        self._coats.paint(given.name, given.first, np.frombuffer(given.values, np.uint8))
        return view_pb2.PaintCoatResponse()

    async def RemoveCoats(self, request: view_pb2.RemoveCoatsRequest, context: object) -> view_pb2.RemoveCoatsResponse:
        """Take coats away."""
        self._coats.remove(request.names)
        return view_pb2.RemoveCoatsResponse()

    async def WatchCoats(
        self, request: view_pb2.WatchCoatsRequest, context: object
    ) -> AsyncIterator[view_pb2.WatchCoatsResponse]:
        """Tell all coats, then what has changed; a slow reader gets the latest values."""
        told: Shown = {}
        is_first = True
        publications = self._kernel.publications
        async with aclosing(publications.each(self._coats.subscribe)) as wakings:
            async for _ in wakings:
                now = self._coats.get()
                response = changes(told, now, self._kernel.world.snapshot.structure)
                told = now
                if is_first or response.ByteSize():
                    is_first = False
                    yield response
                    await publications.pause(PERIOD)
