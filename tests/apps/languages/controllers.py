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


@dataclass
class Read:
    """Program as a controller takes a text: its moves and what it does between them, in m, rad, s.

    Moves are (kind, goals, speed, corner, tool number or pose): joints (6,) or 4x4 poses in the frame of the base.
    """

    steps: list[Step] = field(default_factory=list)
    tools: dict[int, Matrix] = field(default_factory=dict)


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
    for line in (one.strip() for one in lines[2:-1]):
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
        elif match := re.fullmatch(r"WAIT (SEC|FOR) (.*)", line):
            found.steps.append(("wait", match[1], match[2]))
        else:
            assert re.fullmatch(r"\$TIMER_STOP\[1\] = FALSE|IF NOT \(.*\) THEN|HALT|ENDIF", line), line
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
    found, registers, tool, count = Read(), dict[int, dict[int, float]](), 0, 0
    for line in body.replace("\n    :  ", " ").splitlines():
        count += 1
        match = re.fullmatch(r" *(\d+):(?:  )?(.*) ;", line)
        assert match is not None and int(match[1]) == count, line
        said = match[2]
        if match := re.fullmatch(r"([JLC]) P\[(\d+)\](?: P\[(\d+)\])? (\S+?)(%|mm/sec) (FINE|CNT\d+|CR\S+)", said):
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
        elif said.startswith("WAIT "):
            found.steps.append(("wait", said.removeprefix("WAIT ")))
        else:
            assert re.fullmatch(r"!.*|UFRAME_NUM=0|\$WAITTMOUT=\d+|END|LBL\[99\]|UALM\[1\]", said), said
    return found
