"""Calls and streams of the kernel against a bare grpc.aio echo server, idle and with 20 arms moving."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence

import grpc
import numpy as np
import pybullet_data
from virtualrobot.v1 import (
    geometry_pb2,
    kernel_pb2,
    kernel_pb2_grpc,
    motion_pb2,
    motion_pb2_grpc,
    robot_pb2,
    robot_pb2_grpc,
    scene_pb2,
    scene_pb2_grpc,
)

from benchmarks.processes import echo, kernel
from benchmarks.rows import Row, row

IIWA = f"{pybullet_data.getDataPath()}/kuka_iiwa/model.urdf"
ARMS, WATCHERS, CALLS, ROUNDS = 20, 4, 1500, 3
READERS, STREAM_ROUNDS, STREAM_SECONDS = 48, 5, 1.5


def latencies(call: Callable[[], object], calls: int = CALLS) -> np.ndarray:
    """Return the time of each call in milliseconds."""
    for _ in range(100):
        call()
    times = np.empty(calls)
    for place in range(calls):
        start = time.perf_counter()
        call()
        times[place] = (time.perf_counter() - start) * 1e3
    return times


def in_turn(ours: Callable[[], object], peer: Callable[[], object]) -> tuple[np.ndarray, np.ndarray]:
    """Return latencies of both, measured in turn so that the machine's moods meet both."""
    rounds = [(latencies(ours), latencies(peer)) for _ in range(ROUNDS)]
    return np.concatenate([a for a, _ in rounds]), np.concatenate([b for _, b in rounds])


def busy(address: str, arms: int = ARMS) -> None:
    """Load some arms and keep them moving slowly."""
    with grpc.insecure_channel(address) as channel:
        scene, motion = scene_pb2_grpc.SceneServiceStub(channel), motion_pb2_grpc.MotionServiceStub(channel)
        for place in range(arms):
            position = geometry_pb2.Vector3(x=1.5 * (place % 5), y=1.5 * (place // 5))
            pose = geometry_pb2.Pose(position=position)
            scene.ImportModel(
                scene_pb2.ImportModelRequest(
                    model=scene_pb2.ModelSource(uri=IIWA, name=f"arm{place}", parent_t_node=pose)
                )
            )
            goal = motion_pb2.JointGoal(joint_positions={f"lbr_iiwa_joint_{joint}": 1.5 for joint in range(1, 8)})
            slow = motion_pb2.Move(
                robot=f"arm{place}", speed_factor=0.002, point_to_point=motion_pb2.PointToPoint(joints=goal)
            )
            keep = motion_pb2.DISCONNECT_POLICY_CONTINUE
            motion.StartMotion(
                motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[slow]), on_disconnect=keep)
            )


def watch(address: str, ended: threading.Event, counted: list[int]) -> None:
    """Read all robots' states at 60 Hz until told to end."""
    with grpc.insecure_channel(address) as channel:
        stub = robot_pb2_grpc.RobotServiceStub(channel)
        answers: Iterator = stub.WatchRobotStates(robot_pb2.WatchRobotStatesRequest(max_rate_hertz=60))
        for _ in answers:
            counted[0] += 1
            if ended.is_set():
                return


def unary(address: str) -> Callable[[], object]:
    """Return a small call to a kernel."""
    stub = kernel_pb2_grpc.KernelServiceStub(grpc.insecure_channel(address))
    return lambda: stub.GetClock(kernel_pb2.GetClockRequest())


def echoed(address: str) -> Callable[[], object]:
    """Return a call to the echo server."""
    call = grpc.insecure_channel(address).unary_unary("/Echo/Unary")
    return lambda: call(b"x" * 64)


def told(reads: Callable[[], Iterator[object]]) -> float:
    """Return the messages a second that several readers get together."""
    counts = [0] * READERS
    ended = threading.Event()

    def read(place: int) -> None:
        messages = reads()
        for _ in messages:
            counts[place] += 1
            if ended.is_set():
                break
        messages.cancel()  # pyright: ignore[reportAttributeAccessIssue] streams of gRPC are calls

    threads = [threading.Thread(target=read, args=(place,)) for place in range(READERS)]
    for thread in threads:
        thread.start()
    ended.wait(1.0)
    before, start = sum(counts), time.perf_counter()
    ended.wait(STREAM_SECONDS)
    rate = (sum(counts) - before) / (time.perf_counter() - start)
    ended.set()
    for thread in threads:
        thread.join()
    return rate


