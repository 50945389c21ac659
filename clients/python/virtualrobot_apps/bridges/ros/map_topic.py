"""The map of a floor as a topic, as ROS's map_server tells it from the same files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.bridges.ros.hub import Hub, Topic
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, header, pose, time_of
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import make

if TYPE_CHECKING:
    from virtualrobot_apps.seeing.navigation.grid import Grid

NAME, TYPE = "/map", "nav_msgs/msg/OccupancyGrid"
FRAME = "map"
"""Frame of the map, as of map_server; who knows where the robot is in it tells where it is itself."""

OCCUPIED, FREE, UNKNOWN = 100, 0, -1
"""Values of cells; source: nav2_map_server, mode `trinary`."""


class MapTopic:
    """A map on a hub, latched, read anew whenever its files have changed."""

    def __init__(self, hub: Hub, file: Path, say: Callable[[str], None]) -> None:
        """Tell the map of a file .yaml with its picture beside it.

        Raises:
            MissingFileError, MalformedFileError: as `load` does.
        """
        from virtualrobot_apps.seeing.navigation.grid import load  # by scipy, which bridges without a map don't need

        self._hub, self._file, self._say, self._load = hub, file, say, load
        self._told = self._age()
        grid = load(file)
        hub.declare(Topic(NAME, TYPE, latched=True, is_told=True))
        self._tell(grid)

    def update(self) -> None:
        """Tell the map anew where its files are others; what is wrong with them is said, and the last one stays."""
        if (age := self._age()) == self._told:
            return
        self._told = age
        try:
            self._tell(self._load(self._file))
        except VirtualRobotError as error:
            self._say(f"{NAME}: {error}")

    def _age(self) -> list[int]:
        """Return when the map's file and the pictures beside it were written (ns)."""
        files = (self._file, *sorted(self._file.parent.glob("*.pgm")))
        return [one.stat().st_mtime_ns for one in files if one.is_file()]

    def _tell(self, grid: Grid) -> None:
        self._hub.publish(NAME, Message(TYPE, message_of(grid, self._hub.now), self._hub.now))


def message_of(grid: Grid, nanoseconds: int) -> RosValue:
    """Return the message of a grid: rows from the lower left corner on, which is its origin."""
    cells = np.full(grid.log_odds.shape, UNKNOWN, np.int8)
    cells[grid.occupied], cells[grid.free] = OCCUPIED, FREE
    info = make(
        "nav_msgs/msg/MapMetaData",
        map_load_time=time_of(nanoseconds),
        resolution=float(grid.resolution),
        width=cells.shape[1],
        height=cells.shape[0],
        origin=pose([*map(float, grid.origin), 0.0, 0.0, 0.0, 0.0, 1.0]),
    )
    return make(TYPE, header=header(nanoseconds, FRAME), info=info, data=cells.ravel())
