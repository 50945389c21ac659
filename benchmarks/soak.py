"""A hundred clients at one kernel for long: what grows, what is left behind, and whether time keeps up.

Sixty watch robots, fifteen read, fifteen edit and undo, and ten lease an arm each and move it. Each stays for half a
minute and comes again on another connection; every third vanishes without a word. `python -m benchmarks.soak 60` takes
an hour.
"""

from __future__ import annotations

import asyncio
import random
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from statistics import mean

import grpc
import psutil
from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot.v1 import (
    geometry_pb2,
    history_pb2,
    history_pb2_grpc,
    kernel_pb2,
    kernel_pb2_grpc,
    lease_pb2,
    lease_pb2_grpc,
    motion_pb2,
    motion_pb2_grpc,
    nodes_pb2,
    robot_pb2,
    robot_pb2_grpc,
    scene_pb2,
    scene_pb2_grpc,
)

from benchmarks.processes import kernel
from benchmarks.rows import Row, row

MINUTES = 3.0
"""Length that `make bench` has time for."""

IIWA = "package://pybullet_data/kuka_iiwa/model.urdf"
ARMS = 10
STAY_SECONDS = 30.0
WATCH_SECONDS = 4.0
SAMPLE_SECONDS = 5.0
OPTIONS = [("grpc.use_local_subchannel_pool", 1)]
"""Options of a connection of its own for each client, as those of other processes have."""

REFUSED = (
    *(grpc.StatusCode.NOT_FOUND, grpc.StatusCode.PERMISSION_DENIED, grpc.StatusCode.ABORTED),
    *(grpc.StatusCode.FAILED_PRECONDITION, grpc.StatusCode.OUT_OF_RANGE, grpc.StatusCode.CANCELLED),
)
"""Codes by which clients are refused that come in each other's way; others end the soak."""

Doing = Callable[[grpc.aio.Channel, int], Awaitable[None]]


@dataclass(frozen=True, slots=True)
class Sample:
    """A kernel at a time (s): its memory (MB), threads and descriptors, and its simulation time (s)."""

    seconds: float
    megabytes: float
    threads: int
    descriptors: int
    simulated: float