@contextlib.contextmanager
def pinned(*servers: int) -> Iterator[None]:
    """Keep servers (process ids) on one core and this process on another one, where there are two."""
    cores = sorted(os.sched_getaffinity(0))

    def keep(process: int, on: Sequence[int]) -> None:
        for thread in os.listdir(f"/proc/{process}/task"):
            with contextlib.suppress(ProcessLookupError):  # it has just ended
                os.sched_setaffinity(int(thread), on)

    try:
        for server in servers:
            keep(server, cores[:1])
        keep(os.getpid(), cores[-1:])
        yield
    finally:
        for process in (os.getpid(), *servers):
            keep(process, cores)


def stream_rows(echo_address: str, echo_process: int) -> list[Row]:
    """Return how fast joint states are told: every tick of 1 ms, to several readers.

    The threads of a free server meet on two cores or on one, as the scheduler likes, and either server becomes up to
    four times as fast or slow by that. So servers on one core are judged; free ones are told as well.
    """
    options = "--headless", "--tick-milliseconds", "1"
    with kernel(*options) as (address, process), grpc.insecure_channel(address) as channel:
        busy(address, arms=1)
        stub = robot_pb2_grpc.RobotServiceStub(channel)
        clock = kernel_pb2_grpc.KernelServiceStub(channel)
        bare = grpc.insecure_channel(echo_address).unary_stream(
            "/Echo/Stream", response_deserializer=robot_pb2.WatchRobotStatesResponse.FromString
        )
        every = robot_pb2.WatchRobotStatesRequest(max_rate_hertz=1e6)

        def both() -> tuple[float, float]:
            ours = told(lambda: stub.WatchRobotStates(every))
            clock.SetClock(kernel_pb2.SetClockRequest(mode=kernel_pb2.CLOCK_MODE_STEPPED))  # rest while the peer works
            peer = told(lambda: bare(b""))
            clock.SetClock(kernel_pb2.SetClockRequest(mode=kernel_pb2.CLOCK_MODE_REALTIME))
            return ours, peer

        with pinned(process.pid, echo_process):
            on_one_core = [both() for _ in range(STREAM_ROUNDS)]
        free = [both() for _ in range(STREAM_ROUNDS)]
    rows = []
    for rates, where, budget in ((on_one_core, "each server on one core", 1 / 0.7), (free, "servers free", None)):
        ours, peer = np.median(rates, axis=0).tolist()
        name = f"joint-state stream, 7 axes, {READERS} readers, {where} (time per message)"
        least, most = min(a for a, _ in rates), max(a for a, _ in rates)
        note = f"median {ours:.0f} messages/s, {least:.0f} to {most:.0f}"
        peer_name = "grpc.aio building and streaming the same message"
        rows.append(row(name, 1e6 / ours, 1e6 / peer, peer_name, "us", budget, note))
    return rows


def run() -> list[Row]:
    """Measure and return the rows."""
    rows: list[Row] = []
    with echo() as (echo_address, echo_process):
        with kernel("--headless", "--stepped") as (address, _):
            ours, peer = in_turn(unary(address), echoed(echo_address))
            for name, share, budget in (("p50", 50, 1.3), ("p99", 99, None)):
                a, b = np.percentile(ours, share), np.percentile(peer, share)
                rows.append(row(f"unary call, idle, {name}", float(a), float(b), "grpc.aio echo", "ms", budget))
        with kernel() as (address, _):
            busy(address)
            ended, counted = threading.Event(), [0]
            threads = [threading.Thread(target=watch, args=(address, ended, counted)) for _ in range(WATCHERS)]
            for thread in threads:
                thread.start()
            start = time.perf_counter()
            ours = np.concatenate([latencies(unary(address)) for _ in range(ROUNDS)])
            messages = counted[0] / (time.perf_counter() - start)
            with grpc.insecure_channel(address) as channel:
                clock = kernel_pb2_grpc.KernelServiceStub(channel).GetClock(kernel_pb2.GetClockRequest()).clock
            ended.set()
            for thread in threads:
                thread.join()
            peer = np.concatenate([latencies(echoed(echo_address)) for _ in range(ROUNDS)])
            load = f"{ARMS} arms moving, viewer thread, {WATCHERS} watchers at 60 Hz"
            note = f"{messages:.0f} watch messages/s, real-time factor {clock.real_time_factor:.3f}"
            for name, share, budget in (("p50", 50, 1.5), ("p99", 99, None)):
                a, b = np.percentile(ours, share), np.percentile(peer, share)
                rows.append(
                    row(f"unary call, {load}, {name}", float(a), float(b), "grpc.aio echo, idle", "ms", budget, note)
                )
        rows += stream_rows(echo_address, echo_process.pid)
    return rows


if __name__ == "__main__":
    for result in run():
        print(result)
