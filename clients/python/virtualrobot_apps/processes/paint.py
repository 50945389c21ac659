"""Painting: a gun that goes over a surface in ways side by side, and the film that it leaves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from virtualrobot import Client, Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.along import AlongWays
from virtualrobot_apps.processes.effects.film import Film, Jet, sprayed
from virtualrobot_apps.processes.effects.growing import FilmGrowth
from virtualrobot_apps.processes.leading import FIELDS, Leading, Led, Stretch, read_leading
from virtualrobot_apps.processes.part import divided, part_mesh
from virtualrobot_apps.processes.showing import Effect, Passed, effects_of
from virtualrobot_apps.processes.switching import Switch, read_switch

FINE = 0.06
"""Longest edge of a triangle whose film is told, in parts of the jet's width."""
MOST_FACES = 500_000
WIDEST = np.radians(120.0)
"""Angle by which the widest jets of nozzles open, as their makers' lists have them."""
THIN = 0.5
"""Part of the mean thickness below which a film is thin."""


@dataclass(frozen=True, slots=True, eq=False)
class Paint:
    """Painting as a file describes it.

    Attributes:
        gun: how it is led; its standoff is the jet's.
        jet: what leaves it.
        switch: the signal that opens it.
    """

    gun: Leading
    jet: Jet
    switch: Switch
    what: str = "pass"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield the way."""
        yield self.gun.stretch(way, name)

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add a pass to a program, with the trigger, and return how long that is pulled (s)."""
        return self.switch.along(program, path, name)


def read_paint(item: Item) -> Paint:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields((*FIELDS, "ways", "gun", "jet", "trigger"), ("robot", "ways", "speed", "gun", "jet"))
    gun = read_leading(fields, fields["ways"], fields["gun"])
    if gun.standoff <= 0.0:
        raise fields["gun"].error("a gun sprays from a distance: give its `standoff` in m")
    jet = fields["jet"].fields(("width", "flow_millilitres", "solids"), ("width", "flow_millilitres"))
    width = jet["width"].number(1e-3, 2.0)
    opening = 2.0 * np.arctan2(0.5 * width, gun.standoff)
    if opening > WIDEST:
        raise fields["jet"].error(
            f"a disc of {1e3 * width:g} mm at a standoff of {1e3 * gun.standoff:g} mm would be a jet that opens by "
            f"{np.degrees(opening):.0f} degrees, and nozzles do so by {np.degrees(WIDEST):.0f} at the most: give a "
            "greater `standoff`, or a smaller `width`"
        )
    solids = jet["solids"].number(0.01, 1.0) if "solids" in jet else 1.0
    flow = 1e-6 * solids * jet["flow_millilitres"].number(1e-3, 1e3)
    return Paint(gun, Jet(width, gun.standoff, flow), read_switch(fields.get("trigger")))


def _told(client: Client, work: Paint, led: Led) -> tuple[str, ...]:
    told = [measure(parts, film) for parts, film in films(client, work, led)]
    return (*told, f"the gun sprays for {led.seconds:.2f} s")


def films(client: Client, work: Paint, led: Led) -> Iterator[tuple[tuple[str, ...], Film]]:
    """Yield the film on each of the parts that were painted, without what the passes over others leave there."""
    jet, trigger = work.jet, work.switch
    for parts, stretches in led.by_parts().items():
        mesh = part_mesh(client, parts)
        finer = divided(mesh, max(FINE * jet.width, (mesh.area / MOST_FACES) ** 0.5))
        yield parts, sprayed(finer, [with_stands(one, trigger) for one in stretches], jet)


def with_stands(stretch: Stretch, trigger: Switch) -> tuple[Floats, Floats]:
    """Return the frames (n, 4, 4) and times (n,) of a gun, with those that it stands at the ends of a pass."""
    frames, times = stretch.frames, stretch.times
    begin, end = times[0] - trigger.start_seconds, times[-1] + trigger.end_seconds
    return np.concatenate([frames[:1], frames, frames[-1:]]), np.concatenate([[begin], times, [end]])


def measure(parts: tuple[str, ...], film: Film) -> str:
    """Return a line about a film."""
    return (
        f"film on {', '.join(parts)}: {1e6 * film.mean:.3g} um in the mean, {1e6 * film.thickness.max():.3g} um at the "
        f"most, spread {100 * film.spread:.3g}%, {100 * film.thinner(THIN * film.mean):.3g}% of it thinner than "
        f"half the mean, {100 * film.overspray:.3g}% beside the part"
    )


def _effects(client: Client, work: Paint, led: Led) -> Iterator[Effect]:
    def growth(parts: tuple[str, ...], passes: list[Passed]) -> FilmGrowth:
        return FilmGrowth(client, parts, passes, work.jet)

    return effects_of(led, "film", growth, lambda one: with_stands(one, work.switch))


plan = AlongWays(lambda _, item: read_paint(item), lambda work: work.gun, _told, effects=_effects)
"""The plan of painting that a file describes."""
