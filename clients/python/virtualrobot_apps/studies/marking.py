"""Marks for exercises: scenes and lines that students hand in, by the same functions as studies.

An exercise file says what is given, what has to stay, and how many points each goal has.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.cell_io.yaml_file import Item, read_file
from virtualrobot_apps.studies.economy import earnings
from virtualrobot_apps.studies.flow import Flow, flow
from virtualrobot_apps.studies.line_file import Line, LineFile
from virtualrobot_apps.studies.parameters import generator
from virtualrobot_apps.studies.placement import margins
from virtualrobot_apps.studies.worlds import World, open_world

_FIELDS = ("schema_version", "task", "given", "layout", "line", "goals")
_LAYOUT = ("robot", "targets", "stays")
_LINE = ("hours", "warm_up", "runs", "seed", "stays")
_LAYOUT_GOALS = ("reached", "free", "margin")
_LINE_GOALS = (
    *("throughput", "lead_time", "inside", "scrapped", "investment", "piece_cost", "surplus", "payback"),
    "present_value",
)
_PARTS = ("cycle", "buffer", "machines", "failures", "scrap", "price")
_SAME = 1e-6
"""Difference of two poses, in any number of theirs, up to which a node has stayed (m or without unit)."""


@dataclass(frozen=True)
class Goal:
    """Goal of an exercise: a result that is to lie within bounds, and its points.

    Of a share (`reached`, `free`) without bounds, as large a part of the points counts.
    """

    result: str
    points: float
    least: float | None
    most: float | None

    def earned(self, value: float | None) -> float:
        """Return the points for a value; none where there is none."""
        if value is None or not math.isfinite(value):
            return 0.0
        if self.least is None and self.most is None:
            return self.points * value
        within = (self.least is None or value >= self.least) and (self.most is None or value <= self.most)
        return self.points if within else 0.0

    @property
    def said(self) -> str:
        """Return what is wanted, in words."""
        ends = [("at least", self.least), ("at most", self.most)]
        return " and ".join(f"{what} {_said(end)}" for what, end in ends if end is not None) or "all"


@dataclass(frozen=True)
class Mark:
    """Points for a goal: what is wanted, what was found, and how many of the points that are.

    Attributes:
        result: what the goal is about.
        wanted, found: in words.
        earned, points: those that it has brought, and all.
    """

    result: str
    wanted: str
    found: str
    earned: float
    points: float


class Exercise:
    """Exercise of a file.

    Attributes:
        task: the words for students.
        given: file that they begin with.
        goals: what earns points.
        robot, targets: of a layout, the robot's name, and those of the nodes at which its tool centre point shall be.
    """

    def __init__(self, file: Path) -> None:
        """Read it.

        Raises:
            MissingFileError: when it, or what it gives, isn't there.
            MalformedFileError: when it says something impossible; with file, line and what would be right.
        """
        root = read_file(file)
        fields = root.fields(_FIELDS, needed=("task", "given", "goals"))
        kinds = [kind for kind in ("layout", "line") if kind in fields]
        if len(kinds) != 1:
            raise root.error("either 'layout' or 'line' belongs here: what the exercise is about")
        self.task = fields["task"].text()
        self._is_line = kinds == ["line"]
        self._about = fields[kinds[0]].fields(
            _LINE if self._is_line else _LAYOUT, needed=() if self._is_line else ("robot", "targets")
        )
        self.given = file.absolute().parent / fields["given"].text()
        if not self.given.is_file():
            raise fields["given"].error(f"there is no file {self.given}")
        known = _LINE_GOALS if self._is_line else _LAYOUT_GOALS
        self.goals = tuple(_goal(name, item, known) for name, item in fields["goals"].mapping("goals").items())
        if not self.goals:
            raise fields["goals"].error("at least one belongs here")
        self.robot = "" if self._is_line else self._about["robot"].text()
        self.targets = [] if self._is_line else [one.text() for one in self._about["targets"].items()]
        self._stays = [one.text() for one in self._about["stays"].items()] if "stays" in self._about else []
        if self._is_line:
            for item, what in zip(self._about["stays"].items() if self._stays else [], self._stays, strict=True):
                if what not in ("source", "money") and what.partition(".")[2] not in _PARTS:
                    raise item.error(f"source, money or STATION.FIELD belongs here; fields are {', '.join(_PARTS)}")

    def marks(self, handed_in: Path, opened: Callable[[Path], World] = open_world) -> list[Mark]:
        """Return the points of what was handed in: a scene or a line, whichever the exercise is about.

        Without any where something has moved, or changed, that has to stay; `opened` gives the world of a scene.

        Raises:
            Exception: what is wrong in the file, in words.
        """
        changed, values = self._line(handed_in) if self._is_line else self._layout(handed_in, opened)
        found = []
        for goal in self.goals:
            value = values.get(goal.result)
            said = "none" if value is None else _said(value)
            found.append(
                Mark(goal.result, goal.said, changed or said, 0.0 if changed else goal.earned(value), goal.points)
            )
        return found

    def _layout(self, handed_in: Path, opened: Callable[[Path], World]) -> tuple[str, dict[str, float | None]]:
        given, world = opened(self.given), opened(handed_in)
        try:
            for name in dict.fromkeys([*self._stays, *self.targets]):
                try:
                    moved = np.abs(world.pose(name) - given.pose(name)).max() > _SAME
                except (VirtualRobotError, LookupError, ValueError) as error:
                    return f"{name!r} is not there: {error}", {}
                if moved:
                    return f"{name!r} has moved, and has to stay", {}
            poses = np.array([world.pose(name) for name in self.targets])
            found = world.postures(self.robot, poses)
            free = found.free & (not world.contacts(self.robot))
            each = np.where(free, margins(found, world.joint_limits(self.robot)), -np.inf)
            best = [max(each[found.target == one], default=-np.inf) for one in range(len(poses))]
            return "", {
                "reached": len(np.unique(found.target)) / len(poses),
                "free": len(np.unique(found.target[free])) / len(poses),
                "margin": float(min(best)) if min(best) > -np.inf else None,
            }
        finally:
            given.close()
            world.close()

    def _line(self, handed_in: Path) -> tuple[str, dict[str, float | None]]:
        given, line = LineFile(self.given).line({}), LineFile(handed_in).line({})
        if (changed := self._changed(given, line)) is not None:
            return changed, {}
        hours, warm_up = self._number("hours", 100.0, 0.01), self._number("warm_up", 0.0, 0.0)
        seed, runs = int(self._number("seed", 0.0, 0.0)), int(self._number("runs", 5.0, 1.0))
        flows = [
            flow(line.stations, generator(seed, number), 3600.0 * hours, 3600.0 * warm_up, line.source)
            for number in range(runs)
        ]
        return "", _means(line, flows)

    def _changed(self, given: Line, line: Line) -> str | None:
        """Return what of a line has to stay and has changed: `source`, `money`, or the cycle and so on of a station."""
        for what in self._stays:
            name, _, part = what.partition(".")
            if part:
                if _part(given, name, part) != _part(line, name, part):
                    return f"{part!r} of {name!r} has changed, and has to stay"
            elif name == "source" and given.source != line.source:
                return "'source' has changed, and has to stay"
            elif name == "money" and _conditions(given) != _conditions(line):
                return "'money' has changed, and has to stay"
        return None

    def _number(self, name: str, default: float, least: float) -> float:
        return self._about[name].number(least) if name in self._about else default


def _said(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 1e5 else f"{value:.6g}"


def _goal(name: str, item: Item, known: tuple[str, ...]) -> Goal:
    if name not in known:
        raise item.error(f"there is no goal {name!r}; these are {', '.join(known)}")
    fields = item.fields(("points", "least", "most"), needed=("points",))
    ends = [fields[one].number() if one in fields else None for one in ("least", "most")]
    if ends == [None, None] and name not in ("reached", "free"):
        raise item.error("'least' or 'most' belongs here: the bound that it has to keep")
    return Goal(name, fields["points"].number(0.0), ends[0], ends[1])


def _means(line: Line, flows: list[Flow]) -> dict[str, float | None]:
    """Return the means of all runs, by the names of goals."""
    times = [time for one in flows for time in one.lead_times]
    throughput = float(np.mean([one.throughput for one in flows]))
    scrapped = float(np.mean([one.waste for one in flows]))
    values: dict[str, float | None] = {
        "throughput": throughput,
        "lead_time": float(np.mean(times)) if times else None,
        "inside": float(np.mean([one.inside for one in flows])),
        "scrapped": scrapped,
    }
    if line.money is not None:
        values |= {"investment": line.money.investment}
        values |= vars(earnings(line.money, throughput, throughput + scrapped))
    return values


def _part(line: Line, name: str, part: str) -> list[object]:
    """Return a field of a station, in a list that is empty where there is no such station."""
    return [
        price if part == "price" else getattr(station, part)
        for station, price in zip(line.stations, line.prices, strict=True)
        if station.name == name
    ]


def _conditions(line: Line) -> object:
    """Return what of a line's money is no choice of who plans it."""
    return None if line.money is None else {**vars(line.money), "investment": None}
