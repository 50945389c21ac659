"""Ways that a tool follows, with a signal that is true along them: cutting, dispensing, scanning."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from virtualrobot import Client, Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.leading import FIELDS, Leading, check_frames, lead, read_leading
from virtualrobot_apps.processes.process import PlannedProcess


@dataclass(frozen=True, slots=True, eq=False)
class Follow:
    """Ways that a tool follows as a file describes them.

    Attributes:
        tool: how it is led.
        signal: the signal that is true along each way; None without.
    """

    tool: Leading
    signal: str | None = None
    what: str = "way"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield the way."""
        frames = self.tool.frames(way)
        check_frames(frames, way, "give a greater step or chord")
        yield name, way, frames, self.tool.speed

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add the way to a program, with the signal, and return how long it takes (s)."""
        if self.signal is not None:
            program.set(self.signal, True)
        program.call(path.program, name)
        if self.signal is not None:
            program.set(self.signal, False)
        return path.duration


def plan(client: Client, item: Item) -> PlannedProcess:
    """Return the plan of what a file describes, in the cell as it is; raises what `lead` raises."""
    fields = item.fields((*FIELDS, "ways", "tool", "signal"), ("robot", "ways", "speed"))
    tool = read_leading(fields, fields["ways"], fields.get("tool"))
    follow = Follow(tool, fields["signal"].text() if "signal" in fields else None)
    planned, working = lead(client, tool, follow)
    return PlannedProcess(planned.program, (*planned.measures, f"on its ways for {working:.2f} s"))
