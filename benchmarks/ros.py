"""The bridge to ROS at 500 ticks a second, and controllers in lockstep in Octave.

Joints by rosbridge in JSON, decoded by another process than the bridge: how much later they come than by the kernel's
own client, how many come, and what that costs, beside a bare WebSocket server that sends the same text as often, and a
bare bridge, which sends it when the kernel's client hears of a tick.
Lockstep by the functions for MATLAB and Octave, beside the same exchange by a socket in Python.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import virtualrobot
from virtualrobot_apps.lockstep.exchange import Lockstep
from virtualrobot_apps.lockstep.wire import ProgramWire, SocketWire, Wire, listen
from websockets.sync.client import connect

from benchmarks.processes import forwarder, kernel, process
from benchmarks.rows import Row, row

TICKS = 3000
STEPS, WARM = 300, 50
STEPS_A_SECOND = 150.0
"""Lockstep steps a second that are wanted."""
QUARTER = 0.25
"""Part of a core that the bridge may take at 500 ticks a second."""

BARE = """
import asyncio, sys
from websockets.asyncio.server import serve
from websockets.exceptions import ConnectionClosed

async def told(socket):
    text = await socket.recv()
    clock = asyncio.get_running_loop().time
    due = clock()
    try:
        while True:
            await socket.send(text)
            due += 0.002
            await asyncio.sleep(max(0.0, due - clock()))
    except ConnectionClosed:
        pass

async def main():
    async with serve(told, "127.0.0.1", 0) as server:
        print("listening on", server.sockets[0].getsockname()[1], flush=True)
        await server.wait_closed()

asyncio.run(main())
"""
OCTAVE = """
addpath('{functions}');
link = lockstep({port});
state = receive(link);
while ~isempty(state)
  send(link, struct('twist', [0.1 0 0]));
  state = receive(link);
end
"""
PYTHON = """
import json, socket
with socket.create_connection(("127.0.0.1", {port})) as link, link.makefile("rw") as file:
    for line in file:
        json.loads(line)
        file.write(json.dumps({{"twist": [0.1, 0, 0]}}) + "\\n")
        file.flush()
"""


def core(pid: int) -> float:
    """Return the seconds of a core that a process has taken."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def arrivals(url: str, ask: str, count: int, pid: int) -> tuple[dict[int, float], str, float]:
    """Return when messages came, by their stamps (ns), the last one, and the part of a core of who sent them."""
    came: dict[int, float] = {}
    text = ""
    with connect(url, max_size=None) as socket:
        socket.send(ask)
        for _ in range(100):
            socket.recv()
        began, spent = time.perf_counter(), core(pid)
        for _ in range(count):
            text = str(socket.recv())
            stamp = json.loads(text)["msg"]["header"]["stamp"]
            came[stamp["sec"] * 1_000_000_000 + stamp["nanosec"]] = time.perf_counter()
        return came, text, (core(pid) - spent) / (time.perf_counter() - began)


def joints(address: str) -> list[Row]:
    """Measure joints that move, by the bridge and by the kernel's own client at once."""
    own: dict[int, float] = {}
    over = threading.Event()
    command = [str(Path(sys.executable).with_name("virtualrobot")), "--address", address, "ros", "--port", "0"]
    with virtualrobot.connect(address) as client, process(command, "rosbridge at ") as (url, bridge):
        arm = client.load_robot("model://kr6_r700", name="arm")
        arm.move_joints({"joint_a1": 2.0}, speed_factor=0.01, wait=False)  # for longer than this takes

        def read() -> None:
            with client.streams.watch("/robots/arm/joint_states") as watch:
                while not over.is_set():
                    if (sample := watch.next(1.0)) is not None:
                        own[sample.nanoseconds] = time.perf_counter()

        reader = threading.Thread(target=read)
        reader.start()
        try:
            ask = {"op": "subscribe", "topic": "/arm/joint_states", "type": "sensor_msgs/JointState"}
            came, text, ours = arrivals(url, json.dumps(ask), TICKS, bridge.pid)
        finally:
            over.set()
            reader.join()
        with forwarder(address, "/robots/arm/joint_states") as (port, bare):
            _, _, hearing = arrivals(f"ws://127.0.0.1:{port}", text, TICKS, bare.pid)
        arm.stop()
    with process([sys.executable, "-c", BARE], "listening on ") as (port, bare):
        _, _, peer = arrivals(f"ws://127.0.0.1:{port}", text, TICKS, bare.pid)
    later = 1e3 * np.array([came[stamp] - own[stamp] for stamp in came if stamp in own])
    stamps = sorted(came)
    missing = (stamps[-1] - stamps[0]) // 2_000_000 + 1 - len(stamps)
    name, wanted = "joints at 500 Hz by rosbridge, JSON", "what is wanted"
    return [
        row(f"{name}: later than by the kernel's client", float(np.median(later)), 1.0, wanted, "ms, p50", 1.0),
        row(
            f"{name}: later than by the kernel's client", float(np.percentile(later, 99)), 10.0, wanted, "ms, p99", 1.0
        ),
        row(f"{name}: ticks that don't come", float(missing), float(TICKS), "ticks", "", 0.0),
        row(f"{name}: the bridge", ours, QUARTER, wanted, "of a core", 1.0),
        row(
            f"{name}: the bridge, with what it hears of the kernel",
            ours,
            peer,
            "websockets, the same text",
            "of a core",
            1.5,
        ),
        row(f"{name}: the bridge", ours, hearing, "a bare bridge, the same text", "of a core", None),
        row(
            f"{name}: the bridge, without what hearing takes of a bare bridge",
            *(ours - hearing + peer, peer, "websockets, the same text", "of a core", 1.5),
        ),
    ]


