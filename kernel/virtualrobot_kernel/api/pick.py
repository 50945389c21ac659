"""ViewService.PickPixel: node and point under a pixel."""

from __future__ import annotations

import asyncio

from virtualrobot.v1 import view_pb2

from virtualrobot_kernel.api.convert.shots import pick_message, pixel_of
from virtualrobot_kernel.api.rooms import Rooms
from virtualrobot_kernel.drawing.renderer import Picked, Renderer


class PickCalls:
    """Calls of ViewService that pick."""

    _rooms: Rooms

    async def PickPixel(self, request: view_pb2.PickPixelRequest, context: object) -> view_pb2.PickPixelResponse:
        """Tell what is under a pixel of the world as it is now."""
        snapshot, settings = self._rooms.world.snapshot, self._rooms.view.get()
        shot, column, row = pixel_of(request, snapshot)

        def look(painter: Renderer) -> Picked | None:
            return painter.pick(snapshot, settings, shot, column, row)

        return pick_message(await asyncio.wrap_future(self._rooms.renderers.submit(look)), snapshot)
