"""Robots that are played: setpoints as their controller gets them, from a kernel, with a twin that moves.

The controller is the emulated one of `driver_ur.py`, in a thread of this process. The peer is a program with ur_rtde in
the same load, in turn; or our own driver in a bare loop, where a kernel that is stopped shall cost nothing. Load: arms
that move, lidars that scan, a viewer that somebody looks at. Emulator and drivers have SCHED_FIFO where permitted.
"""

from __future__ import annotations

import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import grpc
import numpy as np
import virtualrobot
from virtualrobot_sdk.drivers import realtime
from virtualrobot_sdk.drivers.shared import CELL, CellBlock, TickRing

from benchmarks.driver_ur import HOST, LIBRARY, OURS, SECONDS, Listening, Result, in_turn, measured, off
from benchmarks.processes import kernel
from benchmarks.rows import Row, row
from benchmarks.rpc import busy
from benchmarks.scans import create, head
from benchmarks.viewer import browser

RATES = (125, 250, 500)
RATE = 250
"""Cycles a second where only one is tried."""

LEAD = 0.4
TRIES = 5
SETTLE_SECONDS = 5.0
"""Time (s) that a kernel under load is given to compile and to send its first pictures."""

ARMS = (20, 10, 5)
"""Arms of the load; fewer where the kernel falls behind by more than the lead with more."""

LIDARS, LIDAR_RATE = 2, 10.0
STOPS = 40
NOTICED = 1e-12
"""Distance (rad) from where a setpoint would have been without the stop."""

STALL_SECONDS, STALL_PERIOD = 0.05, 0.25
SPEED = 0.1
"""Speed factor of what the robot does: it is on its way for longer than it is looked at."""

END = 2.0
"""Position (rad) of the first joint between which and its opposite the robot goes."""

ALPHA = (np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0)
UR5E = tuple(
    {"a": a, "alpha": alpha, "d": d, "limits": {"lower": -6.2, "upper": 6.2, "velocity": 3.1, "acceleration": 8.0}}
    for a, alpha, d in zip(
        (0.0, -0.425, -0.3922, 0.0, 0.0, 0.0), ALPHA, (0.1625, 0.0, 0.0, 0.1333, 0.0997, 0.0996), strict=True
    )
)


class Ended(Exception):
    """Motion that ended early, as where the kernel was late by more than the lead."""


class Cell:
    """Kernel with the twin of an arm, which is leased, guarded and not connected."""

    def __init__(self, address: str, pid: int) -> None:
        """Load it."""
        self.pid, self.client = pid, virtualrobot.connect(address)
        self.client.clock.set_realtime()
        pose = np.eye(4)
        pose[:3, 3] = -2.0, -2.0, 0.0
        self.arm = self.client.load_denavit_hartenberg(UR5E, convention="standard", name="ur", pose=pose)
        self.client.collisions.set(robots={"ur": "guard"})

    @contextmanager
    def played(self, rate: int) -> Iterator[Robot]:
        """Have the arm played by a controller with so many cycles a second, for the length of a block."""
        with self.arm.lease(), emulated() as server:
            settings = {"host": HOST, "rate": rate, "watchdog": 1.0, "silence": 1.0}
            self.client.drivers.connect("ur", "ur_rtde", settings, lead=LEAD)
            try:
                robot = Robot(self, server, self.client.drivers["ur"].process_id)
                robot.begin()
                yield robot
            finally:
                self.client.drivers.disconnect("ur")


class Robot:
    """Arm that is played."""

    def __init__(self, cell: Cell, server: Listening, driver: int) -> None:
        """Attach to what the kernel shares with the driver's process, which Linux tells."""
        self._cell, self._server = cell, server
        mapped = Path(f"/proc/{driver}/maps").read_text().split()
        files = {path.name: path for path in map(Path, mapped) if path.parent.name.startswith("virtualrobot-cell-")}
        self._block = CellBlock.attach(files.pop(CELL))
        (ring,) = files.values()
        self._ring = TickRing.attach(ring, 6)

    def begin(self) -> None:
        """Let it follow."""
        self._cell.client.drivers.set_mode("ur", "execute")

    def go(self) -> None:
        """Let it go to the farther end."""
        arm = self._cell.arm
        goal = {arm.joint_names[0]: -END if arm.positions[0] > 0.0 else END}
        arm.move_joints(goal, speed_factor=SPEED, wait=False)

    def arrivals(self) -> np.ndarray:
        """Return when setpoints came (ns) while it was on its way for some seconds."""
        self.go()
        time.sleep(SECONDS)
        came = np.array(self._server.arrivals)
        self.expect_active()
        return came

    def expect_active(self) -> None:
        """Raise Ended where it is not played any more, with the reason."""
        status = self._cell.client.drivers["ur"]
        if status.state != "active":
            raise Ended(status.text or str(self._cell.client.cell.stopped))

    def recover(self) -> None:
        """Wait until it is at rest, and let it follow again."""
        while self._cell.client.drivers["ur"].mode != "simulated":
            time.sleep(0.02)
        self._cell.client.cell.release()
        self.begin()

    def stop(self, rng: np.random.Generator) -> tuple[float, float]:
        """Stop it in its motion; return the time (s) until the first setpoint of its brake came, and setpoints' way.

        The way is the longest time of 40 setpoints from when one was due until it came.
        """
        self.go()
        time.sleep(LEAD + 0.8 + rng.uniform(0.0, 0.01))
        self.expect_active()
        first = len(self._server.arrivals) - 50
        self._block.stop()
        stopped, report = self._block.stop_ns, self._ring.reported()
        assert report is not None
        time.sleep(0.1)
        came = np.array(self._server.arrivals[first:])
        steps = np.abs(np.diff(self._server.firsts[first : first + len(came)]))
        usual = float(np.median(steps[:40]))
        # Brakes begin softly. A cycle that was left out makes a step twice as long.
        other = (np.abs(steps - usual) > NOTICED) & (steps < 1.5 * usual) & (came[1:] > stopped)
        period = 1e9 / RATE
        ways = (came[:40] - (report.ns - report.lateness_ns)) % period
        self.recover()
        return float(came[1 + np.flatnonzero(other)[0]] - stopped) * 1e-9, float(ways.max()) * 1e-9

    def tried(self, attempt: Callable[[], Result]) -> Result:
        """Return what an attempt gives, the first that doesn't end early."""
        for _ in range(TRIES - 1):
            try:
                return attempt()
            except Ended as error:
                print(f"  once more: {error}", flush=True)
                self.recover()
        return attempt()

    @contextmanager
    def stalled(self) -> Iterator[None]:
        """Stop the kernel's process four times a second, for the length of a block."""
        over = threading.Event()

        def stall() -> None:
            while not over.wait(STALL_PERIOD - STALL_SECONDS):
                os.kill(self._cell.pid, signal.SIGSTOP)
                time.sleep(STALL_SECONDS)
                os.kill(self._cell.pid, signal.SIGCONT)

        thread = threading.Thread(target=stall)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()