@dataclass(frozen=True, slots=True)
class Soak:
    """Result of a soak: before the clients, each few seconds with them, and after they have gone; calls answered."""

    before: Sample
    during: tuple[Sample, ...]
    after: Sample
    calls: int

    @property
    def factor(self) -> float:
        """Real-time factor: simulation time for each second of the wall clock."""
        first, last = self.during[0], self.during[-1]
        return (last.simulated - first.simulated) / (last.seconds - first.seconds)

    def megabytes(self, quarter: int) -> float:
        """Return the mean memory in a quarter (0 to 3) of the soak (MB)."""
        size = max(1, len(self.during) // 4)
        return mean(one.megabytes for one in self.during[quarter * size : (quarter + 1) * size])


def soaked(minutes: float, seed: int = 0) -> Soak:
    """Return how a kernel with a project folder is before, while and after a hundred clients use it for so long."""
    with (
        tempfile.TemporaryDirectory() as folder,
        kernel("--headless", "--data", f"{folder}/soak") as (address, process),
    ):
        return asyncio.run(_soaked(address, psutil.Process(process.pid), 60.0 * minutes, random.Random(seed)))


async def _soaked(address: str, process: psutil.Process, seconds: float, rng: random.Random) -> Soak:
    calls = count()
    async with grpc.aio.insecure_channel(address, OPTIONS) as own:
        scene = scene_pb2_grpc.SceneServiceStub(own)
        for place in range(ARMS):
            at = geometry_pb2.Pose(position=geometry_pb2.Vector3(x=2.0 * place))
            model = scene_pb2.ModelSource(uri=IIWA, name=f"arm{place}", parent_t_node=at)
            await scene.ImportModel(scene_pb2.ImportModelRequest(model=model))
        # Everybody once: what the first call of a kind makes stays, and is no growth.
        await _crowd(address, time.monotonic() + 20.0, rng, calls)
        before = await _settled(own, process, 10.0)
        crowd = asyncio.create_task(_crowd(address, time.monotonic() + seconds, rng, calls))
        during: list[Sample] = []
        while not crowd.done():
            await asyncio.wait([crowd], timeout=SAMPLE_SECONDS)
            during.append(await _sample(own, process))
        await crowd
        return Soak(before, tuple(during[:-1]), await _settled(own, process, 60.0), next(calls))


async def _crowd(address: str, until: float, rng: random.Random, calls: count[int]) -> None:
    """Let a hundred clients come and go until a time."""
    doings = [_watch] * 60 + [_read] * 15 + [_edit] * 15 + [_move] * ARMS
    async with asyncio.TaskGroup() as clients:
        for place, doing in enumerate(doings):
            clients.create_task(_client(address, doing, place, until, random.Random(rng.random()), calls))


async def _client(address: str, doing: Doing, place: int, until: float, rng: random.Random, calls: count[int]) -> None:
    """Come again and again, and stay for a while."""
    while (left := until - time.monotonic()) > 0.0:
        channel = grpc.aio.insecure_channel(address, OPTIONS)
        leave = time.monotonic() + min(left, rng.uniform(0.5, 1.5) * STAY_SECONDS)
        try:
            while time.monotonic() < leave:
                try:
                    await doing(channel, place)
                except grpc.aio.AioRpcError as error:
                    if error.code() not in REFUSED:
                        raise
                next(calls)
                await asyncio.sleep(rng.uniform(0.2, 1.0))
        finally:
            if rng.random() < 0.33:
                with suppress(asyncio.CancelledError):
                    await channel.close(0.0)
            else:
                await channel.close(1.0)


async def _watch(channel: grpc.aio.Channel, place: int) -> None:
    """Watch all robots for some seconds."""
    request = robot_pb2.WatchRobotStatesRequest(max_rate_hertz=2.0)
    watch = robot_pb2_grpc.RobotServiceStub(channel).WatchRobotStates(request, timeout=WATCH_SECONDS)
    with suppress(asyncio.TimeoutError):
        async with asyncio.timeout(0.9 * WATCH_SECONDS):  # where no robot moves nothing is told
            async for _ in watch:
                pass
    watch.cancel()


async def _read(channel: grpc.aio.Channel, place: int) -> None:
    """Read a robot's state, all names, and the newest steps."""
    await robot_pb2_grpc.RobotServiceStub(channel).GetRobotStates(robot_pb2.GetRobotStatesRequest(names=["arm0"]))
    mask = FieldMask(paths=["name"])
    await scene_pb2_grpc.SceneServiceStub(channel).GetScene(scene_pb2.GetSceneRequest(read_mask=mask))
    await history_pb2_grpc.HistoryServiceStub(channel).ListSteps(history_pb2.ListStepsRequest(page_size=10))


async def _edit(channel: grpc.aio.Channel, place: int) -> None:
    """Create a box, move it, undo that, and remove the box."""
    scene, history = scene_pb2_grpc.SceneServiceStub(channel), history_pb2_grpc.HistoryServiceStub(channel)
    name = f"box of {place}"
    size = geometry_pb2.Vector3(x=0.1, y=0.1, z=0.1)
    box = nodes_pb2.Figure(box=nodes_pb2.Box(size=size))
    away = geometry_pb2.Pose(position=geometry_pb2.Vector3(y=-5.0 - place))
    node = nodes_pb2.Node(name=name, object=nodes_pb2.SceneObject(), figures=[box], parent_t_node=away)
    moved = nodes_pb2.Node(parent_t_node=geometry_pb2.Pose(position=geometry_pb2.Vector3(y=-6.0 - place)))
    change = scene_pb2.UpdateNode(name=name, node=moved, update_mask=FieldMask(paths=["parent_t_node"]))
    made = scene_pb2.Command(create_node=scene_pb2.CreateNode(node=node))
    gone = scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name=name))
    for command in (made, scene_pb2.Command(update_node=change)):
        await scene.Apply(scene_pb2.ApplyRequest(commands=[command]))
    try:
        await history.Undo(history_pb2.UndoRequest(only_mine=True))
    finally:
        await scene.Apply(scene_pb2.ApplyRequest(commands=[gone]))


