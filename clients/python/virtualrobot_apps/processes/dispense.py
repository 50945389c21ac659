"""Dispensing: beads of glue or sealant along ways, by a valve, with their volume."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from virtualrobot import Client, Program, ToolPath
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.along import AlongWays
from virtualrobot_apps.processes.leading import FIELDS, Leading, Led, read_leading
from virtualrobot_apps.processes.showing import Effect, beads
from virtualrobot_apps.processes.sources.offsets import offset
from virtualrobot_apps.processes.switching import Switch, read_switch


@dataclass(frozen=True, slots=True)
class Bead:
    """Bead that lies on a surface: a segment of a circle, `width` wide and `height` high (m)."""

    width: float
    height: float

    @property
    def area(self) -> float:
        """Its cross-section (m^2), that of a circular segment."""
        radius = (0.25 * self.width**2 + self.height**2) / (2.0 * self.height)
        # The half angle, beyond a quarter turn for a bead that is higher than half its width.
        half = math.atan2(0.5 * self.width, radius - self.height)
        return radius**2 * (half - math.sin(half) * math.cos(half))


@dataclass(frozen=True, slots=True, eq=False)
class Dispense:
    """Dispensing as a file describes it.

    Attributes:
        gun: how it is led along the ways.
        bead: what is laid.
        switch: the signal that opens it.
    """

    gun: Leading
    bead: Bead
    switch: Switch
    what: str = "bead"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield the way; raises InvalidArgumentError where it bends closer than half the bead is wide."""
        for side in (-0.5, 0.5):
            try:
                offset(way, side * self.bead.width)
            except InvalidArgumentError as error:
                raise InvalidArgumentError(
                    f"a bead {1e3 * self.bead.width:.4g} mm wide would run into itself: {error.message}"
                ) from None
        yield self.gun.stretch(way, name)

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add a bead to a program, and return how long the valve is open (s)."""
        return self.switch.along(program, path, name)


def read_dispense(item: Item) -> Dispense:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields((*FIELDS, "ways", "gun", "bead", "valve"), ("robot", "ways", "speed", "bead"))
    bead = fields["bead"].fields(("width", "height"), ("width", "height"))
    width = bead["width"].number(1e-5, 0.1)
    height = bead["height"].number(1e-5, 0.1)
    if height > width:
        raise bead["height"].error(
            f"a bead {width:g} m wide is at most as high as a ball of that size, not {height:g} m"
        )
    gun = read_leading(fields, fields["ways"], fields.get("gun"))
    return Dispense(gun, Bead(width, height), read_switch(fields.get("valve")))


def _told(_: Client, work: Dispense, led: Led) -> tuple[str, ...]:
    volume = 1e6 * work.bead.area * sum(one.way.length for one in led.stretches)
    flow = 1e6 * work.bead.area * work.gun.speed
    return (f"{volume:.3g} ml in beads, at {flow:.3g} ml/s, the valve open for {led.seconds:.2f} s",)


def _effects(_: Client, work: Dispense, led: Led) -> Iterator[Effect]:
    # As thick as a round one of that area.
    return beads(led, math.sqrt(work.bead.area / math.pi), work.gun.standoff)


plan = AlongWays(lambda _, item: read_dispense(item), lambda work: work.gun, _told, effects=_effects)
"""The plan of dispensing that a file describes."""
