"""Readers of what is written for controllers, by the rules of their manuals and with none of the writers' code.

KRL: KUKA, *KUKA System Software 8.3, Operating and Programming Instructions for System Integrators*. TP: FANUC, *R-30iB
Mate Plus, Operator's Manual (Basic Operation)*.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from virtualrobot.geometry import Matrix, pose

Step = tuple[Any, ...]
MOST_LINES = 100_000
"""Lines that a program may run through."""
_HOLDS = {
    "==": lambda a, b: a == b,
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: float(a) < float(b),
    "<=": lambda a, b: float(a) <= float(b),
    ">": lambda a, b: float(a) > float(b),
    ">=": lambda a, b: float(a) >= float(b),
}


@dataclass
class Read:
    """Program as a controller takes a text: its moves and what it does between them, in m, rad, s.

    What it decides is decided by the signals that it has set. Moves are (kind, goals, speed, corner, tool number or
    pose): joints (6,) or 4x4 poses in the frame of the base.
    """

    steps: list[Step] = field(default_factory=list)
    signals: dict[str, str] = field(default_factory=dict)
    tools: dict[int, Matrix] = field(default_factory=dict)

    def holds(self, condition: str) -> bool:
        """Return whether a condition of a signal holds; a signal that it has not set is as it is waited for."""
        match = re.fullmatch(r"(\S+?\[\d+\]) ?(==|=|<>|<=|>=|<|>) ?(\S+)", condition)
        assert match is not None, condition
        return _HOLDS[match[2]](self.signals.get(match[1], match[3]), match[3])


def block_end(lines: list[str], place: int, ends: tuple[str, ...]) -> int:
    """Return the place of the line that ends the block which begins at a place, of those that begin alike."""
    begins = {"ENDIF": r"IF .* THEN", "ENDWHILE": r"WHILE .*", "ENDLOOP": "LOOP"}[ends[-1]]
    depth = 0
    while depth or lines[place + 1] not in ends:
        place += 1
        depth += bool(re.fullmatch(begins, lines[place])) - (lines[place] == ends[-1])
    return place + 1


def frame(text: str) -> Matrix:
    """Return a FRAME of KRL, in mm and degrees: turned about z by A, y' by B, x'' by C."""
    values = {name: float(value) for name, value in re.findall(r"([XYZABC]) (\S+?)(?=[,}])", text)}
    assert values.keys() == set("XYZABC"), text
    turn = {name: np.radians(values[one]) for name, one in (("yaw", "A"), ("pitch", "B"), ("roll", "C"))}
    return pose(*(values[one] / 1000.0 for one in "XYZ"), **turn)


def read_krl(text: str) -> Read:
    """Return what a program in KRL does; fails at a line that is none."""
    lines = text.splitlines()
    assert lines[0] == "&ACCESS RVP" and re.fullmatch(r"DEF \w{1,24}\( \)", lines[1]) and lines[-1] == "END"
    found, state = Read(), {"$TOOL": np.eye(4), "$BASE": np.eye(4)}
    numbers: dict[str, float] = {}
    body, place, loops, count = [one.strip() for one in lines[2:-1]], -1, list[int](), 0
    while place + 1 < len(body):
        place, count = place + 1, count + 1
        line = body[place]
        assert count < MOST_LINES
        corner = {"C_PTP": ("CPTP", "$APO.CPTP"), "C_DIS": ("CDIS", "$APO.CDIS")}
        if line.startswith(";") or line == "BAS (#INITMOV, 0)":
            continue
        if match := re.fullmatch(r"(\$TOOL|\$BASE) = (\{.*\})", line):
            state[match[1]] = frame(match[2])
        elif match := re.fullmatch(r"(\$(?:VEL|ACC|APO)\.\w+) = (\S+)", line):
            numbers[match[1]] = float(match[2])
        elif match := re.fullmatch(r"BAS \(#VEL_PTP, (\S+)\)", line):
            numbers["ptp"] = float(match[1])
        elif match := re.fullmatch(r"(PTP|LIN|CIRC) (\{.*?\})(?:, (\{.*?\}))?(?: (C_PTP|C_DIS))?", line):
            kind, *goals, how = match.groups()
            at = (corner[how][0], numbers[corner[how][1]]) if how else None
            if kind == "PTP":
                axes = [float(one) for one in re.findall(r"A\d (\S+?)(?=[,}])", goals[0])]
                places, speed = [np.radians(axes)], numbers["ptp"] / 100.0
            else:
                places = [state["$BASE"] @ frame(one) for one in goals if one]
                speed = numbers["$VEL.CP"]
            found.steps.append((kind, places, speed, at, state["$TOOL"]))
        elif match := re.fullmatch(r"(\$\w+\[\d+\]) = (TRUE|FALSE|\S+)", line):
            found.steps.append(("set", match[1], match[2]))
            found.signals[match[1]] = match[2]
        elif match := re.fullmatch(r"IF (NOT \()?(.*?)\)? THEN", line):
            if found.holds(match[2]) == bool(match[1]):
                place = block_end(body, place, ("ELSE", "ENDIF"))
        elif line == "ELSE":
            place = block_end(body, place, ("ENDIF",))
        elif match := re.fullmatch(r"WHILE (.*)|LOOP", line):
            if match[1] is None or found.holds(match[1]):
                loops.append(place - 1)
            else:
                place = block_end(body, place, ("ENDWHILE",))
        elif line in ("ENDWHILE", "ENDLOOP"):
            place = loops.pop()
        elif match := re.fullmatch(r"WAIT (SEC|FOR) (.*)", line):
            found.steps.append(("wait", match[1], match[2]))
        else:
            assert line in ("$TIMER_STOP[1] = FALSE", "ENDIF"), line
    return found


