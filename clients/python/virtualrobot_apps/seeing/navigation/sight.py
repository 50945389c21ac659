"""Sight of a vehicle: its lidar is watched, that it doesn't drive on where the lidar tells nothing any more."""

from __future__ import annotations

from typing import Protocol

from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.matching import FEWEST
from virtualrobot_apps.seeing.navigation.poses import Floats, moved
from virtualrobot_apps.seeing.navigation.scans import Scan

SILENT_SECONDS = 0.7
"""Time without a scan after which a vehicle stands."""
WALLS_ABOUT = 0.15
"""Part of all directions with walls of the map in the lidar's reach, from which on it is blind without echoes."""
ALONE_METERS = 10.0
"""Way by odometry alone after which a vehicle gives up."""


class Where(Protocol):
    """Teller of where a vehicle is: `Mapper` and `Localiser`."""

    grid: Grid

    @property
    def lost(self) -> bool:
        """Return whether that is unknown."""
        ...

    def at(self, odometry: Floats) -> Floats:
        """Return the pose (3,) when odometry says this (3,)."""
        ...

    @property
    def doubt(self) -> str:
        """Return in words why that is unknown."""
        ...

    def update(self, scan: Scan) -> Floats:
        """Take in a scan; return the pose (3,) when it was made."""
        ...


class Sight:
    """Watch over one lidar: the time of its last scan with echoes, where there should be some, and the way since."""

    def __init__(self, lidar: str, reach: float) -> None:
        """Take the name of a lidar and how far it sees (m); 0: nobody knows."""
        self.lidar, self._reach = lidar, reach
        self.since: float | None = None
        """Time (s) of the last scan that was not blind; None: none yet."""
        self.nothing = False
        """True: the last scan had hardly an echo."""
        self.alone = 0.0
        """Way (m) by odometry since a scan had echoes."""
        self._scanned: float | None = None
        self._fault = ""

    def goes(self, meters: float) -> None:
        """Take in a stretch of way by odometry."""
        self.alone = self.alone + meters if self.nothing else 0.0

    def takes(self, scan: Scan, where: Where) -> bool:
        """Return whether a scan tells something: echoes, or that nothing is where the map has nothing either."""
        self._scanned, self.nothing, self._fault = scan.time, len(scan.points) < FEWEST, ""
        if self.nothing:
            place = moved(where.at(scan.odometry), scan.origin[None])[0]
            if where.lost:
                self._fault = f"the scans of {self.lidar!r} have hardly an echo"
            elif where.grid.about(place, self._reach) > WALLS_ABOUT:
                self._fault = f"the scans of {self.lidar!r} have hardly an echo though the map has walls in its reach"
        if not self._fault:
            self.since = scan.time
        return not self._fault

    def fault(self, now: float) -> str | None:
        """Return why it can't drive now, in words; None where it can."""
        if self._scanned is None or now - self._scanned > SILENT_SECONDS:
            return f"no scan of {self.lidar!r} comes"
        return self._fault or None
