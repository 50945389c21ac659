"""A map as a topic: of a floor as map_server tells it from the same files, or an octree as octomap_server does."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from virtualrobot.errors import MalformedFileError, MissingFileError, VirtualRobotError

from virtualrobot_apps.bridges.ros.hub import Hub, Topic
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, header, pose, time_of
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import make

if TYPE_CHECKING:
    from virtualrobot_apps.seeing.navigation.grid import Grid

NAME, TYPE = "/map", "nav_msgs/msg/OccupancyGrid"
FRAME = "map"
"""Frame of the map, as of map_server; who knows where the robot is in it tells where it is itself."""

OCTREE = "octomap_msgs/msg/Octomap"
OCTREES = {
    ".bt": ("/octomap_binary", "# Octomap OcTree binary file"),
    ".ot": ("/octomap_full", "# Octomap OcTree file"),
}
"""Names, as octomap_server's, and first lines of OctoMap's files by their endings; `virtualrobot map` writes them."""

_MOST_HEAD = 1000

OCCUPIED, FREE, UNKNOWN = 100, 0, -1
"""Values of cells; source: nav2_map_server, mode `trinary`."""


class MapTopic:
    """A map on a hub, latched, read anew whenever its files have changed.

    Attributes:
        name, type: of the topic.
    """

    def __init__(self, hub: Hub, file: Path, say: Callable[[str], None]) -> None:
        """Tell the map of a file .yaml with its picture beside it, or of an octree (.bt, .ot).

        Raises:
            MissingFileError, MalformedFileError: as `load` does.
        """
        self._hub, self._file, self._say = hub, file, say
        if file.suffix in OCTREES:
            self.name, self.type, self._read = OCTREES[file.suffix][0], OCTREE, octree_of
        else:
            from virtualrobot_apps.seeing.navigation.grid import load  # by scipy, which bridges without one don't need

            self.name, self.type = NAME, TYPE
            self._read = lambda file, time: message_of(load(file), time)
        self._told = self._age()
        value = self._read(file, hub.now)
        hub.declare(Topic(self.name, self.type, latched=True, is_told=True))
        self._tell(value)

    def update(self) -> None:
        """Tell the map anew where its files are others; what is wrong with them is said, and the last one stays."""
        if (age := self._age()) == self._told:
            return
        self._told = age
        try:
            self._tell(self._read(self._file, self._hub.now))
        except VirtualRobotError as error:
            self._say(f"{self.name}: {error}")

    def _age(self) -> list[int]:
        """Return when the map's file and the pictures beside it were written (ns)."""
        files = (self._file, *sorted(self._file.parent.glob("*.pgm")))
        return [one.stat().st_mtime_ns for one in files if one.is_file()]

    def _tell(self, value: RosValue) -> None:
        self._hub.publish(self.name, Message(self.type, value, self._hub.now))


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


def octree_of(file: Path, nanoseconds: int) -> RosValue:
    """Return the message of OctoMap's file: what stands behind its head is what octomap_msgs carries, in `world`.

    Raises:
        MissingFileError, MalformedFileError: when it can't be read, or is none.
    """
    try:
        data = file.read_bytes()
    except OSError as error:
        raise MissingFileError(f"there is no map {str(file)!r}: {error.strerror}") from error
    head, found, rest = data.partition(b"\ndata\n")
    lines = head[:_MOST_HEAD].decode("latin-1").splitlines()
    fields = dict(line.split(" ", 1) for line in lines if " " in line and not line.startswith("#"))
    try:
        resolution = float(fields["res"])
        if not found or lines[0] != OCTREES[file.suffix][1] or not 0.0 < resolution < math.inf:
            raise ValueError
    except (ValueError, KeyError, IndexError) as error:
        raise MalformedFileError(
            f"{str(file)!r} is no octree of OctoMap: it begins with {OCTREES[file.suffix][1]!r}, id, size, res and data"
        ) from error
    return make(
        OCTREE,
        **{"header": header(nanoseconds, "world"), "binary": file.suffix == ".bt", "id": fields.get("id", "OcTree")},
        **{"resolution": resolution, "data": np.frombuffer(rest, np.int8)},
    )
