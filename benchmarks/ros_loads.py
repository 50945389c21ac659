"""The bridge to ROS under load: joints in CBOR at 500 ticks a second, pictures, and the clock beside them.

Each is decoded by another process than the bridge. Beside it a bare WebSocket server sends the same bytes as often, and
a bare bridge when the kernel's client hears of a tick or a picture; what they take of a core is told for each message,
since pictures come less often on a busy machine. The clock is compared with itself without pictures and clouds.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cbor2
import numpy as np
import virtualrobot
from websockets.sync.client import connect

from benchmarks.processes import forwarder, kernel, process
from benchmarks.ros import core
from benchmarks.rows import Row, row

TICKS, PICTURES, CLOCKS = 3000, 200, 3000
WARM, WARM_PICTURES = 100, 20
WIDTH, HEIGHT, HERTZ = 640, 480, 30.0

BARE = """
import asyncio, sys
from websockets.asyncio.server import serve
from websockets.exceptions import ConnectionClosed

period = float(sys.argv[1])

async def told(socket):
    data = await socket.recv()
    clock = asyncio.get_running_loop().time
    due = clock()
    try:
        while True:
            await socket.send(data)
            due += period
            await asyncio.sleep(max(0.0, due - clock()))
    except ConnectionClosed:
        pass

async def main():
    async with serve(told, "127.0.0.1", 0, max_size=None, compression=None) as server:
        print("listening on", server.sockets[0].getsockname()[1], flush=True)
        await server.wait_closed()

asyncio.run(main())
"""
READER = """
import json, sys
from websockets.sync.client import connect

with connect(sys.argv[1], max_size=None, compression=None) as socket:
    for topic, type in json.loads(sys.argv[2]).items():
        socket.send(json.dumps({"op": "subscribe", "topic": topic, "type": type, "compression": "cbor"}))
    for number, data in enumerate(socket):
        if number == 10:
            print("reading on", flush=True)
"""


def hear(url: str, ask: str | bytes, count: int, warm: int, pid: int) -> tuple[dict[int, float], bytes, float]:
    """Return when messages in CBOR came, by their stamps (ns), the last one, and what each took of a core (ms)."""
    came: dict[int, float] = {}
    data = b""
    with connect(url, max_size=None, compression=None) as socket:
        socket.send(ask)
        for _ in range(warm):
            socket.recv()
        spent = core(pid)
        for _ in range(count):
            data = socket.recv()
            assert isinstance(data, bytes)
            came[stamp_of(cbor2.loads(data)["msg"])] = time.perf_counter()
        return came, data, 1e3 * (core(pid) - spent) / count


def stamp_of(message: dict[str, Any]) -> int:
    """Return the time of a message (ns)."""
    stamp = message["header"]["stamp"] if "header" in message else message["clock"]
    return stamp["sec"] * 1_000_000_000 + stamp["nanosec"]


@contextmanager
def own_arrivals(client: virtualrobot.Client, stream: str) -> Iterator[dict[int, float]]:
    """Give when samples of a stream come to the kernel's own client, by their stamps (ns)."""
    came: dict[int, float] = {}
    over = threading.Event()

    def read() -> None:
        with client.streams.watch(stream) as watch:
            while not over.is_set():
                if (sample := watch.next(1.0)) is not None:
                    came[sample.nanoseconds] = time.perf_counter()

    reader = threading.Thread(target=read)
    reader.start()
    try:
        yield came
    finally:
        over.set()
        reader.join()


def subscription(topic: str, type: str) -> str:
    """Return the message that subscribes in CBOR."""
    return json.dumps({"op": "subscribe", "topic": topic, "type": type, "compression": "cbor"})


def beside_others(
    name: str, ours: float, data: bytes, address: str, stream: str, period: float, count: int, warm: int, budget: float
) -> list[Row]:
    """Return the rows of what the bridge takes of a core, beside two that send the same bytes.

    A bare server sends them once a period, and a bare bridge when it hears of a sample of a stream. What the bare
    bridge takes more than the server is what hearing the kernel takes of anyone.
    """
    with process([sys.executable, "-c", BARE, str(period)], "listening on ") as (port, bare):
        _, _, sending = hear(f"ws://127.0.0.1:{port}", data, count, warm, bare.pid)
    with forwarder(address, stream) as (port, bare):
        _, _, hearing = hear(f"ws://127.0.0.1:{port}", data, count, warm, bare.pid)
    peer, unit = "websockets, the same bytes", "ms of a core"
    return [
        row(f"{name}: the bridge, with what it hears of the kernel, a message", ours, sending, peer, unit, budget),
        row(f"{name}: the bridge, a message", ours, hearing, "a bare bridge, the same bytes", unit, None),
        row(
            f"{name}: the bridge, without what hearing takes of a bare bridge, a message",
            *(ours - hearing + sending, sending, peer, unit, budget),
        ),
    ]


