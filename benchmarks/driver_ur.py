"""Setpoints to a controller of Universal Robots: how evenly they arrive, and what they cost, against ur-rtde.

The controller is the emulated one, in this process; each program runs in a process of its own, one after the other, and
is as punctual as the system lets it be (SCHED_FIFO where permitted). Ours is the driver in a loop like its host's,
without a twin.
"""

from __future__ import annotations

import json
import select
import socket
import subprocess
import sys
import time

import numpy as np
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.ur import exchange
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.server import RTDE, Client, Server
from virtualrobot_sdk.drivers import realtime

from benchmarks.rows import Row, row

HOST = "127.88.1.1"
SECONDS, WARM = 4.0, 0.5
DEADLINE = 60.0

_OURS = """
import json, sys, time
import numpy as np
from virtualrobot_plugins.drivers.ur_rtde.driver import UrRtde, UrRtdeSettings
from virtualrobot_sdk.drivers import realtime

host, rate, seconds = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
driver = UrRtde(UrRtdeSettings(host, rate, watchdog=1.0, silence=1.0))
driver.connect()
held = driver.read().positions
driver.begin(held)
realtime.calm()
due, period, still = time.monotonic_ns(), int(1e9 / rate), np.zeros(6)
began = time.process_time()
for _ in range(int(seconds * rate)):
    due += period
    realtime.sleep_until(due)
    driver.read()
    driver.send(held, still, 0)
print(json.dumps((time.process_time() - began) / seconds))
driver.close()
"""
_LIBRARY = """
import json, sys, time
import rtde_control, rtde_receive
from virtualrobot_sdk.drivers import realtime

host, rate, seconds = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
receive = rtde_receive.RTDEReceiveInterface(host, rate)
control = rtde_control.RTDEControlInterface(host, rate)
held = receive.getActualQ()
realtime.calm()
began = time.process_time()
for _ in range(int(seconds * rate)):
    start = control.initPeriod()
    receive.getActualQ()
    control.servoJ(held, 0.0, 0.0, 1.0 / rate, 0.1, 300)
    control.waitPeriod(start)
print(json.dumps((time.process_time() - began) / seconds))
control.servoStop()
control.stopScript()
"""


class Listening(Server):
    """Server that notes when each setpoint came, between its cycles too."""

    def __init__(self) -> None:
        """Have an arm of its own."""
        super().__init__(Controller(SimulatedArm([0.0, -1.57, 1.57, -1.57, -1.57, 0.0])), HOST)
        self.arrivals: list[int] = []

    def listen(self, process: subprocess.Popen[str]) -> None:
        """Go on until a program has ended."""
        due, ends = time.monotonic(), time.monotonic() + DEADLINE
        while process.poll() is None and due < ends:
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
        if self.controller.program is not None and len(client.got) > 50:
            self.arrivals.append(time.monotonic_ns())
        assert session is not None
        super()._exchange(client, session)


def measured(program: str, rate: int) -> tuple[float, float, float]:
    """Return median and 99th percentile of how far intervals are off a cycle (us), and the share of a core (%)."""
    server = Listening()
    try:
        with subprocess.Popen(
            [sys.executable, "-c", program, HOST, str(rate), str(SECONDS)], stdout=subprocess.PIPE, text=True
        ) as process:
            server.listen(process)
            process.kill()
            share = json.loads((process.stdout or sys.stdin).read().splitlines()[-1])
    finally:
        server.close()
    times = np.array(server.arrivals)
    times = times[times > times[-1] - (SECONDS - WARM) * 1e9]
    off = np.abs(np.diff(times) - 1e9 / rate) / 1000.0
    return float(np.median(off)), float(np.percentile(off, 99)), 100.0 * share


def run() -> list[Row]:
    """Return all rows."""
    rows = []
    realtime.calm()
    for rate in (125, 250, 500):
        ours, peer = measured(_OURS, rate), measured(_LIBRARY, rate)
        for i, (what, unit, budget) in enumerate(
            (("median", "us", None), ("99th percentile", "us", 1.5), ("cost", "% of a core", 1.0))
        ):
            name = f"setpoints to an emulated UR at {rate} Hz: {what}" + (" of what intervals are off" if i < 2 else "")
            rows.append(row(name, ours[i], peer[i], "ur_rtde 1.6.5", unit, budget))
    return rows