def step_milliseconds(
    client: virtualrobot.Client, period: float, start: Callable[[int], list[str]], kernel_pid: int
) -> tuple[float, float]:
    """Return how long a step of lockstep takes with a controller that connects, and starts by this command.

    And what kernel, exchange and controller take of a core for it, which on a machine that does nothing else is as much
    (ms): they wait for each other.
    """
    with closing(listen(0)) as server:
        controller = subprocess.Popen(start(server.getsockname()[1]), stderr=subprocess.DEVNULL)
        try:
            with closing(SocketWire(server, 60.0)) as wire:
                spent: list[float] = []

                def look() -> None:
                    spent.append(core(kernel_pid) + core(controller.pid) + time.process_time())

                return exchanged(client, period, wire, look), 1e3 * (spent[-1] - spent[WARM]) / (len(spent) - 1 - WARM)
        finally:
            controller.kill()
            controller.wait()


def exchanged(client: virtualrobot.Client, period: float, wire: Wire, look: Callable[[], None] = lambda: None) -> float:
    """Return how long a step of lockstep takes (ms); `look` is called after each."""
    times: list[float] = []

    def told(_: float) -> None:
        times.append(time.perf_counter())
        look()

    Lockstep(client, "ugv", period).run(wire, 60.0, STEPS * period, told)
    return 1e3 * float(np.mean(np.diff(times)[WARM:]))


def worked(client: virtualrobot.Client, folder: Path) -> list[Row]:
    """Measure the controllers of docs/lockstep.md, which drive a square, by pipes, at their period."""
    text = (Path(__file__).resolve().parents[1] / "docs" / "lockstep.md").read_text("utf-8")
    took: list[float] = []
    for language, *start in (("octave", "octave-cli", "--norc", "--quiet"), ("python", sys.executable)):
        program = folder / f"square_of_{language}"
        program.write_text(text.partition(f"```{language}\n")[2].partition("```")[0])
        with closing(ProgramWire([*start, str(program)])) as wire:
            took.append(exchanged(client, 0.05, wire))
    name = "a step of lockstep of 50 ms, a controller that drives a square, Octave"
    return [
        row(name, took[0], took[1], "Python, the same controller", "ms", None),
        row(name, took[0], 1e3 / STEPS_A_SECOND, f"{STEPS_A_SECOND:g} steps a second", "ms", 1.0),
    ]


def lockstep(address: str, kernel_pid: int) -> list[Row]:
    """Measure controllers that only answer, at three periods, and one that does something."""
    functions = Path(__file__).resolve().parents[1] / "clients" / "matlab"
    rows = []
    with virtualrobot.connect(address) as client, tempfile.TemporaryDirectory() as folder:
        client.load_robot("model://ugv", name="ugv", base="planar")
        program = Path(folder) / "controller.m"

        def octave(port: int) -> list[str]:
            program.write_text(OCTAVE.format(functions=functions, port=port))
            return ["octave-cli", "--norc", "--quiet", str(program)]

        def python(port: int) -> list[str]:
            return [sys.executable, "-c", PYTHON.format(port=port)]

        for period in (0.004, 0.02, 0.05):
            (ours, taken), (peer, _) = (step_milliseconds(client, period, one, kernel_pid) for one in (octave, python))
            name = f"a step of lockstep of {1e3 * period:g} ms, Octave"
            rows.append(row(name, ours, peer, "Python, the same exchange", "ms", None))
            wanted = f"{STEPS_A_SECOND:g} steps a second"
            rows.append(row(name, ours, 1e3 / STEPS_A_SECOND, wanted, "ms", 1.0))
            name += ", of kernel, exchange and Octave"
            rows.append(row(name, taken, 1e3 / STEPS_A_SECOND, wanted, "ms of a core", 1.0))
        rows += worked(client, Path(folder))
    return rows


def run() -> list[Row]:
    """Measure both."""
    with kernel("--headless", "--tick-milliseconds", "2") as (address, _):
        rows = joints(address)
    if shutil.which("octave-cli") is None:
        return rows
    with kernel("--headless") as (address, started):
        return [*rows, *lockstep(address, started.pid)]
