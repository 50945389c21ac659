"""ViewService: settings of the picture, pictures and films, picks of pixels, and distances of points."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import aclosing

from virtualrobot.v1 import view_pb2, view_pb2_grpc

from virtualrobot_kernel.api.author import person
from virtualrobot_kernel.api.capture import CaptureCalls
from virtualrobot_kernel.api.coat import CoatCalls
from virtualrobot_kernel.api.convert.shots import pick_message, pixel_of
from virtualrobot_kernel.api.convert.view import changed_settings, node_point, view_message
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.model_pictures import ModelPictures
from virtualrobot_kernel.api.viewers import Viewers
from virtualrobot_kernel.drawing.renderer import Picked, Renderer
from virtualrobot_kernel.messages.values import stamp, vector_message
from virtualrobot_kernel.sensing.measuring import NodePoint, ends, length
from virtualrobot_kernel.world.state import Snapshot


class ViewServicer(CaptureCalls, CoatCalls, view_pb2_grpc.ViewServiceServicer):
    """Servicer of ViewService; its calls that take pictures, and those about coats, are in files of their own."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel
        self._models = ModelPictures(kernel)
        self._viewers = Viewers()

    async def GetView(self, request: view_pb2.GetViewRequest, context: object) -> view_pb2.GetViewResponse:
        """Tell the set-up."""
        snapshot = self._kernel.world.snapshot
        view = view_message(self._kernel.view.get(), snapshot.structure)
        return view_pb2.GetViewResponse(stamp=stamp(snapshot), view=view, viewer_count=self._kernel.viewer_count())

    async def UpdateView(self, request: view_pb2.UpdateViewRequest, context: object) -> view_pb2.UpdateViewResponse:
        """Change the set-up."""
        snapshot = self._kernel.world.snapshot
        fields = changed_settings(request.view, request.update_mask, snapshot)
        view = view_message(self._kernel.view.update(**fields), snapshot.structure)
        return view_pb2.UpdateViewResponse(stamp=stamp(snapshot), view=view)

    async def WatchView(
        self, request: view_pb2.WatchViewRequest, context: object
    ) -> AsyncIterator[view_pb2.WatchViewResponse]:
        """Tell the set-up, then each change; a slow reader gets the latest."""
        async for _ in self._kernel.publications.each(self._kernel.view.subscribe):
            snapshot = self._kernel.world.snapshot
            view = view_message(self._kernel.view.get(), snapshot.structure)
            yield view_pb2.WatchViewResponse(stamp=stamp(snapshot), view=view)

    async def PickPixel(self, request: view_pb2.PickPixelRequest, context: object) -> view_pb2.PickPixelResponse:
        """Tell what is under a pixel of the world as it is now."""
        snapshot, settings = self._kernel.world.snapshot, self._kernel.view.get()
        shot, column, row = pixel_of(request, snapshot)

        def look(painter: Renderer) -> Picked | None:
            return painter.pick(snapshot, settings, shot, column, row)

        return pick_message(await asyncio.wrap_future(self._kernel.renderers.submit(look)), snapshot)

    async def MeasurePointDistance(
        self, request: view_pb2.MeasurePointDistanceRequest, context: object
    ) -> view_pb2.MeasurePointDistanceResponse:
        """Tell how far two points are apart now."""
        snapshot = self._kernel.world.snapshot
        distance = _distance(snapshot, *_points(request, snapshot))
        return view_pb2.MeasurePointDistanceResponse(stamp=stamp(snapshot), distance=distance)

    async def WatchPointDistance(
        self, request: view_pb2.WatchPointDistanceRequest, context: object
    ) -> AsyncIterator[view_pb2.WatchPointDistanceResponse]:
        """Tell it now and whenever the world changes; a slow reader gets the latest."""
        points = _points(request, self._kernel.world.snapshot)
        async for snapshot in self._kernel.publications.snapshots(request.max_rate_hertz):
            yield view_pb2.WatchPointDistanceResponse(stamp=stamp(snapshot), distance=_distance(snapshot, *points))

    async def MeetViewers(
        self, request_iterator: AsyncIterator[view_pb2.MeetViewersRequest], context: object
    ) -> AsyncIterator[view_pb2.MeetViewersResponse]:
        """Tell the heads of other people, and them that of this one."""
        async with aclosing(
            self._viewers.meet(request_iterator, person(context), self._kernel.publications)
        ) as responses:
            async for response in responses:
                yield response


def _points(
    request: view_pb2.MeasurePointDistanceRequest | view_pb2.WatchPointDistanceRequest, snapshot: Snapshot
) -> tuple[NodePoint, NodePoint]:
    structure = snapshot.structure
    return node_point(request.first, "first", structure), node_point(request.second, "second", structure)


def _distance(snapshot: Snapshot, first: NodePoint, second: NodePoint) -> view_pb2.PointDistance:
    points = ends(snapshot, first, second)
    return view_pb2.PointDistance(
        distance_meters=length(points),
        first=vector_message(points[0].tolist()),
        second=vector_message(points[1].tolist()),
    )
