"""ViewService.MeasurePointDistance and WatchPointDistance: distances of points of nodes."""

from __future__ import annotations

from collections.abc import AsyncIterator

from virtualrobot.v1 import view_pb2

from virtualrobot_kernel.api.convert.view import node_point
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.rates import rate
from virtualrobot_kernel.messages.values import stamp, vector_message
from virtualrobot_kernel.sensing.measuring import NodePoint, ends, length
from virtualrobot_kernel.world.state import Snapshot


class MeasureCalls:
    """Calls of ViewService that measure."""

    _kernel: KernelServices

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
        async for snapshot in self._kernel.publications.snapshots(rate(request.max_rate_hertz)):
            yield view_pb2.WatchPointDistanceResponse(stamp=stamp(snapshot), distance=_distance(snapshot, *points))


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
