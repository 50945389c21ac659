"""Setpoints to a controller of Universal Robots: how evenly they arrive, and how soon it is seen, against ur-rtde.

The controller is the emulated one, in this process; each program runs in a process of its own, in turn, and is as
punctual as the system lets it be (SCHED_FIFO where permitted). Ours is the driver in a loop like its host's, without a
twin. Each fifth of a second a program asks for another place; the trip ends with the reading that tells of it.
"""

from __future__ import annotations

import json
import select
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.ur import exchange
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.server import RTDE, Client, Server
from virtualrobot_sdk.drivers import realtime

from benchmarks.rows import Row, row

Result = TypeVar("Result")

HOST = "127.88.1.1"
SECONDS, WARM = 3.0, 0.5
ROUNDS = 3
DEADLINE = 60.0
HOME = (0.0, -1.57, 1.57, -1.57, -1.57, 0.0)

_LOOP = """
import json, sys, time
from virtualrobot_sdk.drivers import realtime

host, rate, seconds = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
trips, asked, before, step = [], 0, 0.0, 0.002
{connect}
goal = list(held)
realtime.calm()
due, period = time.monotonic_ns(), int(1e9 / rate)
began = time.process_time()
for cycle in range(int(seconds * rate)):
    {await_cycle}
    now = read()[0]
    if asked and abs(now - before) > 1e-5:
        trips.append(1e-3 * (time.monotonic_ns() - asked))
        asked = 0
    if cycle % (rate // 5) == 0:
        asked, before, step = time.monotonic_ns(), now, -step
        goal[0] += step
    {send}
    {end_cycle}
print(json.dumps([100.0 * (time.process_time() - began) / seconds, trips]))
{close}
"""
OURS = _LOOP.format(
    connect="""
import numpy as np
from virtualrobot_plugins.drivers.ur_rtde.driver import UrRtde, UrRtdeSettings
driver, still = UrRtde(UrRtdeSettings(host, rate, watchdog=1.0, silence=1.0)), np.zeros(6)
driver.connect()
read = lambda: driver.read().positions
held = read()
driver.begin(held)
""",
    await_cycle="due += period; realtime.sleep_until(due)",
    send="driver.send(np.array(goal), still, 0)",
    end_cycle="",
    close="driver.close()",
)
LIBRARY = _LOOP.format(
    connect="""
import rtde_control, rtde_receive
receive = rtde_receive.RTDEReceiveInterface(host, rate)
control = rtde_control.RTDEControlInterface(host, rate)
read = receive.getActualQ
held = read()
""",
    await_cycle="start = control.initPeriod()",
    send="control.servoJ(goal, 0.0, 0.0, 1.0 / rate, 0.1, 300)",
    end_cycle="control.waitPeriod(start)",
    close="control.servoStop(); control.stopScript()",
)


class Measured(NamedTuple):
    """What came of a program: how far intervals between setpoints are off a cycle, and round trips (us); its cost."""

    off: np.ndarray
    trips: np.ndarray
    share: float
    """Percent of a core."""


class Listening(Server):
    """Server that notes when each setpoint came, between its cycles too."""

    def __init__(self) -> None:
        """Have an arm of its own."""
        super().__init__(Controller(SimulatedArm(HOME)), HOST)
        self.arrivals: list[int] = []
        """When setpoints came, ns."""
        self.firsts: list[float] = []
        """First joint of each (rad), where it is the driver's of ours."""

    def listen(self, over: Callable[[], bool]) -> None:
        """Go on until it is over."""
        due = time.monotonic()
        while not over():
            due += self.controller.dt
            while (left := due - time.monotonic()) > 0.0:
                waiting: dict[socket.socket, Client] = {one.connection: one for one in self.clients if one.port == RTDE}
                ready = select.select(list(waiting), [], [], left)[0]
                for connection in ready:
                    waiting[connection].receive()
                    self._exchange(waiting[connection], waiting[connection].session)
                if any(waiting[one].ended for one in ready):
                    break
            self.cycle()

    def _exchange(self, client: Client, session: exchange.Session | None) -> None:
        """Note when setpoints come: packets of more than their number, while a program follows."""
        comes = self.controller.program is not None and len(client.got) > 50
        now = time.monotonic_ns()
        assert session is not None
        super()._exchange(client, session)
        if comes:
            first = self.controller.inputs.get("input_double_register_24", 0.0)
            assert isinstance(first, float)
            self.firsts.append(first)
            self.arrivals.append(now)


def measured(program: str, rate: int) -> Measured:
    """Return what comes of a program."""
    server, until = Listening(), time.monotonic() + DEADLINE
    try:
        with subprocess.Popen(
            [sys.executable, "-c", program, HOST, str(rate), str(SECONDS)], stdout=subprocess.PIPE, text=True
        ) as process:
            server.listen(lambda: process.poll() is not None or time.monotonic() > until)
            process.kill()
            share, trips = json.loads((process.stdout or sys.stdin).read().splitlines()[-1])
    finally:
        server.close()
    return Measured(off(np.array(server.arrivals), rate), np.array(trips), share)


def off(arrivals: np.ndarray, rate: int) -> np.ndarray:
    """Return how far intervals are off a cycle (us), in the last seconds."""
    steady = arrivals[arrivals > arrivals[-1] - (SECONDS - WARM) * 1e9]
    return np.abs(np.diff(steady) - 1e9 / rate) / 1000.0


def in_turn(*programs: Callable[[], Result]) -> list[list[Result]]:
    """Return what each of some programs gave in each round; who is first changes."""
    given: list[list[Result]] = [[] for _ in programs]
    for number in range(ROUNDS):
        for place in range(len(programs)):
            chosen = (place + number) % len(programs)
            given[chosen].append(programs[chosen]())
    return given


def run() -> list[Row]:
    """Return all rows."""
    rows = []
    realtime.calm()
    for rate in (125, 250, 500):
        both = in_turn(lambda rate=rate: measured(OURS, rate), lambda rate=rate: measured(LIBRARY, rate))

        def add(
            what: str, unit: str, budget: float | None, of: Callable[[Measured], float], both: list[Any] = both
        ) -> None:
            ours, peer = (float(np.median([of(one) for one in rounds])) for rounds in both)
            rows.append(row(what, ours, peer, "ur_rtde 1.6.5", unit, budget))

        to = f"setpoints to an emulated UR at {rate} Hz"
        add(f"{to}: median of what intervals are off", "us", None, lambda one: float(np.median(one.off)))
        add(f"{to}: 99th percentile of it", "us", 1.5, lambda one: float(np.percentile(one.off, 99)))
        add(f"{to}: until a reading tells of one, median", "us", 1.5, lambda one: float(np.median(one.trips)))
        add(f"{to}: cost", "% of a core", 1.0, lambda one: one.share)
    return rows