async def _move(channel: grpc.aio.Channel, place: int) -> None:
    """Lease an arm and move a joint of it there and back."""
    robot, lease = f"arm{place % ARMS}", lease_pb2_grpc.LeaseServiceStub(channel)
    given = await lease.AcquireLease(lease_pb2.AcquireLeaseRequest(robots=[robot]))
    kept = lease.KeepLeaseAlive(lease_pb2.KeepLeaseAliveRequest(token=given.token))
    await kept.read()
    motions = motion_pb2_grpc.MotionServiceStub(channel)
    moves = [
        motion_pb2.ProgramStep(
            move=motion_pb2.MoveStep(
                moves=[
                    motion_pb2.Move(
                        robot=robot,
                        point_to_point=motion_pb2.PointToPoint(
                            joints=motion_pb2.JointGoal(joint_positions={"lbr_iiwa_joint_1": angle})
                        ),
                    )
                ]
            )
        )
        for angle in (0.2, 0.0)
    ]
    try:
        request = motion_pb2.StartMotionRequest(
            spec=motion_pb2.MotionSpec(steps=moves), busy_policy=motion_pb2.BUSY_POLICY_PREEMPT
        )
        motion = (await motions.StartMotion(request, metadata=(("virtualrobot-lease", given.token),))).motion
        async for _ in motions.WatchMotion(motion_pb2.WatchMotionRequest(id=motion.id, max_rate_hertz=5.0)):
            pass
        await lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token=given.token))
    finally:
        kept.cancel()


async def _sample(channel: grpc.aio.Channel, process: psutil.Process) -> Sample:
    clock = await kernel_pb2_grpc.KernelServiceStub(channel).GetClock(kernel_pb2.GetClockRequest())
    with process.oneshot():
        return Sample(
            time.monotonic(),
            process.memory_info().rss * 1e-6,
            process.num_threads(),
            process.num_fds(),
            clock.stamp.simulation_time_seconds,
        )


async def _settled(channel: grpc.aio.Channel, process: psutil.Process, seconds: float) -> Sample:
    """Return the kernel once no client has left anything that still ends: leases expire after a second."""
    await asyncio.sleep(seconds)
    return await _sample(channel, process)


def rows_of(soak: Soak, minutes: float) -> list[Row]:
    """Return the rows of a soak."""
    name = f"100 clients for {minutes:g} minutes"
    rounds = f"{soak.calls / minutes / 60.0:.0f} rounds of calls a second"
    last, first = soak.megabytes(3), soak.megabytes(1)
    threads, descriptors = soak.after.threads, soak.after.descriptors
    return [
        row(f"memory, {name}", last, first, "its second quarter", "MB", 1.05, rounds),
        row(
            f"threads after {name}",
            threads,
            soak.before.threads,
            "before them",
            "threads",
            None,
            "pools make them late",
        ),
        row(f"descriptors after {name}", descriptors, soak.before.descriptors, "before them", "descriptors", 1.0),
        row(f"a simulated second with {name}", 1.0 / soak.factor, 1.0, "the wall clock", "s", 1.0 / 0.99),
    ]


def run() -> list[Row]:
    """Measure and return the rows."""
    return rows_of(soaked(MINUTES), MINUTES)


if __name__ == "__main__":
    length = float(sys.argv[1])
    result = soaked(length)
    for one in (result.before, *result.during, result.after):
        print(one)
    print(f"{result.calls} rounds of calls; real-time factor {result.factor:.4f}")
    for one in rows_of(result, length):
        print(f"{one['name']}: {one['ours']:.4g} {one['unit']} against {one['peer']:.4g}, {one['peer_name']}")
