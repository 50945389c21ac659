"""Jobs: a robot whose controller plans by itself is given the path of its twin as points, once the twin rests.

Between two points such a controller goes its own way in its own time. So only what is proven goes out: ticks that were
played, and of these as many points as it takes for the path between them to be straight in joint space.
"""

from __future__ import annotations

import numpy as np

from virtualrobot_sdk.drivers.driver import Driver, Reading
from virtualrobot_sdk.drivers.player import Play, Player
from virtualrobot_sdk.drivers.robot_side import Mapping, RobotSide
from virtualrobot_sdk.drivers.shared import Floats

STRAIGHT = 1e-3
"""Greatest distance (rad or m) of the twin's path from the straight line between two points."""

REST_TICKS = 25
"""Number of ticks in which the twin doesn't move, from which it rests."""


class Jobs:
    """Path of a twin as it is played, and the points that were given to the controller.

    Attributes:
        held: the last point (k,) that was given: where the robot comes to.
    """

    def __init__(self, driver: Driver, mapping: Mapping, side: RobotSide, held: Floats) -> None:
        """Begin where the robot is held (k,)."""
        self._driver, self._mapping = driver, mapping
        self._velocity = np.array([joint.velocity for joint in side.joints])
        self._tick_seconds = side.tick_ns * 1e-9
        self.held = held
        self._way = held[None]
        self._path: list[Floats] = [held]
        self._times: list[int] = [0]
        self._rests_since = self._stepped = 0
        self._given = 0
        self._reached = 0

    @property
    def done(self) -> bool:
        """True once the robot has reached all points that it was given."""
        return self._reached >= self._given

    def nearest(self, q: Floats) -> Floats:
        """Return the place (k,) on the way that was given last, straight between its points, that is nearest to q."""
        begin, along = self._way[:-1], np.diff(self._way, axis=0)
        squares = np.maximum(np.sum(along * along, axis=1), 1e-30)  # a way may end where it began
        share = np.clip(np.sum((q - begin) * along, axis=1) / squares, 0.0, 1.0)
        places = np.vstack([self._way[-1], begin + share[:, None] * along])
        return places[np.linalg.norm(q - places, axis=1).argmin()]

    def step(self, ns: int, player: Player, reading: Reading | None) -> None:
        """Take what the twin plays at a time (ns), and give the controller its path once it rests."""
        if reading is not None:
            self._reached = reading.done
        before, self._stepped = self._stepped, ns
        setpoint = player.step(ns)
        if setpoint is None:
            return
        if np.array_equal(setpoint.q, self._path[-1]):
            rests = ns - self._rests_since >= REST_TICKS * self._tick_seconds * 1e9
        else:
            if len(self._path) == 1:
                # It rested there until now, and the way begins here.
                self._times[0] = before
            self._path.append(setpoint.q)
            self._times.append(ns)
            self._rests_since, rests = ns, False
        # After a stop, and when the kernel is gone, a robot that stands stays where it is.
        if len(self._path) > 1 and self.done and rests and player.state is Play.PLAYING:
            self._give(setpoint.outputs)

    def _give(self, outputs: int) -> None:
        path = np.array(self._path)
        places = corners(path, STRAIGHT)[1:]
        speeds = []
        for one, other in zip([0, *places], places, strict=False):
            seconds = max((self._times[other] - self._times[one]) * 1e-9, self._tick_seconds)
            share = float(np.max(np.abs(path[other] - path[one]) / self._velocity)) / seconds
            speeds.append(min(max(share, 0.01), 1.0))
        points = [self._mapping.raw(path[place], np.zeros_like(self.held))[0] for place in places]
        self._driver.run(points, speeds, outputs)
        self._way = path[[0, *places]]
        self._given += len(points)
        self.held = self._path[-1]
        self._path, self._times = [self.held], [self._times[-1]]


def corners(path: Floats, tolerance: float) -> list[int]:
    """Return places in a path (n, k) between which straight lines leave it nowhere by more than a tolerance.

    By Ramer (1972), Douglas and Peucker (1973); the first and the last place are among them.
    """
    kept, left = [0, len(path) - 1], [(0, len(path) - 1)]
    while left:
        first, last = left.pop()
        if last - first < 2:
            continue
        line = path[last] - path[first]
        length = float(line @ line)
        inner = path[first + 1 : last] - path[first]
        along = np.clip(inner @ line / length, 0.0, 1.0) if length > 0.0 else np.zeros(len(inner))
        off = np.linalg.norm(inner - along[:, None] * line, axis=1)
        worst = int(off.argmax())
        if off[worst] > tolerance:
            place = first + 1 + worst
            kept.append(place)
            left += [(first, place), (place, last)]
    return sorted(kept)
