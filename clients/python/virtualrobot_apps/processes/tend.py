"""Tending of a machine with a door and axes: a part is put in, the machine works on it, and it is taken out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from virtualrobot import Client, Program, pose

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats
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
from virtualrobot_apps.processes.source import vector
from virtualrobot_apps.processes.switching import Switch, read_switch

Places = dict[str, float]
"""Places of joints by their names, in rad or m."""


@dataclass(frozen=True, slots=True, eq=False)
class Machine:
    """Machine: a robot of the cell with a door and axes.

    Attributes:
        name: of the robot.
        opened: where the joints of its door are for a part to come in.
        closed: where they are while it works.
        cycle: where its axes go, one after the other, while it works.
        running: the signal of its work; it stands for these times before its axes go and behind.
        chuck: the node that holds a part.
        at: (3,) where the origin of a part is then, in the frame of the chuck (m).
    """

    name: str
    opened: Places
    closed: Places
    cycle: tuple[Places, ...]
    running: Switch
    chuck: str
    at: Floats

    def work(self, client: Client, program: Program) -> None:
        """Add to a program that the door closes, the axes go, and the door opens."""
        machine, running = client.robot(self.name), self.running
        program.move(machine.ptp(self.closed))
        running.on(program)
        for places in self.cycle:
            program.move(machine.ptp(places))
        running.stand(program, running.end_seconds)
        running.off(program)
        program.move(machine.ptp(self.opened))


@dataclass(frozen=True, slots=True, eq=False)
class Tend:
    """Tending as a file describes it.

    Attributes:
        grip: how parts are held.
        parts: their names, in their order.
        machine: what works on them.
        rack: where they go then.
    """

    grip: Grip
    parts: tuple[str, ...]
    machine: Machine
    rack: Pallet


def read_tend(item: Item) -> Tend:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    needed = ("robot", "parts", "grip", "machine", "rack")
    fields = item.fields((*GRIP_FIELDS, "machine", "rack"), needed)
    parts, rack = read_parts(fields), read_pallet(fields["rack"])
    enough(rack, parts, fields["parts"])
    return Tend(read_grip(fields), parts, _machine(fields["machine"]), rack)


def plan(client: Client, item: Item) -> PlannedProcess:
    """Return the plan of tending that a file describes, in the cell as it is.

    Raises MalformedFileError for what the file says wrong, and UnknownNameError for a robot that there is not.
    """
    work = read_tend(item)
    work.machine.running.check(client.signals)
    robot, program = client.robot(work.grip.robot), client.program()
    home = robot.ptp(dict(zip(robot.joint_names, robot.positions.tolist(), strict=True)))
    chuck_t_part = pose(*work.machine.at.tolist())
    program.move(client.robot(work.machine.name).ptp(work.machine.opened))
    for part, place in zip(work.parts, work.rack.places, strict=False):
        work.grip.pick(program, part)
        work.grip.place(program, part, work.machine.chuck, chuck_t_part)
        program.move(home)
        work.machine.work(client, program)
        work.grip.pick(program, part)
        work.grip.place(program, part, work.rack.frame, place)
    program.move(home)
    axes = len(work.machine.cycle)
    return PlannedProcess(program, (f"{len(work.parts)} parts through {work.machine.name!r}, {axes} moves each in it",))


def _machine(item: Item) -> Machine:
    known = ("robot", "open", "closed", "cycle", "running", "chuck", "at")
    given = item.fields(known, ("robot", "open", "closed", "chuck"))
    return Machine(
        given["robot"].text(),
        _places(given["open"]),
        _places(given["closed"]),
        tuple(_places(one) for one in given["cycle"].items()) if "cycle" in given else (),
        read_switch(given.get("running")),
        given["chuck"].text(),
        vector(given["at"]) if "at" in given else np.zeros(3),
    )


def _places(item: Item) -> Places:
    found = {name: one.number() for name, one in item.mapping("joints").items()}
    if not found:
        raise item.error("joints and their places (rad or m) belong here: {door: 0.5}")
    return found
