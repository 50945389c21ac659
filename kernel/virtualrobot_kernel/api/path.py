"""PathService: free paths, searched in a process of its own."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Mapping
from functools import partial
from typing import Any

from virtualrobot.v1 import path_pb2, path_pb2_grpc

from virtualrobot_kernel.api.convert.moves import point_goal
from virtualrobot_kernel.api.convert.paths import found_message, path_options
from virtualrobot_kernel.api.convert.tool_paths import found_tool_path, tool_path_asked
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.collision.allowed import may_touch
from virtualrobot_kernel.messages.collision_settings import pairs_of
from virtualrobot_kernel.messages.robots import group_selection
from virtualrobot_kernel.messages.values import by_name, stamp
from virtualrobot_kernel.paths.query import PathQuery, cleared, path_query, started_at
from virtualrobot_kernel.paths.tool_path import JOB as TOOL_JOB
from virtualrobot_kernel.paths.tool_query import tool_path_query
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
            there = cleared(started_at(snapshot, robot, start, group), robot, options.clearance)
            return there, path_query(there, robot.name, goal, self._kernel.solvers.of, options, group)

        there, query = await self._kernel.limiter.run([robot.uid], asked)
        async for elapsed, states, checks, found in self._searched(JOB, "states", there, query):
            response = path_pb2.FindPathResponse(
                stamp=stamp(snapshot), elapsed_seconds=elapsed, states=states, checks=checks
            )
            if found is not None:
                response.path.CopyFrom(found_message(query, found))
            yield response

    async def FindToolPath(
        self, request: path_pb2.FindToolPathRequest, context: object
    ) -> AsyncIterator[path_pb2.FindToolPathResponse]:
        """Look for a way along a tool path, and tell how far that is; a caller that goes ends it."""
        snapshot = self._kernel.world.snapshot
        robot = snapshot.structure.node(request.robot, Kind.ROBOT)
        asked = tool_path_asked(request)
        there = may_touch(snapshot, pairs_of(request.may_touch))

        query = await self._kernel.limiter.run([robot.uid], partial(tool_path_query, snapshot, robot.name, asked))
        async for elapsed, searches, checks, found in self._searched(TOOL_JOB, "searches", there, query):
            response = path_pb2.FindToolPathResponse(
                stamp=stamp(snapshot), elapsed_seconds=elapsed, searches=searches, checks=checks
            )
            if found is not None:
                response.path.CopyFrom(found_tool_path(query, found))
            yield response

    async def _searched(
        self, job: str, counted: str, snapshot: Snapshot, query: object
    ) -> AsyncIterator[tuple[float, int, int, Mapping[str, Any] | None]]:
        """Yield for how long a job has searched (s), what it has `counted`, its checks, and at last what it found."""
        newest, started = [(0, 0)], time.monotonic()

        def told(value: tuple[int, int]) -> None:
            newest[0] = value

        done = asyncio.wrap_future(self._kernel.processes.submit(job, snapshot, query, told=told))
        try:
            while not await self._kernel.publications.is_done(done):
                yield time.monotonic() - started, *newest[0], None
            found = done.result()
        finally:
            done.cancel()
        yield time.monotonic() - started, found[counted], found["checks"], found
