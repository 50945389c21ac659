"""CollisionService: collisions, distances, and the pairs that may touch."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Iterable
from itertools import islice

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import collision_pb2, collision_pb2_grpc

from virtualrobot_kernel.api.convert.collision_report import cost_message, report_message
from virtualrobot_kernel.api.convert.collisions import (
    DETAILS,
    allowed_messages,
    collision_message,
    configured,
    distance_message,
    mesh_messages,
    nodes_below,
)
from virtualrobot_kernel.api.convert.configurations import block_message, configuration_rows
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.keyed_limiter import IsGone
from virtualrobot_kernel.collision.allowed import may_touch
from virtualrobot_kernel.collision.configurations import CHECK_BLOCK
from virtualrobot_kernel.collision.sampling import Touched, sample_touches
from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.messages.collision_settings import pairs_of, settings_message
from virtualrobot_kernel.messages.values import not_negative, stamp
from virtualrobot_kernel.world.structure import Kind, Structure

TURN = "collision"
"""Key of the calls in the limiter: a few at a time have a thread."""

SAMPLES = 1000
MOST_SAMPLES = 100_000
BLOCK_ROWS = 256
"""Number of configurations that a process checks in one go: a few hundredths of a second."""

FEW_EVENTS = 8
"""Number of events that the API's thread tells itself; two nodes' contacts take up to a third of a millisecond."""


class CollisionServicer(collision_pb2_grpc.CollisionServiceServicer):
    """Servicer of CollisionService; each call borrows a scene of its own and sees the snapshot of its moment."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

    async def CheckCollision(
        self, request: collision_pb2.CheckCollisionRequest, context: object
    ) -> collision_pb2.CheckCollisionResponse:
        """Tell what touches, in a worker thread."""
        snapshot, detail = self._kernel.world.snapshot, DETAILS.read(request.detail, "detail")
        structure = snapshot.structure
        robots = _with_grippers(structure, request.robots)

        def work() -> collision_pb2.CheckCollisionResponse:
            placed = configured(snapshot, request.configurations)
            started = time.perf_counter()
            with self._kernel.collisions.scene() as scene:
                scene.place(placed)
                found = scene.collisions(detail, robots or None)
            seconds = time.perf_counter() - started
            return collision_pb2.CheckCollisionResponse(
                stamp=stamp(snapshot),
                pairs=[collision_message(structure, pair) for pair in found],
                check_seconds=seconds,
            )

        return await self._kernel.limiter.run([TURN], work)

    async def CheckConfigurations(
        self, request: collision_pb2.CheckConfigurationsRequest, context: object
    ) -> AsyncIterator[collision_pb2.CheckConfigurationsResponse]:
        """Check blocks of rows in collision processes, some at a time; a caller that goes ends it."""
        snapshot, processes = self._kernel.world.snapshot, self._kernel.processes
        structure = snapshot.structure
        robots = _with_grippers(structure, request.robots) or None
        there = may_touch(snapshot, pairs_of(request.may_touch))
        q_index, rows = await self._kernel.limiter.run(
            (), lambda: configuration_rows(structure, request.configurations)
        )
        yield collision_pb2.CheckConfigurationsResponse(stamp=stamp(snapshot), progress=0.0 if len(rows) else 1.0)
        starts, done = iter(range(0, len(rows), BLOCK_ROWS)), 0
        waiting: dict[asyncio.Future[NDArray[np.int64]], int] = {}
        try:
            while True:
                # Others' work has its turn after at most so many blocks, and no process waits for a block.
                for start in islice(starts, 2 * processes.count - len(waiting)):
                    block = q_index, rows[start : start + BLOCK_ROWS], robots
                    waiting[asyncio.wrap_future(processes.submit(CHECK_BLOCK, there, *block))] = start
                if not waiting:
                    break
                for one in (await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED))[0]:
                    start, found = waiting.pop(one), one.result()
                    done += len(found)
                    touching, pairs = block_message(structure, found)
                    yield collision_pb2.CheckConfigurationsResponse(
                        stamp=stamp(snapshot),
                        progress=done / len(rows),
                        first_row=start,
                        touching=touching,
                        pairs=pairs,
                    )
        finally:
            for one in waiting:
                one.cancel()

    async def MeasureDistances(
        self, request: collision_pb2.MeasureDistancesRequest, context: object
    ) -> collision_pb2.MeasureDistancesResponse:
        """Tell how far things are apart, in a worker thread."""
        snapshot = self._kernel.world.snapshot
        structure = snapshot.structure
        if not request.first:
            raise KernelError("first names no node; name at least one", field="first")
        range_meters = not_negative(request.range_meters, "range_meters")
        ours = nodes_below(structure, request.first)
        theirs = nodes_below(structure, request.second) if request.second else structure.nodes.keys() - ours

        def work() -> collision_pb2.MeasureDistancesResponse:
            placed = configured(snapshot, request.configurations)
            started = time.perf_counter()
            with self._kernel.collisions.scene() as scene:
                scene.place(placed)
                found = scene.distances(ours, theirs, range_meters)
            seconds = time.perf_counter() - started
            return collision_pb2.MeasureDistancesResponse(
                stamp=stamp(snapshot),
                pairs=[distance_message(structure, pair) for pair in found],
                measure_seconds=seconds,
            )

        return await self._kernel.limiter.run([TURN], work)

    async def ListAllowedPairs(
        self, request: collision_pb2.ListAllowedPairsRequest, context: object
    ) -> collision_pb2.ListAllowedPairsResponse:
        """Tell what may touch, in a worker thread."""
        snapshot = self._kernel.world.snapshot
        structure = snapshot.structure
        among = nodes_below(structure, request.nodes) or set(structure.nodes)

        def work() -> collision_pb2.ListAllowedPairsResponse:
            with self._kernel.collisions.scene() as scene:
                scene.place(snapshot)
                pairs = list(allowed_messages(structure, scene.bodies, among))
            return collision_pb2.ListAllowedPairsResponse(stamp=stamp(snapshot), pairs=pairs)

        return await self._kernel.limiter.run([TURN], work)

    async def ListCollisionMeshes(
        self, request: collision_pb2.ListCollisionMeshesRequest, context: object
    ) -> collision_pb2.ListCollisionMeshesResponse:
        """Tell what meshes collide as, in a worker thread."""
        snapshot = self._kernel.world.snapshot
        structure = snapshot.structure
        among = nodes_below(structure, request.nodes) or set(structure.nodes)

        def work() -> collision_pb2.ListCollisionMeshesResponse:
            meshes = list(mesh_messages(structure, self._kernel.collisions.shapes, among))
            return collision_pb2.ListCollisionMeshesResponse(stamp=stamp(snapshot), meshes=meshes)

        return await self._kernel.limiter.run([TURN], work)

    async def GetCollisionSettings(
        self, request: collision_pb2.GetCollisionSettingsRequest, context: object
    ) -> collision_pb2.GetCollisionSettingsResponse:
        """Tell what is done about collisions."""
        snapshot = self._kernel.world.snapshot
        cost = cost_message(self._kernel.guard.cost)
        return collision_pb2.GetCollisionSettingsResponse(
            stamp=stamp(snapshot), settings=settings_message(snapshot), guard_cost=cost
        )

    async def WatchCollisions(
        self, request: collision_pb2.WatchCollisionsRequest, context: object
    ) -> AsyncIterator[collision_pb2.WatchCollisionsResponse]:
        """Tell what the monitor finds: all at once, then what happens; a slow reader gets the latest."""
        monitor, told = self._kernel.monitor, None
        async for _ in self._kernel.publications.each(monitor.subscribe):
            report = monitor.latest
            if told is None or report.event_count - told > FEW_EVENTS:
                yield await self._kernel.in_worker(report_message, report, told)
            elif report.event_count > told:
                yield report_message(report, told)
            told = report.event_count

    async def FindAllowedPairs(
        self, request: collision_pb2.FindAllowedPairsRequest, context: object
    ) -> AsyncIterator[collision_pb2.FindAllowedPairsResponse]:
        """Try random configurations in a worker thread, and tell how far that is; a caller that goes ends it."""
        if request.samples > MOST_SAMPLES:
            raise LimitError(
                f"{request.samples} samples are too many; try at most {MOST_SAMPLES}",
                samples=request.samples,
                limit=MOST_SAMPLES,
            )
        snapshot, samples = self._kernel.world.snapshot, request.samples or SAMPLES
        structure = snapshot.structure
        _, robot = structure.robot(request.robot)
        done = [0]

        def work(is_gone: IsGone) -> Touched:
            def told(count: int) -> bool:
                done[0] = count
                return not is_gone()

            with self._kernel.collisions.scene() as scene:
                rng = np.random.default_rng(request.seed)
                return sample_touches(scene, snapshot, robot, samples, rng, told)

        task = asyncio.ensure_future(self._kernel.limiter.run_while_wanted([TURN], work))
        try:
            while not await self._kernel.publications.is_done(task):
                yield collision_pb2.FindAllowedPairsResponse(stamp=stamp(snapshot), progress=done[0] / samples)
            found = task.result()
        finally:
            task.cancel()
        yield collision_pb2.FindAllowedPairsResponse(
            stamp=stamp(snapshot),
            progress=1.0,
            samples=found.samples,
            pairs=[
                collision_pb2.SampledPair(
                    first=structure.nodes[pair[0]].name, second=structure.nodes[pair[1]].name, touched=count
                )
                for pair, count in sorted(found.counts.items(), key=lambda one: -one[1])
            ],
        )


def _with_grippers(structure: Structure, names: Iterable[str]) -> set[int]:
    """Return robots by name, and their grippers (uids); raise UnknownNameError."""
    robots = [structure.node(name, Kind.ROBOT).uid for name in names]
    return {*robots, *(gripper for robot in robots for gripper in structure.grippers_of(robot))}
