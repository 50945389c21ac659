"""Programs in RAPID, for ABB's controllers; `languages/rapid` reads and runs them."""

from __future__ import annotations

import math

import numpy as np
from virtualrobot.geometry import Matrix, quaternion_of

from virtualrobot_apps.languages.rapid.configuration import confdata
from virtualrobot_apps.languages.rapid.predefined import SPEEDS, ZONES
from virtualrobot_apps.languages.writers.statements import (
    Condition,
    Goal,
    Line,
    Move,
    PointToPoint,
    RobotProgram,
    SetSignal,
    Value,
    WaitSignal,
    Zone,
    every,
    signal_of,
)
from virtualrobot_apps.languages.writers.words import Language, names_for, number, six_joints
from virtualrobot_apps.languages.writers.writer import Writer, indented

LONGEST = 32
"""Most characters of a name in RAPID."""
TURNING = 500.0
"""Speed (degrees/s) at which the tool turns at most in the speeds v5 to v7000."""
AXES = "[9E9, 9E9, 9E9, 9E9, 9E9, 9E9]"
NO_LOAD = "[0.001, [0, 0, 0.001], [1, 0, 0, 0], 0, 0, 0]"
TAKEN = ("main", "tool0", "wobj0")
_COMPARISONS = {"==": "=", "!=": "<>"}
_SWITCHES = {"==": "", "!=": "\\NOTEQ, ", "<": "\\LT, ", ">": "\\GT, "}


def write(program: RobotProgram, language: Language) -> str:
    """Return a module in RAPID: tools, work objects, and a procedure main.

    Raises InvalidArgumentError for what RAPID can't tell.
    """
    six_joints(program, "RAPID")
    return _Rapid(program, language).text()


class _Rapid(Writer):
    def __init__(self, program: RobotProgram, language: Language) -> None:
        named = [name for name in (*program.tools, *(f"in {one}" for one in program.frames)) if name not in ("", "in ")]
        self._names = names_for(named, LONGEST, TAKEN)
        statements = [one for _, one in every(program.statements)]
        signals = [name for name in map(signal_of, statements) if name is not None]
        known = names_for(dict.fromkeys(signals), LONGEST, (*TAKEN, *self._names.values()))
        super().__init__(program, {**known, **language.signals})
        self._outputs = {one.signal for one in statements if isinstance(one, SetSignal)}
        self._acceleration = math.inf

    def text(self) -> str:
        """Return the module."""
        body = self.body("    ")
        tools = [
            f"  TASK PERS tooldata {self._names[name]} := [TRUE, {_pose(pose)}, {NO_LOAD}];"
            for name, pose in self.program.tools.items()
            if name
        ]
        frames = [
            f'  TASK PERS wobjdata {self._names[f"in {name}"]} := [FALSE, TRUE, "", {_pose(pose)}, '
            "[[0, 0, 0], [1, 0, 0, 0]]];"
            for name, pose in self.program.frames.items()
            if name
        ]
        warning = ["  ! The loads of the tools are not known here: measure them by LoadIdentify."] if tools else []
        (module,) = names_for([self.program.name], LONGEST, TAKEN).values()
        lines = [
            f"MODULE {module}",
            *warning,
            *tools,
            *frames,
            "",
            "  PROC main()",
            *body,
            "  ENDPROC",
            "ENDMODULE",
            "",
        ]
        return "\n".join(lines)

    def use(self, tool: str) -> list[str]:
        return []

    def comment(self, text: str) -> str:
        return f"! {text}"

    def dwell(self, seconds: float) -> str:
        return f"WaitTime \\InPos, {number(seconds)};"

    def set(self, at: str, setting: SetSignal) -> str:
        return f"{_setting(setting.value)} {self.signals[setting.signal]}, {number(setting.value)};"

    def wait(self, at: str, wait: WaitSignal) -> list[str]:
        signal, value, most = self.signals[wait.signal], number(wait.value), ""
        if wait.seconds is not None:
            most = f" \\MaxTime:={number(wait.seconds)}"
        if isinstance(wait.value, bool):
            wanted = number(wait.value == (wait.comparison == "=="))
            return [f"{'WaitDO' if wait.signal in self._outputs else 'WaitDI'} {signal}, {wanted}{most};"]
        how = _SWITCHES.get(wait.comparison)
        if how is not None and (isinstance(wait.value, int) or wait.comparison in "<>"):
            return [f"Wait{'GI' if isinstance(wait.value, int) else 'AI'} {signal}, {how}{value}{most};"]
        return [f"WaitUntil \\InPos, {self._holds(wait)}{most};"]

    def decide(self, at: str, condition: Condition, then: list[str], otherwise: list[str]) -> list[str]:
        ends = ["ELSE", *indented(otherwise), "ENDIF"] if otherwise else ["ENDIF"]
        return [f"IF {self._holds(condition)} THEN", *indented(then), *ends]

    def repeat(self, at: str, condition: Condition | None, body: list[str]) -> list[str]:
        return [f"WHILE {self._holds(condition) if condition else 'TRUE'} DO", *indented(body), "ENDWHILE"]

    def forget(self) -> None:
        self._acceleration = math.nan

    def _holds(self, condition: Condition) -> str:
        comparison = _COMPARISONS.get(condition.comparison, condition.comparison)
        signal = self.signals[condition.signal]
        if isinstance(condition.value, bool) and condition.signal in self._outputs:
            signal = f"DOutput({signal})"
        return f"{signal} {comparison} {number(condition.value)}"

    def move(self, at: str, move: Move) -> list[str]:
        lines = []
        if not isinstance(move, PointToPoint) and move.acceleration != self._acceleration:
            self._acceleration = move.acceleration
            most = number(move.acceleration)
            lines.append(f"PathAccLim TRUE \\AccMax:={most}, TRUE \\DecelMax:={most};")
        return [*lines, f"{self._move(move)};"]

    def _move(self, move: Move) -> str:
        frame = move.goal.frame
        ends = f"{_zone(move.zone)}, {self._names[self.tool] if self.tool else 'tool0'}" + (
            f" \\WObj:={self._names[f'in {frame}']}" if frame else ""
        )
        if isinstance(move, PointToPoint):
            speed = _joint_speed(move)
            if move.goal.frame_t_tcp is None or not move.goal.branch:
                return f"MoveAbsJ {_joints(move.goal)}, {speed}, {ends}"
            return f"MoveJ {_target(move.goal)}, {speed}, {ends}"
        speed = _speed(move.speed, TURNING)
        if isinstance(move, Line):
            return f"MoveL {_target(move.goal)}, {speed}, {ends}"
        return f"MoveC {_target(move.via)}, {_target(move.goal)}, {speed}, {ends}"