@contextmanager
def emulated() -> Iterator[Listening]:
    """Run the controller in a thread of its own, for the length of a block."""
    server, over = Listening(), threading.Event()

    def run() -> None:
        realtime.calm()
        server.listen(over.is_set)

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield server
    finally:
        over.set()
        thread.join()
        server.close()


@contextmanager
def alone() -> Iterator[Cell]:
    """Start a kernel that has nothing else to do."""
    with kernel("--headless") as (address, process):
        yield Cell(address, process.pid)


@contextmanager
def loaded(arms: int) -> Iterator[Cell]:
    """Start a kernel with some arms that move, lidars, and a viewer that somebody looks at."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with ExitStack() as stack:
        address, process = stack.enter_context(kernel("--viewer-port", str(port)))
        busy(address, arms)
        channel = stack.enter_context(grpc.insecure_channel(address))
        create(channel, [head(f"lidar{place}", 1.5 * place + 0.7, LIDAR_RATE) for place in range(LIDARS)])
        stack.enter_context(browser(f":{port}"))
        cell = Cell(address, process.pid)
        time.sleep(SETTLE_SECONDS)
        yield cell


def played(cell: Cell, rate: int, *, stalls: bool = False) -> np.ndarray:
    """Return how far intervals between setpoints are off a cycle (us), of an arm that is played."""
    with cell.played(rate) as robot, robot.stalled() if stalls else ExitStack():
        return off(robot.tried(robot.arrivals), rate)


def _p99(rounds: list[np.ndarray]) -> float:
    return float(np.median([np.percentile(one, 99) for one in rounds]))


def jitter(cell: Cell, load: str) -> list[Row]:
    """Return how even setpoints are at all rates, against ur_rtde in the same load."""
    rows = []
    for rate in RATES:
        ours, peer = in_turn(lambda rate=rate: played(cell, rate), lambda rate=rate: measured(LIBRARY, rate).off)
        name = f"setpoints of a robot that is played at {rate} Hz, {load}: 99th percentile of what intervals are off"
        rows.append(row(name, _p99(ours), _p99(peer), "ur_rtde 1.6.5, bare", "us", 1.5))
    return rows


def stalls(cell: Cell) -> Row:
    """Return how even setpoints are while the kernel is stopped again and again, against a driver without a kernel."""
    ours, peer = in_turn(lambda: played(cell, RATE, stalls=True), lambda: measured(OURS, RATE).off)
    what = f"the same at {RATE} Hz, while the kernel is stopped for {1e3 * STALL_SECONDS:g} ms four times a second"
    return row(what, _p99(ours), _p99(peer), "the driver in a bare loop", "us", 1.5)


def stops(cell: Cell, load: str) -> Row:
    """Return how long a stop takes to the first setpoint that brakes, against a cycle and a setpoint's way."""
    rng = np.random.default_rng(1)
    with cell.played(RATE) as robot:
        times, ways = np.array([robot.tried(lambda: robot.stop(rng)) for _ in range(STOPS)]).T * 1e3
    ours, way = float(np.percentile(times, 99)), float(np.median(ways))
    note = f"of {STOPS}, median {np.median(times):.2f} ms; the way takes up to {way:.2f} ms"
    what = f"stop at {RATE} Hz, {load}: from the flag to the first setpoint that brakes, 99th percentile"
    return row(what, ours, 1e3 / RATE + way, "a cycle and the way", "ms", 1.0, note)


def unmeasured(why: str) -> Row:
    """Return the row of what could not be measured."""
    return Row(name=why, ours=None, peer=None, peer_name="", unit="", ratio=None, budget=None)


def run() -> list[Row]:
    """Return all rows."""
    realtime.calm()
    with alone() as cell:
        rows = [*jitter(cell, "alone"), stalls(cell)]
    for arms in ARMS:
        load = f"with {arms} arms, {LIDARS} lidars and a viewer"
        try:
            with loaded(arms) as cell:
                return [*rows, *jitter(cell, load), stops(cell, load)]
        except Ended as error:
            rows.append(unmeasured(f"{load}, not measured: {error}"))
    return rows
