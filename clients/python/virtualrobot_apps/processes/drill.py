"""Drilling: holes along the normals of a surface, by a spindle, in pecks where they are deep."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from virtualrobot import Client, Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.along import AlongWays
from virtualrobot_apps.processes.effects.chips import Cutter, measures, read_cutter
from virtualrobot_apps.processes.leading import FIELDS, Leading, Led, read_leading
from virtualrobot_apps.processes.showing import Effect, depths
from virtualrobot_apps.processes.switching import Switch, read_switch


@dataclass(frozen=True, slots=True, eq=False)
class Drill:
    """Drilling as a file describes it.

    Attributes:
        drill: how it is led.
        switch: the signal that turns it.
        solid: its size, by which chips are told; None: they are not.
    """

    drill: Leading
    switch: Switch
    solid: Cutter | None = None
    what: str = "hole"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield the way into a hole."""
        yield self.drill.stretch(way, name, "give a greater step")

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add a way into a hole to a program, with the spindle, which turns on; return how long that takes (s)."""
        return self.switch.on_along(program, path, name)


def read_drill(item: Item) -> Drill:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields(
        (*FIELDS, "holes", "drill", "spindle", "diameter", "length"), ("robot", "holes", "speed", "drill")
    )
    drill = read_leading(fields, fields["holes"], fields["drill"])
    if drill.heading is None:
        raise fields["drill"].error("a drill goes along itself: give the direction of its x, `heading: [1, 0, 0]`")
    solid = read_cutter(fields)
    for one in fields["holes"].items():
        given = one.mapping()
        if "spots" not in given:
            raise one.error("holes are at spots: give `spots` with points and normal, or targets, and their depth")
        spots = given["spots"].mapping()
        depth = spots["depth"].number() if "depth" in spots else 0.0
        if depth <= 0.0:
            raise given["spots"].error("a hole has a `depth` in m above 0")
        if drill.approach <= depth:
            raise given["spots"].error(
                f"a hole {depth:g} m deep is left by more than that: give a longer `approach` than {drill.approach:g} m"
            )
        if solid is not None and solid.length < depth:
            raise given["spots"].error(
                f"a hole {depth:g} m deep needs a drill that is at least as long, not {solid.length:g} m"
            )
    return Drill(replace(drill, straight=True), read_switch(fields.get("spindle")), solid)


def _told(client: Client, work: Drill, led: Led) -> tuple[str, ...]:
    work.switch.off(led.program)
    ways = f"{len(led.stretches)} ways into holes, drilling for {led.seconds:.2f} s"
    return (*measures(client, led, work.solid), ways)


def _effects(client: Client, work: Drill, led: Led) -> Iterator[Effect]:
    return depths(client, led, work.solid)


plan = AlongWays(lambda _, item: read_drill(item), lambda work: work.drill, _told, effects=_effects)
"""The plan of drilling that a file describes."""
