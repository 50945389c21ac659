"""Spot welding: tongs that go to spots, close there, and weld."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from virtualrobot import Client, Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.along import AlongWays
from virtualrobot_apps.processes.leading import FIELDS, Leading, Led, read_leading
from virtualrobot_apps.processes.switching import Switch, read_switch
from virtualrobot_apps.processes.together import Together, read_together


@dataclass(frozen=True, slots=True, eq=False)
class SpotWeld:
    """Spot welding as a file describes it.

    Attributes:
        tongs: how they are led.
        switch: the signal that closes them and welds, and how long that takes.
        together: arms that weld spots along with it.
    """

    tongs: Leading
    switch: Switch
    together: tuple[Together[SpotWeld], ...] = ()
    what: str = "spot"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield the way to a spot."""
        yield self.tongs.stretch(way, name, "give a greater step")

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add the way to a spot and the weld to a program, and return how long that takes (s)."""
        program.call(path.program, name)
        self.switch.on(program)
        self.switch.off(program)
        return self.switch.longest("start_seconds")


def read_spot_weld(item: Item) -> SpotWeld:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields((*FIELDS, "spots", "tongs", "weld", "together"), ("robot", "spots", "speed", "tongs", "weld"))
    tongs = read_leading(fields, fields["spots"], fields["tongs"])
    if tongs.heading is None:
        raise fields["tongs"].error("tongs go along themselves: give the direction of their x, `heading: [1, 0, 0]`")
    for one in fields["spots"].items():
        if "spots" not in one.mapping():
            raise one.error("give `spots` with points and normal, or targets")
    weld = fields["weld"].fields(("signal", "seconds"), ("seconds",))
    seconds = weld["seconds"].number(0.001, 60.0)
    partners = read_together(item, "spots", read_spot_weld)
    others = tuple(one.work.switch for one in partners)
    return SpotWeld(tongs, replace(read_switch(weld.get("signal")), start_seconds=seconds, others=others), partners)


def _told(_: Client, work: SpotWeld, led: Led) -> tuple[str, ...]:
    return (f"{len(led.stretches)} spots, welded for {led.seconds:.2f} s in all",)


plan = AlongWays(lambda _, item: read_spot_weld(item), lambda work: work.tongs, _told, lambda work: work.together)
"""The plan of spot welding that a file describes."""
