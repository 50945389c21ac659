"""Ways that a tool follows, with a signal that is true along them: cutting, dispensing, scanning."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from virtualrobot import Client, Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.along import AlongWays
from virtualrobot_apps.processes.leading import FIELDS, Leading, Led, read_leading
from virtualrobot_apps.processes.switching import Switch, read_switch


@dataclass(frozen=True, slots=True, eq=False)
class Follow:
    """Ways that a tool follows as a file describes them.

    Attributes:
        tool: how it is led.
        switch: the signal that is true along each way.
    """

    tool: Leading
    switch: Switch = field(default_factory=Switch)
    what: str = "way"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield the way."""
        yield self.tool.stretch(way, name)

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add the way to a program, with the signal, and return how long it takes (s)."""
        return self.switch.along(program, path, name)


def read_follow(item: Item) -> Follow:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields((*FIELDS, "ways", "tool", "signal"), ("robot", "ways", "speed"))
    return Follow(read_leading(fields, fields["ways"], fields.get("tool")), read_switch(fields.get("signal")))


def _told(_: Client, work: Follow, led: Led) -> tuple[str, ...]:
    return (f"on its ways for {led.seconds:.2f} s",)


plan = AlongWays(lambda _, item: read_follow(item), lambda work: work.tool, _told)
"""The plan of ways that a file describes."""
