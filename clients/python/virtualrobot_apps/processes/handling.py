"""Handling of parts in processes: how a robot grips one, and the places that a file lays out as on a pallet."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product

import numpy as np
from virtualrobot import Program, pose

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats
from virtualrobot_apps.processes.source import vector

MOST_PLACES = 10_000
"""Number of places at most: more is a mistake."""


@dataclass(frozen=True, slots=True, eq=False)
class Grip:
    """Hold of a robot on parts; lengths in m.

    Attributes:
        robot: its name.
        part_t_tcp: (4, 4) the tool centre point where it holds a part, in the frame of the part; z is into it.
        hold: the state of the tool in which it holds; None for none.
        release: the state in which it lets go; None for none.
        approach: the length of the line to a part or a place, and away from it.
        speed: on these lines (m/s).
        clear: how far above its place a part is let go.
    """

    robot: str
    part_t_tcp: Floats
    hold: str | None = None
    release: str | None = None
    approach: float = 0.1
    speed: float = 0.25
    clear: float = 0.001

    def pick(self, program: Program, part: str) -> None:
        """Add to a program that a part is taken from where it is then."""
        program.pick_at(
            self.robot,
            self.part_t_tcp,
            part,
            reference=part,
            approach=self.approach,
            state_before=self.release,
            state=self.hold,
            velocity=self.speed,
        )

    def place(self, program: Program, part: str, reference: str, reference_t_part: Floats) -> None:
        """Add to a program that a part is put down in the frame of a node, whose child it becomes."""
        program.place_at(
            self.robot,
            reference_t_part @ pose(z=self.clear) @ self.part_t_tcp,
            part,
            reference=reference,
            approach=self.approach,
            state=self.release,
            parent=reference,
            velocity=self.speed,
        )


GRIP_FIELDS = ("schema_version", "process", "robot", "parts", "grip", "tool", "approach", "speed", "clear")
"""Fields of a file that says how parts are handled."""


def read_grip(fields: dict[str, Item]) -> Grip:
    """Return how parts are held as a file says; raises MalformedFileError, with file and line, for what is wrong."""
    given = fields["grip"].fields(("at", "turn_degrees"), ("at",))
    turn = np.radians(given["turn_degrees"].number(-180.0, 180.0)) if "turn_degrees" in given else 0.0
    # The tool comes from above: its z is against that of the part.
    part_t_tcp = pose(*vector(given["at"]).tolist()) @ pose(yaw=float(turn)) @ pose(roll=np.pi)
    states = fields["tool"].fields(("hold", "release"), ("hold", "release")) if "tool" in fields else {}
    lengths = {
        name: fields[name].number(least, most)
        for name, least, most in (("approach", 1e-3, 2.0), ("speed", 1e-3, 10.0), ("clear", 0.0, 0.1))
        if name in fields
    }
    hold, release = (states[name].text() if name in states else None for name in ("hold", "release"))
    return Grip(fields["robot"].text(), part_t_tcp, hold, release, **lengths)


def read_parts(fields: dict[str, Item]) -> tuple[str, ...]:
    """Return the names of parts in a file; raises MalformedFileError for none, and for one that stands there twice."""
    found: list[str] = []
    for one in fields["parts"].items():
        if one.text() in found:
            raise one.error(f"{one.text()!r} is in the list already")
        found.append(one.text())
    if not found:
        raise fields["parts"].error("the name of a part belongs here")
    return tuple(found)


@dataclass(frozen=True, slots=True, eq=False)
class Pallet:
    """Places of parts in columns along x, rows along y and layers along z of a node, about its origin; lengths in m.

    Attributes:
        frame: the name of the node.
        counts: columns, rows, layers.
        pitch: (3,) from column to column, row to row, layer to layer.
        height: of the origin of a part in the first layer.
        turn: of every second layer about z (rad).
    """

    frame: str
    counts: tuple[int, int, int]
    pitch: Floats
    height: float = 0.0
    turn: float = 0.0
    places: Floats = field(init=False)

    def __post_init__(self) -> None:
        """Lay the places (n, 4, 4) out, layer by layer, row by row."""
        columns, rows, layers = self.counts
        found = []
        for layer, row, column in product(range(layers), range(rows), range(columns)):
            x, y = (column - 0.5 * (columns - 1)) * self.pitch[0], (row - 0.5 * (rows - 1)) * self.pitch[1]
            turned = pose(z=self.height + layer * self.pitch[2], yaw=self.turn * (layer % 2))
            found.append(turned @ pose(x, y))
        object.__setattr__(self, "places", np.array(found))


def read_pallet(item: Item) -> Pallet:
    """Return the places that a file lays out; raises MalformedFileError, with file and line, for what is wrong."""
    known = ("frame", "columns", "rows", "layers", "pitch", "height", "turn_degrees")
    given = item.fields(known, ("frame", "columns", "rows", "pitch"))
    counts = [given[name].whole(1, 1000) if name in given else 1 for name in ("columns", "rows", "layers")]
    if np.prod(counts) > MOST_PLACES:
        raise item.error(f"{int(np.prod(counts)):,} places; {MOST_PLACES:,} are the most")
    pitch = vector(given["pitch"])
    for count, apart, what in zip(counts, pitch.tolist(), ("columns", "rows", "layers"), strict=True):
        if count > 1 and apart <= 0.0:
            raise given["pitch"].error(f"{count} {what} are apart by more than {apart:g} m")
    height = given["height"].number(-10.0, 10.0) if "height" in given else 0.0
    turn = np.radians(given["turn_degrees"].number(-180.0, 180.0)) if "turn_degrees" in given else 0.0
    return Pallet(given["frame"].text(), (counts[0], counts[1], counts[2]), pitch, height, float(turn))


def enough(pallet: Pallet, parts: tuple[str, ...], item: Item) -> None:
    """Raise MalformedFileError where there are more parts than places."""
    if len(parts) > len(pallet.places):
        raise item.error(f"{len(parts)} parts, and {len(pallet.places)} places: add a layer, or leave parts out")
