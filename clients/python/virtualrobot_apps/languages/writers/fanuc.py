"""Programs in TP, for FANUC's controllers, as ASCII files (.ls); all positions are told by joints.

By joints a position needs no configuration, and says the same whatever user frame is chosen. FANUC counts joint 3 from
the horizon: it is the angle here less that of joint 2. Source: FANUC, *R-30iB Mate Plus, Operator's Manual (Basic
Operation)*: motion instructions, CNT and CR, `UTOOL[i] = PR[j]`, `$WAITTMOUT` in 10 ms; ROS-Industrial's `fanuc` driver
for the coupling of joints 2 and 3 (`J23_factor`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from virtualrobot_apps.languages.writers.statements import (
    Condition,
    Floats,
    Line,
    Move,
    PointToPoint,
    RobotProgram,
    SetSignal,
    Value,
    WaitSignal,
    Zone,
)
from virtualrobot_apps.languages.writers.words import (
    Language,
    addresses,
    names_for,
    number,
    said,
    six_joints,
    zyx_degrees,
)
from virtualrobot_apps.languages.writers.writer import Writer

ADDRESS = r"(DO|DI|RO|RI|AO|AI|GO|GI|F)\[\d{1,4}\]"
EXAMPLE = "DO[1]"
LONGEST = 36
"""Most characters of a program's name, of capital letters."""
TIMEOUT_LABEL = 99
_COMPARISONS = {"==": "=", "!=": "<>"}
_CONTRARY = {"==": "!=", "!=": "==", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}


def write(program: RobotProgram, language: Language) -> str:
    """Return a program in TP.

    `language.coupling` is the part of joint 2 by which the controller's joint 3 is less than here. Raises
    InvalidArgumentError for what TP can't tell, and for signals that have no address.
    """
    six_joints(program, "TP")
    where = addresses(program, language, ADDRESS, EXAMPLE)
    (name,) = names_for([program.name], LONGEST).values()
    writer = _Tp(program, where, language.coupling)
    lines = [*writer.tools(), "UFRAME_NUM=0", *writer.body()]
    if writer.times_out:
        lines += ["END", f"LBL[{TIMEOUT_LABEL}]", "UALM[1]"]
    numbered = [f"{place:4d}:{_padded(line)} ;" for place, line in enumerate(lines, 1)]
    positions = [line for place, joints in enumerate(writer.positions, 1) for line in _position(place, joints)]
    head = [f"/PROG  {name.upper()}", "/ATTR", 'COMMENT = "";', "DEFAULT_GROUP = 1,*,*,*,*;"]
    return "\n".join([*head, "/MN", *numbered, "/POS", *positions, "/END", ""])


