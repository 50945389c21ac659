"""Programs in KRL, for KUKA's controllers: the source file; goals of lines as frames, of joint moves as axes.

Source: KUKA, *KUKA System Software 8.3, Operating and Programming Instructions for System Integrators*: PTP, LIN, CIRC,
`$TOOL`, `$BASE`, `$VEL.CP` (m/s), `$ACC.CP` (m/s^2), `$APO.CDIS` (mm), `$APO.CPTP` (percent of half the way),
`BAS(#VEL_PTP, percent)`. A, B, C turn about z, y', x''.
"""

from __future__ import annotations

import numpy as np
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix

from virtualrobot_apps.languages.writers.statements import (
    Condition,
    Floats,
    Goal,
    Line,
    Move,
    PointToPoint,
    RobotProgram,
    SetSignal,
    Value,
    WaitSignal,
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
from virtualrobot_apps.languages.writers.writer import Writer, indented

ADDRESS = r"\$(OUT|IN|ANOUT|ANIN)\[\d{1,4}\]"
EXAMPLE = "$OUT[1]"
LONGEST = 24
"""Most characters of a name in KRL."""
_COMPARISONS = {"==": "==", "!=": "<>"}


def write(program: RobotProgram, language: Language) -> str:
    """Return a program in KRL (a .src file).

    `language.signs` are the senses of the axes against those here. Raises InvalidArgumentError for what KRL can't tell,
    and for signals that have no address.
    """
    six_joints(program, "KRL")
    where = addresses(program, language, ADDRESS, EXAMPLE)
    signs = np.array(language.signs or [1.0] * 6)
    if signs.shape != (6,) or not np.isin(signs, (-1.0, 1.0)).all():
        raise InvalidArgumentError("the signs are six numbers, each 1 or -1, as 1,1,1,1,1,1")
    (name,) = names_for([program.name], LONGEST).values()
    head = ["&ACCESS RVP", f"DEF {name}( )", "  BAS (#INITMOV, 0)", "  $BASE = {X 0, Y 0, Z 0, A 0, B 0, C 0}"]
    return "\n".join([*head, *_Krl(program, where, signs).body("  "), "END", ""])


class _Krl(Writer):
    def __init__(self, program: RobotProgram, signals: dict[str, str], signs: Floats) -> None:
        super().__init__(program, signals)
        self._signs, self._set = signs, dict[str, str]()
        self._frame: str | None = ""

    def use(self, tool: str) -> list[str]:
        return [f"$TOOL = {{{_frame(self.program.tools[tool])}}}"]

    def comment(self, text: str) -> str:
        return f"; {text}"

    def dwell(self, seconds: float) -> str:
        return f"WAIT SEC {number(seconds)}"

    def set(self, at: str, setting: SetSignal) -> str:
        return f"{self.signals[setting.signal]} = {self._value(at, setting.signal, setting.value)}"

    def move(self, at: str, move: Move) -> list[str]:
        if isinstance(move, PointToPoint):
            lines = self._changed("ptp", f"BAS (#VEL_PTP, {number(100.0 * move.share, 6)})")
            if move.zone is not None:
                lines += self._changed("cptp", f"$APO.CPTP = {number(200.0 * move.zone.share, 6)}")
            axes = self._signs * np.degrees(move.goal.joints)
            told = ", ".join(f"A{place} {number(one)}" for place, one in enumerate(axes.tolist(), 1))
            return [*lines, f"PTP {{{told}}}{' C_PTP' if move.zone is not None else ''}"]
        lines = self._changed("cp", f"$VEL.CP = {number(move.speed)}")
        lines += self._changed("acc", f"$ACC.CP = {number(move.acceleration)}")
        if move.zone is not None:
            lines += self._changed("cdis", f"$APO.CDIS = {number(1000.0 * move.zone.meters)}")
        if move.goal.frame != self._frame:
            self._frame = move.goal.frame
            lines.append(f"$BASE = {{{_frame(self.program.frames[move.goal.frame])}}}")
        ends = f"{_goal(move.goal)}{' C_DIS' if move.zone is not None else ''}"
        if isinstance(move, Line):
            return [*lines, f"LIN {ends}"]
        return [*lines, f"CIRC {_goal(move.via)}, {ends}"]

    def _changed(self, what: str, line: str) -> list[str]:
        """Return a line that sets something, where that is not so already."""
        if self._set.get(what) == line:
            return []
        self._set[what] = line
        return [line]

    def wait(self, at: str, wait: WaitSignal) -> list[str]:
        condition = self._holds(at, wait)
        if wait.seconds is None:
            return [f"WAIT FOR {condition}"]
        return [
            f"$TIMER[1] = {number(-1000.0 * wait.seconds)}",
            "$TIMER_STOP[1] = FALSE",
            f"WAIT FOR ({condition}) OR $TIMER_FLAG[1]",
            f"IF NOT ({condition}) THEN",
            "  HALT",
            "ENDIF",
        ]

    def decide(self, at: str, condition: Condition, then: list[str], otherwise: list[str]) -> list[str]:
        ends = ["ELSE", *indented(otherwise), "ENDIF"] if otherwise else ["ENDIF"]
        return [f"IF {self._holds(at, condition)} THEN", *indented(then), *ends]

    def repeat(self, at: str, condition: Condition | None, body: list[str]) -> list[str]:
        if condition is None:
            return ["LOOP", *indented(body), "ENDLOOP"]
        return [f"WHILE {self._holds(at, condition)}", *indented(body), "ENDWHILE"]

    def forget(self) -> None:
        self._set.clear()
        self._frame = None

    def _holds(self, at: str, condition: Condition) -> str:
        value = self._value(at, condition.signal, condition.value)
        comparison = _COMPARISONS.get(condition.comparison, condition.comparison)
        return f"{self.signals[condition.signal]} {comparison} {value}"

    def _value(self, at: str, signal: str, value: Value) -> str:
        analog = "$AN" in self.signals[signal]
        if isinstance(value, bool) == analog:
            raise said(at, f"{value!r} as a value of {self.signals[signal]}", "KRL")
        return number(value) if analog else str(value).upper()


def _goal(goal: Goal) -> str:
    assert goal.frame_t_tcp is not None
    return f"{{{_frame(goal.frame_t_tcp)}}}"


def _frame(pose: Matrix) -> str:
    x, y, z = (1000.0 * np.asarray(pose)[:3, 3]).tolist()
    a, b, c = zyx_degrees(pose)
    return ", ".join(f"{name} {number(value)}" for name, value in zip("XYZABC", (x, y, z, a, b, c), strict=True))
