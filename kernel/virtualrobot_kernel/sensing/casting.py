"""Ray casters that calls ask: each made when first asked for, and given a part of the rays at a time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.ray_checks import checked_hits
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, RayScene
from virtualrobot_sdk.registration import ComponentKind

from virtualrobot_kernel.components.running import ComponentHandle, start
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.sensing.elements import Elements, elements_of
from virtualrobot_kernel.sensing.readers import SensingRoom
from virtualrobot_kernel.world.state import Snapshot

RAYS_AT_ONCE = 10_000
"""Number of rays in one call of a component: its deadline is meant for so many, and a cancelled cast ends soon."""

Floats = NDArray[np.float64]
GoOn = Callable[[int], bool]
"""Is told how many rays are done and returns whether to go on."""


@dataclass(frozen=True, slots=True, eq=False)
class Cast:
    """Hits of n rays (`triangle` is not told), and the time in seconds that the component took."""

    hits: Hits
    seconds: float


class Casters:
    """Owns the ray casters that calls have asked for; any thread may ask, and those that ask the same one wait.

    A caster is kept for the next call. After a fault it is made anew: one scene says nothing about another.
    """

    def __init__(self, room: SensingRoom) -> None:
        """Take components and shapes from this room."""
        self._room = room
        self._kept: dict[str, ComponentHandle] = {}
        self._locks: dict[str, threading.Lock] = {}
        self._lock = threading.Lock()
        self._elements: Elements | None = None
        self._closed = False

    def elements(self, snapshot: Snapshot) -> Elements:
        """Return what rays can meet in a snapshot; takes its time where meshes have to be read."""
        self._elements = found = elements_of(snapshot, self._room.shapes, self._elements)
        return found

    def cast(
        self, name: str, scene: RayScene, origins: Floats, directions: Floats, max_range: float, go_on: GoOn
    ) -> Cast:
        """Return what n rays hit, asked of the component `name`; see `cast_rays`.

        Raises UnknownNameError for a component that is not installed, KernelError as `cast_rays` does.
        """
        with self._lock:
            lock = self._locks.setdefault(name, threading.Lock())
        with lock:
            return cast_rays(self._running(name), scene, origins, directions, max_range, go_on)

    def uses(self) -> tuple[ComponentHandle, ...]:
        """Return the casters that calls have asked for, those that failed last included."""
        with self._lock:
            return tuple(self._kept.values())

    def close(self) -> None:
        """End all casters; no other is started."""
        with self._lock:
            self._closed = True
            kept, self._kept = list(self._kept.values()), {}
        for running in kept:
            running.close()

    def _running(self, name: str) -> ComponentHandle:
        offer = self._room.catalog.find(ComponentKind.RAY_CASTER, name)
        running = self._kept.get(name)
        if running is not None and running.latest is None and running.offer is offer:
            return running
        if running is not None:
            running.close()
        made = start(offer, {})
        with self._lock:
            if not self._closed:
                self._kept[name] = made
                return made
        made.close()
        raise KernelError("the kernel is ending", reason=Reason.SHUTTING_DOWN)


def cast_rays(
    running: ComponentHandle, scene: RayScene, origins: Floats, directions: Floats, max_range: float, go_on: GoOn
) -> Cast:
    """Return what n rays hit: `origins` (n, 3) or (1, 3), unit `directions` (n, 3), in the world.

    Every answer is looked at. Raises KernelError with the component's own words for what it refuses, PLUGIN_FAILED
    for a fault or nonsense, and WRONG_STATE where `go_on` says that nobody waits any more.
    """
    n = len(directions)
    origins = np.broadcast_to(origins, (n, 3))
    hits = Hits(np.full(n, np.inf), np.full(n, NO_ELEMENT, np.int32), np.zeros((n, 3)))
    seconds = 0.0
    for begin in range(0, n, RAYS_AT_ONCE):
        part = slice(begin, begin + RAYS_AT_ONCE)
        # Copies: a component in this process could write into what it is given, and into what it has given.
        rays = origins[part].copy(), directions[part].copy()
        started = time.perf_counter()
        answer = running.call("cast", scene, *rays, max_range)
        seconds += time.perf_counter() - started
        try:
            found = checked_hits(answer, scene, origins[part], directions[part])
        except ComponentFault as fault:
            raise running.failed(fault) from fault
        hits.distance[part], hits.element[part], hits.normal[part] = found.distance, found.element, found.normal
        if not go_on(min(begin + RAYS_AT_ONCE, n)):
            raise KernelError("nobody waits for these rays any more", reason=Reason.WRONG_STATE)
    return Cast(hits, seconds)
