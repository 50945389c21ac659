"""Scans on their way to clients: readings of a spinning head with 28,800 beams, and calls while ten such heads run.

The kernel runs in a process of its own and sends what it reads over TCP. Calls are compared with those of the same
kernel at rest, and with a bare grpc.aio echo.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import grpc
import numpy as np
from virtualrobot.v1 import (
    geometry_pb2,
    kernel_pb2,
    kernel_pb2_grpc,
    nodes_pb2,
    scene_pb2,
    scene_pb2_grpc,
    sensing_pb2,
    sensor_pb2,
    sensor_pb2_grpc,
)

from benchmarks.processes import echo, kernel
from benchmarks.ray_cell import MAX_RANGE, ray_cell
from benchmarks.rows import Row, row
from benchmarks.rpc import ARMS, WATCHERS, busy, echoed, latencies, unary, watch

LIDARS, LIDAR_RATE = 10, 10.0
WANTED = 60.0
"""Readings a second that shall reach a client."""
SECONDS, ROUNDS = 4.0, 3


def run() -> list[Row]:
    """Measure."""
    return [*one_head(), *ten_heads()]


def one_head() -> list[Row]:
    """Return how many readings of one head a second reach a client that asks for all that can be had."""
    with kernel("--headless") as (address, _), grpc.insecure_channel(address, OPTIONS) as channel:
        furnish(channel)
        create(channel, [head("lidar", 0.0, 250.0)])
        stub = sensor_pb2_grpc.SensorServiceStub(channel)
        options = sensor_pb2.ReadingOptions(intensities=True, elements=True)
        stream = stub.WatchReadings(sensor_pb2.WatchReadingsRequest(sensors=["lidar"], options=options))
        rate, size = counted(stream)
        stream.cancel()
    note = f"{rate:.0f} a second, {size / 1e3:.0f} kB each, with intensities and elements"
    return [row("reading of 28,800 beams at a client", 1e3 / rate, 1e3 / WANTED, "60 a second", "ms", 1.0, note)]


def ten_heads() -> list[Row]:
    """Return what calls take beside ten heads at 10 Hz, moving arms and watchers."""
    rows = []
    with echo() as (echo_address, _), kernel() as (address, _):
        rest = np.concatenate([latencies(unary(address)) for _ in range(ROUNDS)])
        busy(address)
        with grpc.insecure_channel(address, OPTIONS) as channel:
            create(channel, [head(f"lidar{place}", 1.5 * (place % 5) + 0.7, LIDAR_RATE) for place in range(LIDARS)])
            ended, messages = threading.Event(), [0]
            threads = [threading.Thread(target=watch, args=(address, ended, messages)) for _ in range(WATCHERS)]
            for thread in threads:
                thread.start()
            time.sleep(2.0)
            sensors = sensor_pb2_grpc.SensorServiceStub(channel)
            before, start = told(sensors), time.perf_counter()
            ours = np.concatenate([latencies(unary(address)) for _ in range(ROUNDS)])
            seconds, after = time.perf_counter() - start, told(sensors)
            clock = kernel_pb2_grpc.KernelServiceStub(channel).GetClock(kernel_pb2.GetClockRequest()).clock
            ended.set()
            for thread in threads:
                thread.join()
        peer = np.concatenate([latencies(echoed(echo_address)) for _ in range(ROUNDS)])
    readings, missed = (np.subtract(after, before) / seconds).tolist()
    load = f"{LIDARS} heads of 28,800 beams at {LIDAR_RATE:g} Hz, {ARMS} arms moving, viewer, {WATCHERS} watchers"
    note = f"{readings:.0f} readings/s, {missed:.0f} left out, real-time factor {clock.real_time_factor:.3f}"
    for name, share, budget in (("p50", 50, 1.4), ("p99", 99, 6.0)):
        loaded, idle, bare = (float(np.percentile(times, share)) for times in (ours, rest, peer))
        rows.append(row(f"unary call, {load}, {name}", loaded, bare, "grpc.aio echo, idle", "ms", budget, note))
        rows.append(row(f"the same, {name}", loaded, idle, "the kernel at rest", "ms", None))
    return rows


OPTIONS = (("grpc.max_receive_message_length", -1),)


def furnish(channel: grpc.Channel) -> None:
    """Put the boxes of the ray cell into a kernel's world, with meshes left out: they would have to travel as files."""
    nodes = []
    for place, (shape, pose) in enumerate(zip(*_parts(), strict=True)):
        size = np.ptp(shape.vertices, axis=0)
        node = nodes_pb2.Node(name=f"object{place}", object=nodes_pb2.SceneObject())
        node.parent_t_node.position.CopyFrom(_vector(pose[:3, 3]))
        node.figures.add().box.size.CopyFrom(_vector(size))
        nodes.append(node)
    create(channel, nodes)


def head(name: str, x: float, rate: float) -> nodes_pb2.Node:
    """Return a running head at 1 m above the floor, with the model laser."""
    sensor = sensing_pb2.RangeSensor(
        rate_hertz=rate, max_range_meters=MAX_RANGE, sensor_model="laser", min_range_meters=0.1, running=True
    )
    sensor.pattern.spinning.columns = 1800
    sensor.pattern.spinning.elevations_radians.extend(np.radians(np.linspace(-15.0, 15.0, 16)).tolist())
    node = nodes_pb2.Node(name=name, range_sensor=sensor)
    node.parent_t_node.position.CopyFrom(_vector((x, 0.75, 1.0)))
    return node


def create(channel: grpc.Channel, nodes: list[nodes_pb2.Node]) -> None:
    """Add nodes to a kernel's world."""
    commands = [scene_pb2.Command(create_node=scene_pb2.CreateNode(node=node)) for node in nodes]
    scene_pb2_grpc.SceneServiceStub(channel).Apply(scene_pb2.ApplyRequest(commands=commands))


def counted(stream: Iterator[sensor_pb2.WatchReadingsResponse]) -> tuple[float, float]:
    """Return the readings a second of a stream, and the mean size of a message in bytes."""
    sizes: list[int] = []
    start = None
    for message in stream:
        start = start or time.perf_counter()
        sizes.append(message.ByteSize())
        if time.perf_counter() - start > SECONDS:
            break
    assert start is not None
    return (len(sizes) - 1) / (time.perf_counter() - start), float(np.mean(sizes))


def told(sensors: sensor_pb2_grpc.SensorServiceStub) -> tuple[int, int]:
    """Return how many readings all sensors have given and left out."""
    found = sensors.ListSensors(sensor_pb2.ListSensorsRequest()).sensors
    return sum(one.readings for one in found), sum(one.missed for one in found)


def _parts() -> tuple[list, list]:
    cell = ray_cell()
    boxes = [place for place, shape in enumerate(cell.shapes) if len(shape.triangles) == 12]
    return [cell.shapes[place] for place in boxes], [cell.world_t_element[place] for place in boxes]


def _vector(values: np.ndarray | tuple[float, ...]) -> geometry_pb2.Vector3:
    x, y, z = (float(value) for value in values)
    return geometry_pb2.Vector3(x=x, y=y, z=z)