def read_tp(text: str, coupling: float) -> Read:
    """Return what a program in TP does; fails at a line that is none."""
    head, _, rest = text.partition("/MN\n")
    body, _, places = rest.partition("/POS\n")
    assert re.match(r"/PROG  [A-Z][A-Z0-9_]{0,35}\n/ATTR\n", head) and places.endswith("/END\n")
    positions = {}
    for number, given in re.findall(r"P\[(\d+)\]\{\n   GP1:\n\tUF : 0, UT : 1,\n(.*?)\n\};", places, re.DOTALL):
        joints = np.radians([float(one) for one in re.findall(r"J\d = (\S+) deg", given)])
        joints[2] += coupling * joints[1]
        positions[number] = joints
    found, registers, tool, lines = Read(), dict[int, dict[int, float]](), 0, list[str]()
    for line in body.replace("\n    :  ", " ").splitlines():
        match = re.fullmatch(r" *(\d+):(?:  )?(.*) ;", line)
        assert match is not None and int(match[1]) == len(lines) + 1, line
        lines.append(match[2])
    place, count = -1, 0
    while place + 1 < len(lines) and lines[place + 1] != "END":
        place, count = place + 1, count + 1
        said = lines[place]
        assert count < MOST_LINES
        if match := re.fullmatch(r"(?:IF (.*),)?JMP (LBL\[\d+\])", said):
            if match[1] is None or found.holds(match[1]):
                place = lines.index(match[2])
        elif match := re.fullmatch(r"([JLC]) P\[(\d+)\](?: P\[(\d+)\])? (\S+?)(%|mm/sec) (FINE|CNT\d+|CR\S+)", said):
            kind, *goals, speed, unit, corner = match.groups()
            factor = 0.01 if unit == "%" else 0.001
            goals = [positions[one] for one in goals if one]
            at = None if corner == "FINE" else re.fullmatch(r"(\D+)(.*)", corner)
            told = (at[1], float(at[2])) if at else None
            found.steps.append((kind, goals, factor * float(speed), told, tool))
        elif match := re.fullmatch(r"PR\[(\d+),(\d)\]=(\S+)", said):
            registers[int(match[1])][int(match[2])] = float(match[3])
        elif match := re.fullmatch(r"PR\[(\d+)\]=LPOS-LPOS", said):
            registers[int(match[1])] = {}
        elif match := re.fullmatch(r"UTOOL\[(\d+)\]=PR\[\1\]", said):
            x, y, z, w, p, r = (registers[int(match[1])][axis] for axis in range(1, 7))
            turn = {"roll": np.radians(w), "pitch": np.radians(p), "yaw": np.radians(r)}
            found.tools[int(match[1])] = pose(x / 1000.0, y / 1000.0, z / 1000.0, **turn)
        elif match := re.fullmatch(r"UTOOL_NUM=(\d+)", said):
            tool = int(match[1])
        elif match := re.fullmatch(r"([A-Z]+\[\d+\])=(ON|OFF|\S+)", said):
            found.steps.append(("set", match[1], match[2]))
            found.signals[match[1]] = match[2]
        elif said.startswith("WAIT "):
            found.steps.append(("wait", said.removeprefix("WAIT ")))
        else:
            assert re.fullmatch(r"!.*|UFRAME_NUM=0|\$WAITTMOUT=\d+|LBL\[\d+\]", said), said
    return found
