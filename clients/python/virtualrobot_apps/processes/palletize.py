"""Palletizing: parts that are taken from where they stand and put onto the places of a pallet, layer by layer."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot import Client

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.processes.handling import (
    GRIP_FIELDS,
    Grip,
    Pallet,
    enough,
    read_grip,
    read_pallet,
    read_parts,
)
from virtualrobot_apps.processes.process import PlannedProcess


@dataclass(frozen=True, slots=True, eq=False)
class Palletize:
    """Palletizing as a file describes it.

    Attributes:
        grip: how parts are held.
        parts: their names, in their order.
        pallet: where they go.
    """

    grip: Grip
    parts: tuple[str, ...]
    pallet: Pallet


def read_palletize(item: Item) -> Palletize:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields((*GRIP_FIELDS, "pallet"), ("robot", "parts", "grip", "pallet"))
    parts, pallet = read_parts(fields), read_pallet(fields["pallet"])
    enough(pallet, parts, fields["parts"])
    return Palletize(read_grip(fields), parts, pallet)


def plan(client: Client, item: Item) -> PlannedProcess:
    """Return the plan of palletizing that a file describes, in the cell as it is.

    Raises MalformedFileError for what the file says wrong, and UnknownNameError for a robot that there is not.
    """
    work = read_palletize(item)
    robot, program = client.robot(work.grip.robot), client.program()
    for part, place in zip(work.parts, work.pallet.places, strict=False):
        work.grip.pick(program, part)
        work.grip.place(program, part, work.pallet.frame, place)
    program.move(robot.ptp(dict(zip(robot.joint_names, robot.positions.tolist(), strict=True))))
    columns, rows, _ = work.pallet.counts
    layers = -(-len(work.parts) // (columns * rows))
    free = len(work.pallet.places) - len(work.parts)
    told = f"{len(work.parts)} parts in {layers} layers of {columns} x {rows}, {free} places left free"
    return PlannedProcess(program, (told,))
