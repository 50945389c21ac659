"""ViewService.PickPixel: node and point under a pixel."""

from __future__ import annotations

import asyncio

from virtualrobot.v1 import view_pb2

from virtualrobot_kernel.api.convert.shots import pick_message, pixel_of
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.drawing.renderer import Picked, Renderer


class PickCalls:
    """Calls of ViewService that pick."""

    _kernel: KernelServices

    async def PickPixel(self, request: view_pb2.PickPixelRequest, context: object) -> view_pb2.PickPixelResponse:
        """Tell what is under a pixel of the world as it is now."""
        snapshot, settings = self._kernel.world.snapshot, self._kernel.view.get()
        shot, column, row = pixel_of(request, snapshot)

        def look(painter: Renderer) -> Picked | None:
            return painter.pick(snapshot, settings, shot, column, row)

        return pick_message(await asyncio.wrap_future(self._kernel.renderers.submit(look)), snapshot)
