"""PathService: free paths, searched in a process of its own."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator

from virtualrobot.v1 import path_pb2, path_pb2_grpc

from virtualrobot_kernel.api.convert.moves import point_goal
from virtualrobot_kernel.api.convert.paths import found_message, path_options
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.messages.robots import group_selection
from virtualrobot_kernel.messages.values import by_name, stamp
from virtualrobot_kernel.paths.query import PathQuery, path_query, started_at
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

JOB = "virtualrobot_kernel.paths.find:find_path"


class PathServicer(path_pb2_grpc.PathServiceServicer):
    """Servicer of PathService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

    async def FindPath(
        self, request: path_pb2.FindPathRequest, context: object
    ) -> AsyncIterator[path_pb2.FindPathResponse]:
        """Look for a path, and tell how far that is; a caller that goes ends it."""
        snapshot = self._kernel.world.snapshot
        robot = snapshot.structure.node(request.robot, Kind.ROBOT)
        options, group = path_options(request), group_selection(request.group, "group")
        start = by_name(request.start.joint_positions, "start.joint_positions")
        goal = point_goal(request.goal, "goal")

        def asked() -> tuple[Snapshot, PathQuery]:
            there = started_at(snapshot, robot, start, group)
            return there, path_query(there, robot.name, goal, self._kernel.solvers.of, options, group)

        there, query = await self._kernel.limiter.run([robot.uid], asked)
        newest = [(0, 0)]

        def told(value: tuple[int, int]) -> None:
            newest[0] = value

        started = time.monotonic()

        def response(states: int, checks: int) -> path_pb2.FindPathResponse:
            elapsed = time.monotonic() - started
            return path_pb2.FindPathResponse(
                stamp=stamp(snapshot), elapsed_seconds=elapsed, states=states, checks=checks
            )

        done = asyncio.wrap_future(self._kernel.processes.submit(JOB, there, query, told=told))
        try:
            while not await self._kernel.publications.is_done(done):
                yield response(*newest[0])
            found = done.result()
        finally:
            done.cancel()
        last = response(found["states"], found["checks"])
        last.path.CopyFrom(found_message(query, found))
        yield last
