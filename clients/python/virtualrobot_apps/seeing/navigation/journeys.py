"""Journeys of one vehicle in a kernel: it explores a floor, or goes to goals on the map of one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.pace import Pace
from virtualrobot_apps.seeing.navigation.exploring import Explorer, Unseen
from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.localising import Localiser
from virtualrobot_apps.seeing.navigation.mapping import Mapper
from virtualrobot_apps.seeing.navigation.navigator import Goal, Navigator, Observation
from virtualrobot_apps.seeing.navigation.poses import Floats
from virtualrobot_apps.seeing.navigation.vehicle import PERIOD, Drive, Vehicle

LONGEST = 1800.0
"""Simulation time (s) after which an exploration ends."""
Watch = Callable[[Floats], object]


@dataclass(frozen=True, slots=True, eq=False)
class Explored:
    """Floor that was explored: its map with how it was made, and edges of it that stay unseen, with the reasons."""

    mapper: Mapper
    unseen: tuple[Unseen, ...]


class ExplorationInterrupted(KeyboardInterrupt):
    """Interrupt of an exploration; `mapper` has the map so far."""

    def __init__(self, mapper: Mapper) -> None:
        """Keep the map so far."""
        super().__init__("the exploration is interrupted")
        self.mapper = mapper


def explore(
    client: Client,
    vehicle: Vehicle,
    start: Floats,
    *,
    resolution: float = 0.05,
    say: Callable[[str], object] = print,
    watch: Watch = lambda _: None,
    pace: float = 0.0,
    longest: float = LONGEST,
) -> Explored:
    """Explore a floor until nothing is left that can be seen, or for a time (s).

    Args:
        client: of the kernel; its clock is held meanwhile.
        vehicle: what drives.
        start: (3,) its pose in the frame that the map is to have, x, y (m) and heading (rad).
        resolution: edge of a cell (m).
        say: told each decision.
        watch: told the pose (3,) that the vehicle thinks it has, once a period.
        pace: simulated seconds for each second of the wall clock; 0: as fast as it can be.
        longest: simulation time (s).

    Raises:
        ExplorationInterrupted: at an interrupt, once the vehicle stands, with the map so far.
        WrongStateError: where no scan comes, or none with echoes, by which a map could begin.
    """
    mapper = Mapper(start, resolution)
    navigator = Navigator(mapper, vehicle.footprint, say=say, reach=vehicle.reach, lidar=vehicle.lidar)
    explorer = Explorer(navigator, mapper, vehicle.reach)
    try:
        with Drive(client, [vehicle]) as drive:
            loop = _Loop(drive, vehicle, navigator, watch, pace)
            while mapper.grid.log_odds.size == 0:
                loop.period()
                if navigator.last_time - loop.begun > 5.0:
                    raise WrongStateError(
                        f"no scan of {vehicle.lidar!r} has come for 5 s"
                        if not loop.scanned
                        else f"the scans of {vehicle.lidar!r} have hardly an echo: nothing stands in its reach to be "
                        "mapped"
                    )
            explorer.run(loop.period, longest)
    except KeyboardInterrupt as interrupt:
        if mapper.grid.log_odds.size == 0:
            raise
        raise ExplorationInterrupted(mapper) from interrupt
    for edge in explorer.unseen:
        say(str(edge))
    return Explored(mapper, tuple(explorer.unseen))


def go(
    client: Client,
    vehicle: Vehicle,
    grid: Grid,
    goals: Sequence[Goal],
    start: Floats | None = None,
    *,
    say: Callable[[str], object] = print,
    watch: Watch = lambda _: None,
    pace: float = 0.0,
) -> list[bool]:
    """Go to goals on a map, one after the other; return which of them were reached.

    Args:
        client: of the kernel; its clock is held meanwhile.
        vehicle: what drives.
        grid: the map.
        goals: where to.
        start: (3,) its pose in the map; None: it looks for its place first.
        say: told each decision.
        watch: told the pose (3,) that the vehicle thinks it has, once a period.
        pace: simulated seconds for each second of the wall clock; 0: as fast as it can be.
    """
    navigator = Navigator(Localiser(grid, start), vehicle.footprint, say=say, reach=vehicle.reach, lidar=vehicle.lidar)
    reached = []
    with Drive(client, [vehicle]) as drive:
        loop = _Loop(drive, vehicle, navigator, watch, pace)
        for goal in goals:
            navigator.go(goal)
            while navigator.end is None:
                loop.period()
            reached.append(navigator.reached)
    return reached


class _Loop:
    """One period after the other: what is seen goes to the navigator, what it says to the vehicle."""

    def __init__(self, drive: Drive, vehicle: Vehicle, navigator: Navigator, watch: Watch, pace: float) -> None:
        self._drive, self._name, self._navigator, self._watch = drive, vehicle.name, navigator, watch
        self._pace, self._periods = Pace(pace), 0
        self._twist, self.scanned = (0.0, 0.0), False
        self.begun = drive.client.clock.read().stamp.simulation_time

    def period(self) -> None:
        seen: Observation = self._drive.step({self._name: self._twist})[self._name]
        self.scanned |= seen.scan is not None
        self._twist = self._navigator.step(seen)
        self._watch(self._navigator.pose)
        self._periods += 1
        self._pace.keep(self._periods * PERIOD)


def pose_of(numbers: tuple[float, float, float]) -> Floats:
    """Return the pose (3,) of x, y (m) and a heading in degrees."""
    return np.array([numbers[0], numbers[1], np.radians(numbers[2])])
