"""Calls while the collision monitor watches twenty moving arms, against the mode OFF, and against a bare echo."""

from __future__ import annotations

import time

import grpc
import numpy as np
from virtualrobot.v1 import collision_pb2, collision_pb2_grpc, kernel_pb2, kernel_pb2_grpc, scene_pb2, scene_pb2_grpc

from benchmarks.processes import echo, kernel
from benchmarks.rows import Row, row
from benchmarks.rpc import ARMS, busy, echoed, latencies, unary

ROUNDS = 3
BUDGET = 1.5
"""Of a call's median, as in the suite rpc."""


def run() -> list[Row]:
    """Measure, in turn so that the machine's moods meet all."""
    times: dict[str, list[np.ndarray]] = {"on": [], "off": [], "echo": []}
    costs: list[tuple[float, float]] = []
    with echo() as (echo_address, _), kernel("--headless") as (address, _):
        busy(address)
        with grpc.insecure_channel(address) as channel:
            collisions = collision_pb2_grpc.CollisionServiceStub(channel)
            scene = scene_pb2_grpc.SceneServiceStub(channel)
            clock = kernel_pb2_grpc.KernelServiceStub(channel)
            for _ in range(ROUNDS):
                set_mode(scene, collision_pb2.COLLISION_MODE_STOP)
                before, start = told(collisions), time.perf_counter()
                times["on"].append(latencies(unary(address)))
                after, seconds = told(collisions), time.perf_counter() - start
                factor = clock.GetClock(kernel_pb2.GetClockRequest()).clock.real_time_factor
                set_mode(scene, collision_pb2.COLLISION_MODE_OFF)
                times["off"].append(latencies(unary(address)))
                times["echo"].append(latencies(echoed(echo_address)))
                checks = after.checks - before.checks
                costs.append((checks / seconds, (after.check_seconds - before.check_seconds) / checks * 1e3))
    rate, milliseconds = np.median(costs, axis=0).tolist()
    note = f"{rate:.0f} checks/s of {milliseconds:.2f} ms, real-time factor {factor:.3f}"
    rows = []
    for name, share, budget in (("p50", 50, BUDGET), ("p99", 99, None)):
        on, off, bare = (float(np.percentile(np.concatenate(rounds), share)) for rounds in times.values())
        what = f"unary call, {ARMS} arms moving, monitor, {name}"
        rows.append(row(what, on, bare, "grpc.aio echo, idle", "ms", budget, note))
        rows.append(row(f"the same, {name}", on, off, "the mode OFF", "ms", None))
    return rows


def set_mode(scene: scene_pb2_grpc.SceneServiceStub, mode: collision_pb2.CollisionMode) -> None:
    """Say what is done about collisions."""
    command = scene_pb2.Command(set_collision_settings=collision_pb2.SetCollisionSettings(mode=mode))
    scene.Apply(scene_pb2.ApplyRequest(commands=[command]))


def told(collisions: collision_pb2_grpc.CollisionServiceStub) -> collision_pb2.WatchCollisionsResponse:
    """Return what the monitor tells at once."""
    stream = collisions.WatchCollisions(collision_pb2.WatchCollisionsRequest())
    first = next(stream)
    stream.cancel()
    return first