class _Tp(Writer):
    def __init__(self, program: RobotProgram, signals: dict[str, str], coupling: float) -> None:
        super().__init__(program, signals)
        self._coupling = coupling
        self._numbers = {tool: place for place, tool in enumerate(program.tools, 1)}
        self.positions: list[tuple[float, ...]] = []
        self.times_out = False
        self._label = 0

    def tools(self) -> list[str]:
        """Return the lines that set the tools."""
        found = []
        for tool, place in self._numbers.items():
            x, y, z = (1000.0 * np.asarray(self.program.tools[tool])[:3, 3]).tolist()
            r, p, w = zyx_degrees(self.program.tools[tool])
            found.append(f"!tool {place}: {(tool or 'the flange')[:20]}")
            found.append(f"PR[{place}]=LPOS-LPOS")
            found += [f"PR[{place},{axis}]={number(one)}" for axis, one in enumerate((x, y, z, w, p, r), 1)]
            found.append(f"UTOOL[{place}]=PR[{place}]")
        return found

    def use(self, tool: str) -> list[str]:
        return [f"UTOOL_NUM={self._numbers[tool]}"]

    def comment(self, text: str) -> str:
        return f"!{text[:32]}"

    def dwell(self, seconds: float) -> str:
        return f"WAIT {number(seconds)}(sec)"

    def set(self, at: str, setting: SetSignal) -> str:
        return f"{self.signals[setting.signal]}={self._value(at, setting.signal, setting.value)}"

    def move(self, at: str, move: Move) -> list[str]:
        if isinstance(move, PointToPoint):
            percent = 100.0 * move.share
            if percent < 1.0:
                raise said(at, f"a joint move at {number(percent)}% of the speed, less than 1%,", "TP")
            return [f"J {self._place(move.goal.joints)} {number(percent, 6)}% {_corner(move.zone, True)}"]
        speed = f"{number(1000.0 * move.speed)}mm/sec"
        if isinstance(move, Line):
            return [f"L {self._place(move.goal.joints)} {speed} {_corner(move.zone, False)}"]
        via = self._place(move.via.joints)
        return [f"C {via}\n    :  {self._place(move.goal.joints)} {speed} {_corner(move.zone, False)}"]

    def _place(self, joints: Floats) -> str:
        degrees = np.degrees(joints)
        degrees[2] -= self._coupling * degrees[1]
        told = tuple(round(one, 6) + 0.0 for one in degrees.tolist())
        if told not in self.positions:
            self.positions.append(told)
        return f"P[{self.positions.index(told) + 1}]"

    def wait(self, at: str, wait: WaitSignal) -> list[str]:
        line = f"WAIT {self._holds(at, wait)}"
        if wait.seconds is None:
            return [line]
        self.times_out = True
        return [f"$WAITTMOUT={number(round(100.0 * wait.seconds))}", f"{line} TIMEOUT,LBL[{TIMEOUT_LABEL}]"]

    def decide(self, at: str, condition: Condition, then: list[str], otherwise: list[str]) -> list[str]:
        no = self._new_label()
        jump = f"IF {self._fails(at, condition)},JMP LBL[{no}]"
        if not otherwise:
            return [jump, *then, f"LBL[{no}]"]
        end = self._new_label()
        return [jump, *then, f"JMP LBL[{end}]", f"LBL[{no}]", *otherwise, f"LBL[{end}]"]

    def repeat(self, at: str, condition: Condition | None, body: list[str]) -> list[str]:
        again = self._new_label()
        if condition is None:
            return [f"LBL[{again}]", *body, f"JMP LBL[{again}]"]
        end = self._new_label()
        jump = f"IF {self._fails(at, condition)},JMP LBL[{end}]"
        return [f"LBL[{again}]", jump, *body, f"JMP LBL[{again}]", f"LBL[{end}]"]

    def forget(self) -> None:
        """Do nothing: each line tells all that it needs."""

    def _new_label(self) -> int:
        self._label += 2 if self._label + 1 == TIMEOUT_LABEL else 1
        return self._label

    def _holds(self, at: str, condition: Condition) -> str:
        value = self._value(at, condition.signal, condition.value)
        comparison = _COMPARISONS.get(condition.comparison, condition.comparison)
        return f"{self.signals[condition.signal]}{comparison}{value}"

    def _fails(self, at: str, condition: Condition) -> str:
        return self._holds(at, replace(condition, comparison=_CONTRARY[condition.comparison]))

    def _value(self, at: str, signal: str, value: Value) -> str:
        of_bits = self.signals[signal][0] not in "AG"
        if isinstance(value, bool) != of_bits:
            raise said(at, f"{value!r} as a value of {self.signals[signal]}", "TP")
        return ("ON" if value else "OFF") if of_bits else number(value)


def _corner(zone: Zone | None, of_joints: bool) -> str:
    if zone is None:
        return "FINE"
    return f"CNT{max(1, round(200.0 * zone.share))}" if of_joints else f"CR{number(1000.0 * zone.meters)}"


def _padded(line: str) -> str:
    return line if line[:2] in ("J ", "L ", "C ") else f"  {line}"


def _position(place: int, degrees: tuple[float, ...]) -> list[str]:
    told = ",\t".join(f"J{axis} = {one:.6f} deg" for axis, one in enumerate(degrees, 1))
    return [f"P[{place}]{{", "   GP1:", "\tUF : 0, UT : 1,", f"\t{told}", "};"]
