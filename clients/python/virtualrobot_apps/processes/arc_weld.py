"""Arc welding: seams on edges of parts or along other sources, the torch by work and travel angle, and a weave."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from virtualrobot import Client, Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.along import AlongWays
from virtualrobot_apps.processes.leading import FIELDS, Leading, Led, check_frames, read_leading
from virtualrobot_apps.processes.showing import Effect, beads
from virtualrobot_apps.processes.sources.frames import WAVES, weave
from virtualrobot_apps.processes.sources.offsets import offset
from virtualrobot_apps.processes.switching import Switch, read_switch
from virtualrobot_apps.processes.together import Together, read_together

WIRE = 0.0025
"""Radius (m) of a bead as it is shown: how thick one is, a file doesn't say."""


@dataclass(frozen=True, slots=True, eq=False)
class ArcWeld:
    """Arc welding as a file describes it; lengths in m.

    Attributes:
        torch: how the torch is led along the seams.
        weave: width, length and shape; None without.
        passes: offsets (across, away) of each pass.
        switch: the signal that is true while the arc burns, at the end until the crater is filled.
        together: arms that weld along with it.
    """

    torch: Leading
    weave: tuple[float, float, str] | None = None
    passes: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    switch: Switch = field(default_factory=Switch)
    together: tuple[Together[ArcWeld], ...] = ()
    what: str = "seam"

    def frames(self, way: Way) -> tuple[Floats, float]:
        """Return the frames (n, 4, 4) of the torch along a way, and its speed along them (m/s).

        With a weave it is as much faster as its way is longer, so that the seam is welded at the speed that is wanted.

        Raises InvalidArgumentError for what `Leading.frames` and `weave` refuse, and for too many frames.
        """
        frames, speed = self.torch.frames(way), self.torch.speed
        if self.weave is not None:
            straight = _length(frames)
            frames = weave(frames, *self.weave)
            speed *= _length(frames) / straight
        check_frames(
            frames, way, "make the waves longer or the seam shorter" if self.weave else "give a greater step or chord"
        )
        return frames, speed

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield the passes of a seam."""
        for layer, beside in enumerate(self.passes, 1):
            here = offset(way, *beside) if any(beside) else way
            yield name if len(self.passes) == 1 else f"{name}, pass {layer}", here, *self.frames(here)

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add a seam to a program, with the arc, and return how long that burns (s)."""
        return self.switch.along(program, path, name)


def read_weld(item: Item) -> ArcWeld:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields((*FIELDS, "seams", "torch", "weave", "passes", "arc", "together"), ("robot", "seams", "speed"))
    found: dict[str, object] = {}
    if "weave" in fields:
        given = fields["weave"].fields(("width", "length", "shape"), ("width", "length"))
        shape = given["shape"].one_of(tuple(WAVES)) if "shape" in given else "sine"
        found["weave"] = (given["width"].number(1e-6, 0.1), given["length"].number(1e-6, 1.0), shape)
    found["together"] = partners = read_together(item, "seams", read_weld)
    arc = read_switch(fields.get("arc"))
    found["switch"] = replace(arc, others=tuple(one.work.switch for one in partners))
    if "passes" in fields:
        found["passes"] = tuple(_pass(one) for one in fields["passes"].items())
        if not found["passes"]:
            raise fields["passes"].error("a pass belongs here: [across, away] in m")
    torch = read_leading(fields, fields["seams"], fields.get("torch"))
    return ArcWeld(torch, **found)  # pyright: ignore[reportArgumentType] each by its name


def _told(_: Client, work: ArcWeld, led: Led) -> tuple[str, ...]:
    return (f"arc on for {led.seconds:.2f} s",)


def _effects(_: Client, work: ArcWeld, led: Led) -> Iterator[Effect]:
    return beads(led, WIRE, work.torch.standoff)


plan = AlongWays(lambda _, item: read_weld(item), lambda work: work.torch, _told, lambda work: work.together, _effects)
"""The plan of arc welding that a file describes."""


def _pass(item: Item) -> tuple[float, float]:
    values = [one.number(-1.0, 1.0) for one in item.items()]
    if len(values) != 2:
        raise item.error("two lengths in m belong here: to the left across the seam, and out of it")
    return values[0], values[1]


def _length(frames: Floats) -> float:
    return float(np.linalg.norm(np.diff(frames[:, :3, 3], axis=0), axis=1).sum())
