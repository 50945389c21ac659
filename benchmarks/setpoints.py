"""Streams of setpoints: what following costs in the tick, and how long a setpoint takes to a motion and back."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Iterator
from typing import Any

import grpc
import numpy as np
import ruckig
from virtualrobot.v1 import motion_pb2, motion_pb2_grpc, scene_pb2, scene_pb2_grpc
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode, start
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.commands import SetSetpoint, StartSetpointMotion, StopMotions
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.tick import advance

from benchmarks.processes import echo, kernel
from benchmarks.rows import Row, row
from benchmarks.rpc import in_turn
from benchmarks.tick import IIWA, world_of

ARMS, TICKS, ROUNDS, JOINTS = 20, 100, 5, 7
TICK = 0.004
NAMES = tuple(f"lbr_iiwa_joint_{joint}" for joint in range(1, JOINTS + 1))


def _sine(tick: int) -> list[float]:
    return [0.2 - 0.2 * float(np.cos(2.0 * tick * TICK))] * JOINTS


def tick_row() -> Row:
    """Return what a tick of 20 arms costs that get a setpoint each, without its poses, against 20 planned motions."""
    world = world_of(ARMS)
    planned = _advance_milliseconds(world, world.step(TICKS).result().state)
    world.submit([StopMotions()]).result()
    world.step(5 * TICKS).result()
    robots = [f"arm{place}" for place in range(ARMS)]
    world.submit([StartSetpointMotion(robot, NAMES, SetpointMode.VELOCITY, 1e9) for robot in robots]).result()
    ids = [motion.id for motion in world.snapshot.state.motions]
    world.submit([SetSetpoint(id, (0.01,) * JOINTS) for id in ids]).result()
    following = _advance_milliseconds(world, world.snapshot.state)
    world.close()
    return row(f"tick, {ARMS} arms following setpoints", following, planned, "the same arms planned", "ms", None)


def _advance_milliseconds(world: World, state: State) -> float:
    structure, series = world.snapshot.structure, []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        for _ in range(TICKS):
            state = advance(structure, state, TICK, world_poses)
        series.append((time.perf_counter() - begin) / TICKS * 1e3)
    return float(np.median(series))


def step_row() -> Row:
    """Return what one tick of a motion costs that gets a position for 7 joints, against ruckig's own online step."""
    values = [np.full(JOINTS, value) for value in (-3.0, 3.0, 2.0, 10.0, 100.0)]
    limits = JointLimits(NAMES, *values)

    def ours() -> float:
        following = start(SetpointMode.POSITION, limits, np.zeros(JOINTS), 1.0)
        begin = time.perf_counter()
        for tick in range(TICKS):
            following = following.set(_sine(tick)).advance(TICK, 1.0)
        return (time.perf_counter() - begin) / TICKS * 1e6

    def peer() -> float:
        generator, output = ruckig.Ruckig(JOINTS, TICK), ruckig.OutputParameter(JOINTS)
        given = ruckig.InputParameter(JOINTS)
        given.max_velocity, given.max_acceleration, given.max_jerk = (value.tolist() for value in values[2:])
        begin = time.perf_counter()
        for tick in range(TICKS):
            given.target_position = _sine(tick)
            generator.update(given, output)
            output.pass_to_input(given)
        return (time.perf_counter() - begin) / TICKS * 1e6

    rounds = [(ours(), peer()) for _ in range(10 * ROUNDS)]
    a, b = np.median(rounds, axis=0).tolist()
    note = "the peer keeps no position limits, refuses nothing and stops at each setpoint"
    return row("a position setpoint for 7 joints and its tick", a, b, "ruckig's update", "us", 6.0, note)


class _Answered:
    """A call that streams both ways, of which each message is answered."""

    def __init__(self, call: Callable[[Iterator[Any]], Any], first: object) -> None:
        self._waiting: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._waiting.put(first)
        self.answers = call(iter(self._waiting.get, None))
        next(self.answers)

    def send(self, message: object) -> None:
        """Send a message."""
        self._waiting.put(message)


def round_trip_row() -> Row:
    """Return how long a setpoint takes to its motion and back to its client, against an echo."""
    with echo() as (echo_address, _), kernel("--headless", "--stepped") as (address, _):
        channel, bare = grpc.insecure_channel(address), grpc.insecure_channel(echo_address)
        scene = scene_pb2_grpc.SceneServiceStub(channel)
        scene.ImportModel(scene_pb2.ImportModelRequest(model=scene_pb2.ModelSource(uri=IIWA, name="arm")))
        target = motion_pb2.SetpointTarget(robot="arm", joint_names=NAMES, mode=motion_pb2.SETPOINT_MODE_VELOCITY)
        stub = motion_pb2_grpc.MotionServiceStub(channel)
        stream = _Answered(stub.StreamSetpoints, motion_pb2.StreamSetpointsRequest(target=target))
        setpoint, sent = motion_pb2.StreamSetpointsRequest(values=[0.0] * JOINTS), 0

        def ours() -> None:
            nonlocal sent
            sent += 1
            stream.send(setpoint)
            while next(stream.answers).setpoint_count < sent:
                pass

        echoed = _Answered(bare.stream_stream("/Echo/Both"), b"")

        def peer() -> None:
            echoed.send(b"x" * 64)
            next(echoed.answers)

        ours_times, peer_times = in_turn(ours, peer)
    a, b = float(np.median(ours_times)), float(np.median(peer_times))
    return row("setpoint to its motion and back, p50", a, b, "grpc.aio echo on a stream", "ms", None)


def run() -> list[Row]:
    """Measure and return the rows."""
    return [step_row(), tick_row(), round_trip_row()]


if __name__ == "__main__":
    for result in run():
        print(result)
