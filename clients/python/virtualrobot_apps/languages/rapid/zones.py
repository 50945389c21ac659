"""World zones of RAPID: volumes and ranges of joints that set an output while the robot is in them, or end the program.

They are looked at while the program runs, and are gone when it ends.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from typing import TypeAlias

import numpy as np
from virtualrobot.errors import VirtualRobotError
from virtualrobot.robots.values import RobotState

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.world import World

LOOK_SECONDS = 0.02
"""Time (s of the wall clock) from one look at the robot to the next."""
UNBOUNDED = 9e8
"""Value of a joint's bound (degrees) from which on it is none; programs write 9E9."""

Shape: TypeAlias = Callable[[np.ndarray, np.ndarray], bool]
"""Test of a place of the tool centre point, (3,) in mm in RAPID's world, and joints, (6,) in degrees: within or not."""


def box(low: Sequence[float], high: Sequence[float]) -> Shape:
    """Return the box between two opposite corners (mm)."""
    least, most = np.minimum(low, high), np.maximum(low, high)
    return lambda place, _: bool(np.all(place >= least) and np.all(place <= most))


def cylinder(centre: Sequence[float], radius: float, height: float) -> Shape:
    """Return the cylinder along z that stands on a place (mm), or hangs from it where its height is below 0."""
    x, y, z = centre
    low, high = sorted((z, z + height))
    return lambda place, _: bool(np.hypot(place[0] - x, place[1] - y) <= radius and low <= place[2] <= high)


def sphere(centre: Sequence[float], radius: float) -> Shape:
    """Return the sphere around a place (mm)."""
    return lambda place, _: bool(np.linalg.norm(place - centre) <= radius)


def joints_between(low: Sequence[float], high: Sequence[float]) -> Shape:
    """Return the range of joints (degrees); a joint with a bound of 9E9 may be anywhere."""
    least, most = np.array(low, dtype=float), np.array(high, dtype=float)
    counts = (np.abs(least) < UNBOUNDED) & (np.abs(most) < UNBOUNDED)
    return lambda _, joints: bool(np.all((joints >= least) & (joints <= most) | ~counts))


def outside(shape: Shape) -> Shape:
    """Return all that is not within a shape."""
    return lambda place, joints: not shape(place, joints)


@dataclass(slots=True)
class Zone:
    """A zone at work: its shape, and the output that it sets; None: the robot may not be in it."""

    shape: Shape
    signal: str | None
    value: bool
    enabled: bool = True
    within: bool | None = None


class Zones:
    """World zones of one program, looked at in a thread.

    Attributes:
        entered: whether the robot has been in a zone that it may not enter.
    """

    def __init__(self, world: World, ask: Callable[[], None], *, watches: bool = True) -> None:
        """Begin without a zone; `ask` has the task serve soon. Where it doesn't watch, `look` tells of the robot."""
        self._world, self._ask, self._watches = world, ask, watches
        self.entered = False
        self._base_t_world = np.linalg.inv(world.base)
        self._zones: dict[float, Zone] = {}
        self._numbers = count(1)
        self._lock = threading.Lock()
        self._closed = threading.Event()
        self._thread: threading.Thread | None = None

    def add(self, shape: Shape, signal: str | None = None, value: bool = True) -> float:
        """Return the number of a new zone, which counts from now on."""
        with self._lock:
            number = float(next(self._numbers))
            self._zones[number] = Zone(shape, signal, value)
        self.look(self._world.robot.state)
        if self._thread is None and self._watches:
            self._thread = threading.Thread(target=self._watch, name="rapid zones", daemon=True)
            self._thread.start()
        return number

    def enable(self, number: float, enabled: bool) -> None:
        """Let a zone count, or no more; raises a fault where there is none."""
        zone = self._zones.get(number)
        if zone is None:
            raise RapidFault("ERR_ARGVALERR", "there is no such world zone yet, or it is free again")
        zone.enabled, zone.within = enabled, None
        self.look(self._world.robot.state)

    def free(self, number: float) -> None:
        """Forget a zone; one that is not there is no fault."""
        with self._lock:
            self._zones.pop(number, None)

    def look(self, state: RobotState) -> None:
        """Set the outputs of zones that the robot has entered or left."""
        place = (self._base_t_world @ state.world_t_tcp)[:3, 3] * 1000.0
        joints = np.degrees(state.positions)
        with self._lock:
            for zone in [one for one in self._zones.values() if one.enabled]:
                before, zone.within = zone.within, zone.shape(place, joints)
                if zone.within == before:
                    continue
                if zone.signal is not None:
                    self._world.client.signals[zone.signal] = zone.value == zone.within
                elif zone.within:
                    self.entered = True
                    self._ask()

    def close(self) -> None:
        """End the thread."""
        self._closed.set()

    def _watch(self) -> None:
        with suppress(VirtualRobotError):  # the kernel is gone, which the program notices itself
            while not self._closed.wait(LOOK_SECONDS):
                self.look(self._world.robot.state)
