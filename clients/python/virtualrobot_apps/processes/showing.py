"""Effects of a process, shown while it runs: they grow as far as the tool has come along its ways."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from virtualrobot import Client, Motion
from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.curves.way import Floats
from virtualrobot_apps.processes.effects.chips import Cutter
from virtualrobot_apps.processes.effects.growing import BeadGrowth, DepthGrowth, Growth, coat_of
from virtualrobot_apps.processes.leading import Led, Stretch

Passed = tuple[Floats, Floats]
"""Frames (n, 4, 4) of a tool, and times (n,)."""

PERIOD = 0.1
"""Time (s) from one look at the tool to the next."""
ON_WAY = 0.003
"""Distance (m) from its way up to which a tool is on it: it and a part that moves are read one after the other."""
AHEAD, HEAD_START = 1.5, 0.1
"""Time ahead on its ways within which a tool is looked for: as often the time since it was seen, and so many s."""


@dataclass(frozen=True, slots=True, eq=False)
class Effect:
    """Effect on a part.

    Attributes:
        name: that of its coat, which takes the place of that of the run before.
        part: the node.
        stretches: those that it comes of, by their places among all.
        growth: how it grows along them.
    """

    name: str
    part: str
    stretches: Sequence[int]
    growth: Growth


def effects_of(
    led: Led,
    what: str,
    growth: Callable[[tuple[str, ...], list[Passed]], Growth],
    passed: Callable[[Stretch], Passed] = lambda one: (one.frames, one.times),
) -> Iterator[Effect]:
    """Yield an effect on each of the parts that a tool went along.

    Args:
        led: the plan.
        what: what the effect is called, such as `film`.
        growth: how it grows, of parts and of the frames and times of each pass.
        passed: these of a stretch.
    """
    for parts, rows in led.rows_by_parts().items():
        passes = [passed(led.stretches[row]) for row in rows]
        yield Effect(f"{what} on {parts[0]}", parts[0], rows, growth(parts, passes))


def beads(led: Led, radius: float, standoff: float) -> Iterator[Effect]:
    """Return the beads of a radius (m) on each of the parts that a tool went along, a standoff (m) before it."""
    return effects_of(led, "bead", lambda _, passes: BeadGrowth(passes, radius, standoff))


def depths(client: Client, led: Led, cutter: Cutter | None) -> Iterator[Effect]:
    """Return how deep a cutter goes into each part; nothing without a cutter."""
    if cutter is None:
        return iter(())
    return effects_of(led, "depth", lambda parts, passes: DepthGrowth(client, parts, passes, cutter))


class Showing:
    """Shows effects as coats, which stay after the process."""

    def __init__(
        self, client: Client, robot: str, passes: Sequence[tuple[str, Floats, Floats]], effects: Sequence[Effect]
    ) -> None:
        """Put bare coats on parts.

        Args:
            client: of the kernel.
            robot: the arm.
            passes: of its tool, in the order in which it goes: each a part, frames (n, 4, 4) in its frame, and times.
            effects: what is shown.
        """
        self._client, self._robot, self._passes = client, robot, passes
        self._effects, self._looked_at = effects, -PERIOD
        self._coats = [coat_of(client, one.name, one.part, one.growth) for one in effects]
        durations = [float(times[-1]) for _, _, times in passes]
        self._starts = np.concatenate([[0.0], np.cumsum(durations)])
        self._done, self._seen_at = 0.0, client.robot(robot).state.stamp.simulation_time

    def look(self) -> None:
        """See how far the tool has come, and show that; at most ten times a second, else nothing is done."""
        now = time.monotonic()
        if now - self._looked_at < PERIOD:
            return
        self._looked_at = now
        state = self._client.robot(self._robot).state
        ahead = self._done + AHEAD * max(0.0, state.stamp.simulation_time - self._seen_at) + HEAD_START
        poses = {part: np.linalg.inv(self._client.scene.pose(part)) for part in {part for part, _, _ in self._passes}}
        nearest, found = ON_WAY, None
        for (part, frames, times), start in zip(self._passes, self._starts[:-1].tolist(), strict=True):
            if start > ahead or start + times[-1] < self._done:
                continue
            place = (poses[part] @ state.world_t_tcp)[:3, 3]
            distance, when = _nearest(frames[:, :3, 3], times, place, self._done - start, ahead - start)
            if distance < nearest:
                nearest, found = distance, start + when
        if found is not None:
            self._go(found)
            self._seen_at = state.stamp.simulation_time

    def finish(self) -> None:
        """Show all of it."""
        self._go(np.inf)

    @contextmanager
    def during(self, motion: Motion) -> Iterator[None]:
        """Look ten times a second as long as the block lasts, and show all of it where the motion has succeeded."""
        ended = threading.Event()

        def follow() -> None:
            while not ended.wait(PERIOD):
                try:
                    self.look()
                except VirtualRobotError:
                    # What is shown must not end what is done; who runs it is told of a lost kernel.
                    return

        thread = threading.Thread(target=follow, name="effects", daemon=True)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
        if motion.phase.name == "SUCCEEDED":
            self.finish()

    def _go(self, until: float) -> None:
        """Let all effects grow until a time on all passes (s), one after the other."""
        for effect, coat in zip(self._effects, self._coats, strict=True):
            quantities = None
            for place, stretch in enumerate(effect.stretches):
                start, end = self._starts[stretch], self._starts[stretch + 1]
                if end <= self._done or start >= until:
                    continue
                begin = -np.inf if self._done <= start else self._done - start
                quantities = effect.growth.go(place, begin, np.inf if until >= end else until - start)
            if quantities is not None:
                coat.paint(quantities)
        self._done = max(self._done, min(until, float(self._starts[-1])))


def _nearest(points: Floats, times: Floats, place: Floats, begin: float, end: float) -> tuple[float, float]:
    """Return how far a place is from a way between two times, and when the way is nearest to it."""
    along, times = np.diff(points, axis=0), np.asarray(times)
    squares = np.maximum((along**2).sum(axis=1), 1e-18)
    shares = np.clip(((place - points[:-1]) * along).sum(axis=1) / squares, 0.0, 1.0)
    when = np.clip(times[:-1] + shares * np.diff(times), begin, end)
    # A time at the border of what is looked at may be off the segment: the distance is that at this time.
    shares = np.clip((when - times[:-1]) / np.maximum(np.diff(times), 1e-12), 0.0, 1.0)
    distances = np.linalg.norm(points[:-1] + shares[:, None] * along - place, axis=1)
    there = (times[1:] >= begin) & (times[:-1] <= end)
    distances[~there] = np.inf
    row = int(distances.argmin())
    return float(distances[row]), float(when[row])
