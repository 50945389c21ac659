"""RayService.Measure and WatchMeasure: how far points of nodes are apart."""

from __future__ import annotations

from collections.abc import AsyncIterator

from virtualrobot.v1 import ray_pb2

from virtualrobot_kernel.api.convert.view import node_point
from virtualrobot_kernel.api.rates import rate
from virtualrobot_kernel.api.rooms import Rooms
from virtualrobot_kernel.messages.values import stamp, vector_message
from virtualrobot_kernel.sensing.measuring import NodePoint, ends, length
from virtualrobot_kernel.world.state import Snapshot


class MeasureCalls:
    """The calls of RayService that measure."""

    _rooms: Rooms

    async def Measure(self, request: ray_pb2.MeasureRequest, context: object) -> ray_pb2.MeasureResponse:
        """Tell how far two points are apart now."""
        snapshot = self._rooms.world.snapshot
        return _measured(snapshot, *_points(request, snapshot))

    async def WatchMeasure(
        self, request: ray_pb2.WatchMeasureRequest, context: object
    ) -> AsyncIterator[ray_pb2.WatchMeasureResponse]:
        """Tell it now and whenever the world changes; a slow reader gets the latest."""
        points = _points(request, self._rooms.world.snapshot)
        async for snapshot in self._rooms.publications.snapshots(rate(request.max_rate_hertz)):
            yield ray_pb2.WatchMeasureResponse(measure=_measured(snapshot, *points))


def _points(
    request: ray_pb2.MeasureRequest | ray_pb2.WatchMeasureRequest, snapshot: Snapshot
) -> tuple[NodePoint, NodePoint]:
    structure = snapshot.structure
    return node_point(request.first, "first", structure), node_point(request.second, "second", structure)


def _measured(snapshot: Snapshot, first: NodePoint, second: NodePoint) -> ray_pb2.MeasureResponse:
    points = ends(snapshot, first, second)
    return ray_pb2.MeasureResponse(
        stamp=stamp(snapshot),
        distance_meters=length(points),
        first=vector_message(points[0].tolist()),
        second=vector_message(points[1].tolist()),
    )
