"""Cutting by laser, plasma or water: ways beside which half a kerf is left, and a hole that is pierced first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from virtualrobot import Client, Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.leading import FIELDS, Leading, lead, read_leading
from virtualrobot_apps.processes.process import PlannedProcess
from virtualrobot_apps.processes.sources.offsets import offset
from virtualrobot_apps.processes.switching import Switch, read_switch

SIDES = {"left": 0.5, "middle": 0.0, "right": -0.5}
"""Sides of a way: places of the beam beside it, in parts of the kerf, to the left seen from outside and along it."""


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """Cutting as a file describes it.

    Attributes:
        head: how it is led.
        beam: its signal; it stands at the beginning until the beam is through.
        kerf: the width (m) of what the beam takes away.
        side: of the way that the kerf is on, one of `SIDES`.
    """

    head: Leading
    beam: Switch
    kerf: float = 0.0
    side: str = "middle"
    what: str = "cut"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield what the beam goes along; raises InvalidArgumentError where the way bends closer than half a kerf."""
        across = SIDES[self.side] * self.kerf
        yield self.head.stretch(offset(way, across) if across else way, name)

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add a cut to a program, with the beam, and return how long that is on (s)."""
        return self.beam.along(program, path, name)


def read_cut(item: Item) -> Cut:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields((*FIELDS, "cuts", "head", "beam", "kerf", "side"), ("robot", "cuts", "speed"))
    kerf = fields["kerf"].number(0.0, 0.05) if "kerf" in fields else 0.0
    side = fields["side"].one_of(tuple(SIDES)) if "side" in fields else "middle"
    if side != "middle" and not kerf:
        raise fields["side"].error("what is left beside a cut is half its kerf: give `kerf` in m")
    head = read_leading(fields, fields["cuts"], fields.get("head"))
    return Cut(head, read_switch(fields.get("beam")), kerf, side)


def plan(client: Client, item: Item) -> PlannedProcess:
    """Return the plan of cutting that a file describes, in the cell as it is; raises what `lead` raises."""
    work = read_cut(item)
    led = lead(client, work.head, work)
    return led.with_measures(f"the beam is on for {led.seconds:.2f} s")