def _joints(goal: Goal) -> str:
    return f"[[{', '.join(map(number, np.degrees(goal.joints)))}], {AXES}]"


def _target(goal: Goal) -> str:
    assert goal.frame_t_tcp is not None
    return f"[{_place(goal.frame_t_tcp)}, {_conf(goal)}, {AXES}]"


def _place(pose: Matrix) -> str:
    """Return position and orientation without brackets around both."""
    return _pose(pose)[1:-1]


def _pose(pose: Matrix) -> str:
    x, y, z, w = quaternion_of(pose).tolist()
    position = ", ".join(number(1000.0 * one) for one in np.asarray(pose)[:3, 3])
    return f"[[{position}], [{', '.join(_fine(one) for one in (w, x, y, z))}]]"


def _fine(value: float) -> str:
    return f"{round(value, 14) + 0.0:.15g}"


def _conf(goal: Goal) -> str:
    return f"[{', '.join(number(one) for one in confdata(goal.joints.tolist(), goal.branch))}]"


def _speed(speed: float, turning: float) -> str:
    """Return speed data for m/s and degrees/s."""
    v = round(1000.0 * speed, 9)
    if turning == TURNING and v in SPEEDS:
        return f"v{v:g}"
    return f"[{number(v)}, {number(turning)}, 5000, 1000]"


def _joint_speed(move: PointToPoint) -> str:
    """Return the speed at which the tool centre point goes where the joints have their share."""
    turning = math.degrees(move.turning)
    if 1000.0 * move.speed < 1.0:
        return _speed(7.0, TURNING if turning < 1e-6 else turning)
    return _speed(move.speed, TURNING if turning <= TURNING else math.ceil(turning))


def _zone(zone: Zone | None) -> str:
    if zone is None:
        return "fine"
    radius = round(1000.0 * zone.meters, 9)
    if radius in ZONES and radius > 0.0:
        return f"z{radius:g}"
    across, turn = number(1.5 * radius), number(0.15 * radius)
    return f"[FALSE, {number(radius)}, {across}, {across}, {turn}, {across}, {turn}]"


def _setting(value: Value) -> str:
    return "SetDO" if isinstance(value, bool) else "SetGO" if isinstance(value, int) else "SetAO"
