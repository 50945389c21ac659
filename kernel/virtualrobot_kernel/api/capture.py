"""ViewService.CaptureImage and RecordFilm: pictures and films of the world, without a browser."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator
from contextlib import aclosing
from dataclasses import replace

from virtualrobot.v1 import view_pb2

from virtualrobot_kernel.api.convert.shots import film_of, picture_size, shot_of
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.model_pictures import ModelPictures
from virtualrobot_kernel.drawing.film import Film
from virtualrobot_kernel.drawing.framing import Framing
from virtualrobot_kernel.drawing.portrait import HEIGHT, WIDTH
from virtualrobot_kernel.drawing.renderer import Renderer, Sight
from virtualrobot_kernel.drawing.shots import Shot, packed
from virtualrobot_kernel.drawing.twin_ghosts import as_view_ghosts, twin_ghosts
from virtualrobot_kernel.messages.values import stamp
from virtualrobot_kernel.world.state import Snapshot


class CaptureCalls:
    """Calls of ViewService that take pictures."""

    _kernel: KernelServices
    _models: ModelPictures

    async def CaptureImage(
        self, request: view_pb2.CaptureImageRequest, context: object
    ) -> view_pb2.CaptureImageResponse:
        """Take a picture of the world as it is now."""
        snapshot = self._kernel.world.snapshot
        shot = shot_of(request.shot, snapshot.structure)
        image = await self._taken(self._sight(snapshot), shot, Framing())
        width, height = picture_size(shot, snapshot)
        return view_pb2.CaptureImageResponse(stamp=stamp(snapshot), image=image, width=width, height=height)

    async def CaptureModel(
        self, request: view_pb2.CaptureModelRequest, context: object
    ) -> view_pb2.CaptureModelResponse:
        """Return the picture of a known model, taken now where it wasn't before."""
        image = await self._models.get(request.name)
        return view_pb2.CaptureModelResponse(image=image, width=WIDTH, height=HEIGHT)

    async def RecordFilm(
        self, request: view_pb2.RecordFilmRequest, context: object
    ) -> AsyncIterator[view_pb2.RecordFilmResponse]:
        """Take a picture at each equal step of simulation time; what happens meanwhile is kept until it is drawn."""
        world = self._kernel.world
        shot = shot_of(request.shot, world.snapshot.structure)
        rate, count = film_of(request, world.snapshot)
        film, framing = Film(world, self._sight, rate, count), Framing()
        async with aclosing(self._kernel.publications.each(film.subscribe)) as wakings:
            async for _ in wakings:
                while (frame := film.take()) is not None:
                    image = await self._taken(frame.sight, shot, framing)
                    yield view_pb2.RecordFilmResponse(
                        stamp=stamp(frame.sight.snapshot), frame=frame.number, image=image, behind=film.behind
                    )
                if film.is_over:
                    return

    def _sight(self, snapshot: Snapshot) -> Sight:
        settings = self._kernel.view.get()
        if ghosts := twin_ghosts(snapshot, self._kernel.links.measured(snapshot)):
            settings = replace(settings, ghosts=(*settings.ghosts, *as_view_ghosts(ghosts)))
        return Sight(snapshot, settings, self._kernel.sensors.latest, self._kernel.monitor.latest.touching)

    async def _taken(self, sight: Sight, shot: Shot, framing: Framing) -> bytes:
        gone = threading.Event()

        def take(painter: Renderer) -> bytes:
            return packed(painter.paint(sight, shot, framing), shot.format, painter.check)

        try:
            return await asyncio.wrap_future(self._kernel.renderers.submit(take, gone.is_set))
        finally:
            gone.set()
