"""ViewService: settings of the picture, pictures and films, picks of pixels, and distances of points."""

from __future__ import annotations

from collections.abc import AsyncIterator

from virtualrobot.v1 import view_pb2, view_pb2_grpc

from virtualrobot_kernel.api.capture import CaptureCalls
from virtualrobot_kernel.api.convert.view import changed_settings, view_message
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.measure import MeasureCalls
from virtualrobot_kernel.api.pick import PickCalls
from virtualrobot_kernel.messages.values import stamp


class ViewServicer(CaptureCalls, MeasureCalls, PickCalls, view_pb2_grpc.ViewServiceServicer):
    """Servicer of ViewService; each group of its calls has a file of its own."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

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
