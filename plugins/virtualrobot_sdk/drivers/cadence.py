"""Cadence of a host: when its cycles are due, by its own clock or by the controller's packets."""

from __future__ import annotations

import time
from collections.abc import Callable

from virtualrobot_sdk.drivers import realtime
from virtualrobot_sdk.drivers.driver import About, Driver, Pace, Reading


class Cadence:
    """Cycles of one connection.

    Attributes:
        due: when the present cycle was due (ns, CLOCK_MONOTONIC).
        cycles: number of cycles since it connected.
        skipped: number of cycles that were left out, since the process came too late.
        lateness: how late the newest cycle was (ns).
    """

    def __init__(self) -> None:
        """Begin without a cycle."""
        self.due = self.cycles = self.skipped = self.lateness = 0

    def read(self, driver: Driver, about: About, wait: Callable[[int], None]) -> Reading:
        """Return what the driver reads in the next cycle; `wait` sleeps until that is due (ns)."""
        period = int(1e9 / about.rate)
        if about.pace is Pace.CONTROLLER:
            reading = driver.read()
            ns = time.monotonic_ns()
            self.due += period
            # Packets come with the network's jitter; the robot's clock has none, and is followed slowly.
            off = ns - self.due
            self.due = ns if abs(off) > 2 * period else self.due + max(-period // 100, min(period // 100, off))
            return reading
        self.due += period
        now = time.monotonic_ns()
        if self.due < now - period:
            # Cycles that are over are left out, not made up for.
            missed = (now - self.due) // period
            self.skipped += missed if self.cycles else 0
            self.due += missed * period
        wait(self.due)
        return driver.read()


def wait_until(ns: int, looks: Callable[[], bool], every_ns: int) -> None:
    """Sleep until a time (ns, CLOCK_MONOTONIC); each `every_ns` it is looked whether that is to go on with looks."""
    while time.monotonic_ns() < ns and looks():
        realtime.sleep_until(min(ns, time.monotonic_ns() + every_ns))
    realtime.sleep_until(ns)
