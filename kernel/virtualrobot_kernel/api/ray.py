"""RayService: rays at a client's word, what is under a pixel, how far points are apart."""

from __future__ import annotations

from virtualrobot.v1 import ray_pb2_grpc

from virtualrobot_kernel.api.measure import MeasureCalls
from virtualrobot_kernel.api.pick import PickCalls
from virtualrobot_kernel.api.ray_casting import CastCalls
from virtualrobot_kernel.api.rooms import Rooms


class RayServicer(CastCalls, MeasureCalls, PickCalls, ray_pb2_grpc.RayServiceServicer):
    """Serves RayService; each group of its calls has a file of its own."""

    def __init__(self, rooms: Rooms) -> None:
        """Serve from these rooms."""
        self._rooms = rooms
