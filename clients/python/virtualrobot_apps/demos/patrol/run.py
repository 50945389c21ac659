"""A vehicle goes its rounds: at each stop it scans the room, and says what is not as it was in the first round.

Its map is the plan of the building, its place is what lidar and encoders say, and the pose of a scan is by that place.
Where things truly are is asked for counting them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from virtualrobot import Client

from virtualrobot_apps.demos.patrol import room
from virtualrobot_apps.seeing.changes.comparing import Change, OtherPlaceError, compare
from virtualrobot_apps.seeing.changes.scan import Scan, scan_of
from virtualrobot_apps.seeing.navigation import floors, journeys
from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.navigator import Goal
from virtualrobot_apps.seeing.navigation.poses import Floats
from virtualrobot_apps.seeing.navigation.vehicle import Vehicle, sensors_of

SAME = 0.4
"""Distance (m) up to which changes that two stops tell are the same thing."""
FOUND = 0.25
"""Distance (m) from its true place at which a change counts as found."""


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """Result of a patrol.

    changes: of the second round, the biggest first. found: how many of the two true ones are among them. false: how
    many are none of those. quiet: changes that were told of a round in which nothing had changed. other: what was said
    of another room; empty: nothing, or alarms.
    """

    changes: tuple[Change, ...]
    found: int
    false: int
    quiet: int
    other: str


class Patrol:
    """Rounds of one vehicle through the room."""

    def __init__(self, client: Client, base_t_scanner: Floats, stops: Sequence[Sequence[float]], pace: float) -> None:
        """Begin at the start, on the plan of the building."""
        self._client, self._base_t_scanner, self._pace = client, base_t_scanner, pace
        self._stops = [np.array(stop) for stop in stops]
        self._grid: Grid = floors.true_grid(room.ROOM, 0.05, room.SIZE)
        self._vehicle = Vehicle(client, room.ROBOT, *sensors_of(client, room.ROBOT))
        self._here = np.array(room.START)

    def round(self, say: Callable[[str], object]) -> list[Scan]:
        """Go to all stops, one after the other; return the scan of each."""
        scans = []
        for stop in self._stops:
            journeys.go(
                self._client,
                self._vehicle,
                self._grid,
                [Goal(*stop.tolist())],
                self._here,
                say=say,
                watch=self._note,
                pace=self._pace,
            )
            scans.append(look(self._client, room.pose_of(self._here) @ self._base_t_scanner))
        return scans

    def _note(self, pose: Floats) -> None:
        self._here = pose


def main(
    client: Client, seed: int = 1, pace: float = 0.0, stops: Sequence[Sequence[float]] = room.STOPS, quiet: bool = False
) -> Result:
    """Replace the world by a room, patrol it, print what is said, and return it.

    Args:
        client: of the kernel.
        seed: of what changes, and where.
        pace: simulated seconds for each second of the wall clock; 0: as fast as it can be.
        stops: poses (3,) from which it looks.
        quiet: go a round more first, in which nothing has changed.
    """
    client.clock.set_stepped()
    plot = room.plot_of(seed)
    mounted = room.build(client, room.ROOM)
    room.add(client, "stool", plot.stool)
    patrol = Patrol(client, mounted, stops, pace)
    before = patrol.round(lambda _: None)
    print(f"round 1: {len(before)} scans of {len(before[0].points):,} echoes are what the room is like", flush=True)
    calm = told(before, patrol.round(print), "round 2") if quiet else []
    room.add(client, "crate", plot.crate)
    client.scene.remove("stool")
    changes = told(before, patrol.round(print), f"round {2 + quiet}")
    truth = [(True, plot.crate), (False, plot.stool)]
    found = [any(is_it(change, *one) for change in changes) for one in truth]
    false = [change for change in changes if not any(is_it(change, *one) for one in truth)]
    print(f"found {sum(found)} of {len(truth)} changes, {len(false)} false alarms", flush=True)
    room.build(client, room.OTHER, (4.5, 7.5))
    other = ""
    try:
        told(before[:1], [look(client, before[0].world_t_sensor)], "another room")
    except OtherPlaceError as error:
        other = str(error)
        print(f"another room: {other}", flush=True)
    return Result(tuple(changes), sum(found), len(false), len(calm), other)


def look(client: Client, world_t_scanner: Floats) -> Scan:
    """Return a scan, made where the vehicle thinks that its scanner is (4, 4)."""
    return scan_of(client.sensors[room.SCANNER].read(points=True, frame="sensor").range, world_t_scanner)


def told(before: Sequence[Scan], now: Sequence[Scan], name: str) -> list[Change]:
    """Return and print what changed between scans of a round and those of the first, each thing once."""
    seen = [change for pair in zip(before, now, strict=True) for change in compare(*pair).changes]
    changes = sorted(once(seen), key=lambda one: -one.volume)
    for change in changes:
        print(f"{name}: {change}, {1e3 * change.volume:.0f} l", flush=True)
    if not changes:
        print(f"{name}: nothing has changed", flush=True)
    return changes


def once(changes: Sequence[Change]) -> list[Change]:
    """Return each thing of changes that stops tell once, as the stop tells it that has most points of it."""
    found: list[Change] = []
    for change in sorted(changes, key=lambda one: -one.points):
        if all(change.appeared != one.appeared or np.linalg.norm(change.place - one.place) > SAME for one in found):
            found.append(change)
    return found


def is_it(change: Change, appeared: bool, box: floors.Box) -> bool:
    """Return whether a change is that of a box that appeared, or is gone."""
    return change.appeared == appeared and bool(np.linalg.norm(change.place[:2] - (box.x, box.y)) < FOUND)
