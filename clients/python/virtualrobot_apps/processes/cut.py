"""Cutting by laser, plasma or water: ways beside which half a kerf is left, and a hole that is pierced first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from virtualrobot import Client, Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.along import AlongWays
from virtualrobot_apps.processes.leading import FIELDS, Leading, Led, read_leading
from virtualrobot_apps.processes.sources.offsets import offset
from virtualrobot_apps.processes.switching import Switch, read_switch

SIDES = {"left": 0.5, "middle": 0.0, "right": -0.5}
"""Sides of a way: places of the beam beside it, in parts of the kerf, to the left seen from outside and along it."""


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """Cutting as a file describes it.

    Attributes:
        head: how it is led.
        switch: its signal; it stands at the beginning until the beam is through.
        kerf: the width (m) of what the beam takes away.
        side: of the way that the kerf is on, one of `SIDES`.
        thickness: of what is cut (m); 0 where it is not told.
    """

    head: Leading
    switch: Switch
    kerf: float = 0.0
    side: str = "middle"
    thickness: float = 0.0
    what: str = "cut"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield what the beam goes along; raises InvalidArgumentError where the way bends closer than half a kerf."""
        across = SIDES[self.side] * self.kerf
        yield self.head.stretch(offset(way, across) if across else way, name)

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add a cut to a program, with the beam, and return how long that is on (s)."""
        return self.switch.along(program, path, name)


def read_cut(item: Item) -> Cut:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields((*FIELDS, "cuts", "head", "beam", "kerf", "side", "thickness"), ("robot", "cuts", "speed"))
    kerf = fields["kerf"].number(0.0, 0.05) if "kerf" in fields else 0.0
    side = fields["side"].one_of(tuple(SIDES)) if "side" in fields else "middle"
    if side != "middle" and not kerf:
        raise fields["side"].error("what is left beside a cut is half its kerf: give `kerf` in m")
    thickness = fields["thickness"].number(1e-5, 1.0) if "thickness" in fields else 0.0
    if thickness and not kerf:
        raise fields["thickness"].error("what is cut away is as wide as the kerf: give `kerf` in m")
    head = read_leading(fields, fields["cuts"], fields.get("head"))
    return Cut(head, read_switch(fields.get("beam")), kerf, side, thickness)


def _told(_: Client, work: Cut, led: Led) -> tuple[str, ...]:
    told = [f"the beam is on for {led.seconds:.2f} s"]
    if work.thickness:
        away = 1e6 * work.kerf * work.thickness * sum(one.way.length for one in led.stretches)
        told.append(f"{away:.4g} cm^3 are cut away")
    return tuple(told)


plan = AlongWays(lambda _, item: read_cut(item), lambda work: work.head, _told)
"""The plan of cutting that a file describes."""
