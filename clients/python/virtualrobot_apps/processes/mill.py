"""Milling: what G-code cuts, by a spindle, at the feeds that it gives."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from virtualrobot import Client, Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item, read_text
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.along import AlongWays
from virtualrobot_apps.processes.effects.chips import Cutter, measures, read_cutter
from virtualrobot_apps.processes.leading import FIELDS, Leading, Led, check_frames, read_leading
from virtualrobot_apps.processes.showing import Effect, depths
from virtualrobot_apps.processes.source import beside
from virtualrobot_apps.processes.sources.corners import rounded
from virtualrobot_apps.processes.sources.gcode import read_gcode
from virtualrobot_apps.processes.switching import Switch, read_switch


@dataclass(frozen=True, slots=True, eq=False)
class Mill:
    """Milling as a file describes it.

    Attributes:
        cutter: how it is led; its speed is the fastest that it goes.
        feeds: the feed (m/s) of each cut, in their order: the least that the G-code gives on it.
        switch: the signal that turns it.
        solid: its size, by which chips are told; None: they are not.
    """

    cutter: Leading
    feeds: Iterator[float]
    switch: Switch
    solid: Cutter | None = None
    what: str = "cut"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield a cut at its feed."""
        frames = self.cutter.frames(way)
        check_frames(frames, way, "give a greater step or chord, or lift the cutter more often")
        yield name, way, frames, min(next(self.feeds), self.cutter.speed)

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add a cut to a program, with the spindle, which turns on; return how long that takes (s)."""
        return self.switch.on_along(program, path, name)


def read_mill(item: Item) -> Mill:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields(
        (*FIELDS, "cuts", "cutter", "spindle", "diameter", "length"), ("robot", "cuts", "speed", "cutter")
    )
    cutter = read_leading(fields, fields["cuts"], fields["cutter"])
    if cutter.heading is None:
        raise fields["cutter"].error("a cutter plunges along itself: give the direction of its x, `heading: [1, 0, 0]`")
    if "corners" not in fields:
        # A sharp one would be cut beyond: what is left in it is within the chord.
        chord = cutter.density.chord
        cutter = replace(cutter, corners=lambda way: [rounded(way, chord)])
    elif "lift" in fields["corners"].mapping():
        raise fields["corners"].error("a cutter is lifted where the G-code lifts it: give `round` or `loop`")
    feeds = list[float]()
    for source, one in zip(cutter.sources, fields["cuts"].items(), strict=True):
        given = one.mapping()
        if "gcode" not in given:
            raise one.error("cuts are of G-code: give its file by `gcode`")
        if source.near is not None or source.reverse:
            raise one.error("cuts are gone as the G-code has them, all of them: leave `near` and `reverse` out")
        file = beside(one, given["gcode"].text())
        for cut in read_gcode(read_text(file), file=str(file), chord=cutter.density.chord):
            if np.isnan(cut.feeds).any():
                raise given["gcode"].error(f"{file}:{cut.line}: this cut has no feed: give F, in mm/min")
            feeds.append(float(cut.feeds.min()))
    return Mill(replace(cutter, straight=True), iter(feeds), read_switch(fields.get("spindle")), read_cutter(fields))


def _told(client: Client, work: Mill, led: Led) -> tuple[str, ...]:
    work.switch.off(led.program)
    return (*measures(client, led, work.solid), f"cutting for {led.seconds:.2f} s")


def _effects(client: Client, work: Mill, led: Led) -> Iterator[Effect]:
    return depths(client, led, work.solid)


plan = AlongWays(lambda _, item: read_mill(item), lambda work: work.cutter, _told, effects=_effects)
"""The plan of milling that a file describes."""
