"""Missions from a file: paths to follow and places to hold, one after the other.

schema_version: 1
steps:
  - follow: {points: [[0, 0, -2], [8, 0, -2], [8, 6, -3]], speed: 0.4}
  - hold: {seconds: 10}
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np

from virtualrobot_apps.cell_io.yaml_file import Item, read_file
from virtualrobot_apps.vehicles.guidance import Floats, Follower, Path, Wanted, held

FASTEST = 5.0
"""Greatest speed of a step (m/s)."""


@dataclass(frozen=True, eq=False)
class Follow:
    """Step along a path at a speed (m/s), seen from `look_ahead` (m)."""

    path: Path
    speed: float
    look_ahead: float = 0.5


@dataclass(frozen=True)
class Hold:
    """Step that keeps the place where it begins for some seconds."""

    seconds: float


Step = Follow | Hold


def read_mission(file: str | FilePath) -> list[Step]:
    """Return the steps of a mission's file; raises as `read_file` does, and MalformedFileError with the line."""
    root = read_file(file)
    fields = root.fields(("schema_version", "steps"), ("steps",))
    steps = [_step(item) for item in fields["steps"].items()]
    if not steps:
        raise fields["steps"].error("a mission has a step at least")
    return steps


def _step(item: Item) -> Step:
    fields = item.fields(("follow", "hold"))
    if len(fields) != 1:
        raise item.error("a step is one of follow and hold")
    ((kind, said),) = fields.items()
    if kind == "hold":
        return Hold(said.fields(("seconds",), ("seconds",))["seconds"].number(least=0.0))
    values = said.fields(("points", "speed", "look_ahead"), ("points", "speed"))
    points = [[number.number() for number in point.items()] for point in values["points"].items()]
    try:
        path = Path.through(np.array(points))
    except ValueError as error:
        raise values["points"].error(str(error)) from error
    look_ahead = values["look_ahead"].number(0.05, 100.0) if "look_ahead" in values else Follow.look_ahead
    return Follow(path, values["speed"].number(0.01, FASTEST), look_ahead)


class Mission:
    """Runs the steps of a mission: it is told where the vehicle is and says what is wanted."""

    def __init__(self, steps: list[Step]) -> None:
        """Begin before the first step."""
        self._steps = list(steps)
        self._follower: Follower | None = None
        self._place: Floats | None = None
        self._until = 0.0
        self._heading: float | None = None
        self.cross_track = math.nan
        """Distance from the path (m) at the last position; NaN where a step has none."""

    def wanted(self, now: float, position: Floats, heading: float) -> Wanted | None:
        """Return what is wanted at a time (s), a position (3,) and a heading (rad); None once the mission is done."""
        self.cross_track = math.nan
        self._heading = heading if self._heading is None else self._heading
        while self._steps:
            wanted = self._of_step(self._steps[0], now, position)
            if wanted is not None:
                self._heading = wanted.heading
                return wanted
            self._steps.pop(0)
            self._follower = self._place = None
        return None

    def _of_step(self, step: Step, now: float, position: Floats) -> Wanted | None:
        assert self._heading is not None
        if isinstance(step, Hold):
            if self._place is None:
                self._place, self._until = position, now + step.seconds
            return held(self._place, position, self._heading) if now < self._until else None
        if self._follower is None:
            self._follower = Follower(step.path, step.speed, step.look_ahead)
        wanted = self._follower.wanted(position, self._heading)
        self.cross_track = self._follower.cross_track
        return wanted
