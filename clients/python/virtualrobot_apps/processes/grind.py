"""Grinding, polishing and deburring: a disc or a brush that a spring presses on edges and surfaces, several times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from virtualrobot import Client, Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.along import AlongWays
from virtualrobot_apps.processes.leading import FIELDS, Leading, Led, check_frames, read_leading
from virtualrobot_apps.processes.sources.frames import weave
from virtualrobot_apps.processes.switching import Switch, read_switch


@dataclass(frozen=True, slots=True, eq=False)
class Grind:
    """Grinding as a file describes it; lengths in m.

    Attributes:
        tool: how it is led; its standoff is how far the spring is pressed in, below 0.
        switch: the signal of its motor.
        strokes: how often each way is gone, every other time back.
        swing: width and length of waves from side to side; None without.
        force: of the spring (N); None where its stiffness is not told.
    """

    tool: Leading
    switch: Switch
    strokes: int = 1
    swing: tuple[float, float] | None = None
    force: float | None = None
    what: str = "way"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield the strokes on a way."""
        for stroke in range(self.strokes):
            here = way.reversed() if stroke % 2 else way
            frames = self.tool.frames(here)
            if self.swing is not None:
                frames = weave(frames, *self.swing, "sine")
            check_frames(frames, here, "give a greater step, or longer waves")
            yield name if self.strokes == 1 else f"{name}, stroke {stroke + 1}", here, frames, self.tool.speed

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add a stroke to a program, with the motor, and return how long that runs (s)."""
        return self.switch.along(program, path, name)


def read_grind(item: Item) -> Grind:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    known = (*FIELDS, "ways", "tool", "motor", "press", "stiffness", "strokes", "swing")
    fields = item.fields(known, ("robot", "ways", "speed"))
    tool = read_leading(fields, fields["ways"], fields.get("tool"))
    press = fields["press"].number(0.0, 0.05) if "press" in fields else 0.0
    if press and tool.standoff:
        raise fields["press"].error("a tool is pressed on, or stands off: leave one of both out")
    force = None
    if "stiffness" in fields:
        if not press:
            raise fields["stiffness"].error("the spring's stiffness (N/m) makes a force of `press` (m): give that, too")
        force = press * fields["stiffness"].number(1.0, 1e6)
    swing = None
    if "swing" in fields:
        waves = fields["swing"].fields(("width", "length"), ("width", "length"))
        swing = (waves["width"].number(1e-6, 0.2), waves["length"].number(1e-6, 1.0))
    strokes = fields["strokes"].whole(1, 100) if "strokes" in fields else 1
    pressed = replace(tool, standoff=tool.standoff - press)
    return Grind(pressed, read_switch(fields.get("motor")), strokes, swing, force)


def _told(_: Client, work: Grind, led: Led) -> tuple[str, ...]:
    pressed = "" if work.force is None else f", pressed on by {work.force:.3g} N"
    return (f"on its ways for {led.seconds:.2f} s{pressed}",)


plan = AlongWays(lambda _, item: read_grind(item), lambda work: work.tool, _told)
"""The plan of grinding that a file describes."""