def joints(url: str, client: virtualrobot.Client, address: str, pid: int) -> list[Row]:
    """Measure joints that move, in CBOR."""
    arm = client.robots["arm"]
    arm.move_joints({"joint_a1": 2.0}, speed_factor=0.01, wait=False)  # for longer than this takes
    ask = subscription("/arm/joint_states", "sensor_msgs/JointState")
    with own_arrivals(client, "/robots/arm/joint_states") as own:
        came, data, ours = hear(url, ask, TICKS, WARM, pid)
    name, later = "joints at 500 Hz by rosbridge, CBOR", later_than(own, came)
    beside = beside_others(name, ours, data, address, "/robots/arm/joint_states", 0.002, TICKS, WARM, 1.5)
    arm.stop()
    return [
        row(f"{name}: later than by the kernel's client", percentile(later, 50), 1.0, "what is wanted", "ms, p50", 1.0),
        row(
            f"{name}: later than by the kernel's client", percentile(later, 99), 10.0, "what is wanted", "ms, p99", 1.0
        ),
        *beside,
    ]


def pictures(url: str, client: virtualrobot.Client, address: str, pid: int) -> list[Row]:
    """Measure pictures, in CBOR."""
    ask = subscription("/eye/image_raw", "sensor_msgs/Image")
    with own_arrivals(client, "/sensors/eye/color") as own:
        came, data, ours = hear(url, ask, PICTURES, WARM_PICTURES, pid)
    name = f"pictures of {WIDTH}x{HEIGHT} by rosbridge, CBOR"
    seconds = np.diff(sorted(came.values()))
    later = later_than(own, came)
    return [
        row(
            f"{name}: later than by the kernel's client",
            *(percentile(later, 50), 1e3 / HERTZ, "a picture's period", "ms, p50", None),
        ),
        row(f"{name}: how many come", 1.0 / float(np.mean(seconds)), HERTZ, "the camera's rate", "a second", None),
        *beside_others(
            *(name, ours, data, address, "/sensors/eye/color", float(np.mean(seconds)), PICTURES, WARM_PICTURES, 1.3)
        ),
    ]


def clock(url: str, client: virtualrobot.Client, address: str, pid: int) -> list[Row]:
    """Measure how late the clock comes, alone and while another process reads pictures and a cloud."""

    def lateness() -> float:
        with own_arrivals(client, "/clock") as own:
            came, _, _ = hear(url, subscription("/clock", "rosgraph_msgs/Clock"), CLOCKS, WARM, pid)
        return percentile(later_than(own, came), 99)

    alone = lateness()
    topics = {"/eye/image_raw": "sensor_msgs/Image", "/head/points": "sensor_msgs/PointCloud2"}
    with process([sys.executable, "-c", READER, url, json.dumps(topics)], "reading on"):
        beside = lateness()
    return [row("/clock beside pictures and a cloud: later", beside, alone, "without them", "ms, p99", 2.0)]


def later_than(own: dict[int, float], came: dict[int, float]) -> np.ndarray:
    """Return how much later (ms) messages came than by the kernel's own client."""
    return 1e3 * np.array([came[stamp] - own[stamp] for stamp in came if stamp in own])


def percentile(values: np.ndarray, share: float) -> float:
    """Return a percentile."""
    return float(np.percentile(values, share))


def run() -> list[Row]:
    """Measure all three, each by itself."""
    loads: tuple[Callable[[str, virtualrobot.Client, str, int], list[Row]], ...] = (joints, pictures, clock)
    rows: list[Row] = []
    with kernel("--headless", "--tick-milliseconds", "2") as (address, _), virtualrobot.connect(address) as client:
        client.load_robot("model://kr6_r700", name="arm")
        settings = virtualrobot.camera(WIDTH, HEIGHT, rate=HERTZ)
        client.scene.add_camera("eye", settings, pose=virtualrobot.looking_at([2, 0, 1], [0, 0, 0.5]))
        cloud = virtualrobot.range_sensor(pattern=virtualrobot.raster(300, 200, 1.0, 0.8), rate=10.0)
        client.scene.add_range_sensor("head", cloud, pose=virtualrobot.pose(-2.0, 0.0, 1.0))
        command = [str(Path(sys.executable).with_name("virtualrobot")), "--address", address, "ros", "--port", "0"]
        with process(command, "rosbridge at ") as (url, bridge):
            for load in loads:
                rows += load(url, client, address, bridge.pid)
    return rows
