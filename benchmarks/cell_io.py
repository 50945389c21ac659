"""Round trips: signal, bridge, PLC with a cycle of 10 ms, bridge, signal; against the bare library to the same PLC."""

from __future__ import annotations

import asyncio
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import virtualrobot
from virtualrobot_apps.bridges.bridge import Bridge
from virtualrobot_apps.bridges.command import peer_of
from virtualrobot_apps.bridges.mapping import mapping_of
from virtualrobot_apps.cell_io.yaml_file import parse

from benchmarks.plc_server import CYCLE_SECONDS
from benchmarks.processes import kernel, process
from benchmarks.rows import Row, row

TRIPS = 200
MAPPINGS = {
    "opcua": ("boolean, node: ns=2;s=ask", "boolean, node: ns=2;s=answer"),
    "modbus": ("int16, address: holding_register 0", "int16, address: holding_register 1"),
}


@contextmanager
def bridged(client: virtualrobot.Client, protocol: str, url: str) -> Iterator[None]:
    """Bridge the signals `ask` and `answer` to a PLC for the length of a block."""
    ask, answer = MAPPINGS[protocol]
    text = f"""
schema_version: 1
connected: there
cycle_seconds: {CYCLE_SECONDS}
signals:
- {{signal: ask, direction: out, type: {ask}}}
- {{signal: answer, direction: in, type: {answer}}}
"""
    mapping = mapping_of(parse(text, "plc.yaml"), protocol, serves=False)
    ended = threading.Event()
    bridge = Bridge(client, mapping, peer_of(protocol, mapping, url, None), lambda words: None)
    thread = threading.Thread(target=bridge.run, args=(ended.is_set,))
    thread.start()
    client.signals.wait_for("there", timeout=60)
    try:
        yield
    finally:
        ended.set()
        thread.join()


def trips(turn: Callable[[bool], None]) -> np.ndarray:
    """Return how long each round trip took (ms)."""
    times = np.empty(TRIPS)
    for number in range(-10, TRIPS):
        begin = time.perf_counter()
        turn(number % 2 == 0)
        times[max(number, 0)] = 1e3 * (time.perf_counter() - begin)
    return times


def ours(address: str, protocol: str, url: str) -> np.ndarray:
    """Return round trips of signals over a bridge (ms)."""
    with virtualrobot.connect(address) as client:
        for name in ("ask", "answer", "there"):
            if name not in client.signals:
                client.signals.create(name, False)
        with bridged(client, protocol, url), client.signals.follow(["answer"]) as watch:
            changes = iter(watch)
            now = next(changes).values["answer"]

            def turn(value: bool) -> None:
                nonlocal now
                client.signals["ask"] = value
                while now != value:
                    now = next(changes).values["answer"]

            return trips(turn)


def bare_modbus(url: str) -> np.ndarray:
    """Return round trips by pymodbus alone, which polls as often as the bridge does (ms)."""
    from pymodbus.client import ModbusTcpClient

    with ModbusTcpClient("127.0.0.1", port=urlsplit(url).port or 502) as bare:

        def turn(value: bool) -> None:
            bare.write_register(0, int(value))
            while bare.read_holding_registers(1).registers != [int(value)]:
                time.sleep(CYCLE_SECONDS)

        return trips(turn)


async def bare_opcua(url: str) -> np.ndarray:
    """Return round trips by asyncua alone, with a subscription of the same period (ms)."""
    from asyncua.client.client import Client

    class Seen:
        def __init__(self) -> None:
            self.values: asyncio.Queue[bool] = asyncio.Queue()

        def datachange_notification(self, node: object, value: bool, data: object) -> None:
            self.values.put_nowait(value)

    async with Client(url) as bare:
        seen: Any = Seen()  # the type of asyncua's handlers names more than it calls
        subscription = await bare.create_subscription(1e3 * CYCLE_SECONDS, seen)
        await subscription.subscribe_data_change(bare.get_node("ns=2;s=answer"))
        ask, now = bare.get_node("ns=2;s=ask"), await seen.values.get()
        times = np.empty(TRIPS)
        for number in range(-10, TRIPS):
            begin, value = time.perf_counter(), number % 2 == 0
            await ask.write_value(value)
            while now != value:
                now = await seen.values.get()
            times[max(number, 0)] = 1e3 * (time.perf_counter() - begin)
        return times


def run() -> list[Row]:
    """Measure both protocols."""
    rows = []
    with kernel("--headless") as (address, _):
        for protocol in MAPPINGS:
            with process([sys.executable, "-m", "benchmarks.plc_server", protocol], "listening on ") as (url, _):
                over = ours(address, protocol, url)
                bare = asyncio.run(bare_opcua(url)) if protocol == "opcua" else bare_modbus(url)
            library = {"opcua": "asyncua", "modbus": "pymodbus"}[protocol]
            for name, at in (("median", 50), ("p99", 99)):
                mine, peer = (float(np.percentile(times, at)) for times in (over, bare))
                rows.append(row(f"signal to PLC and back, {protocol}, {name}", mine, peer, library, "ms", None))
    return rows
