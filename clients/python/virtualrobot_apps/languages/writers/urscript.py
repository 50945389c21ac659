"""Programs in URScript, for controllers of Universal Robots; `languages/urscript` reads and runs them."""

from __future__ import annotations

import numpy as np
from virtualrobot.geometry import Matrix, rotation_vector_of

from virtualrobot_apps.languages.writers.statements import (
    Condition,
    Goal,
    Line,
    Move,
    PointToPoint,
    RobotProgram,
    SetSignal,
    WaitSignal,
    Zone,
)
from virtualrobot_apps.languages.writers.words import Language, addresses, names_for, number, said, six_joints
from virtualrobot_apps.languages.writers.writer import Writer, indented

ADDRESS = r"(standard|configurable|tool)_(in|out)\[[0-7]\]"
EXAMPLE = "standard_out[0]"
TAKEN = ("p", "t", "local", "global", "def", "end", "thread", "sec")


def write(program: RobotProgram, language: Language) -> str:
    """Return a program in URScript: frames as poses, and one function, called at the end.

    Raises InvalidArgumentError for what URScript can't tell, and for signals that have no address.
    """
    six_joints(program, "URScript")
    where = addresses(program, language, ADDRESS, EXAMPLE)
    frames = names_for((f"frame {one}" for one in program.frames if one), 60, TAKEN)
    (name,) = names_for([program.name], 60, (*TAKEN, *frames.values())).values()
    places = [f"  {frames[f'frame {one}']} = {_pose(pose)}" for one, pose in program.frames.items() if one]
    body = _Script(program, where, frames).body("  ")
    return "\n".join([f"def {name}():", *places, *body, "end", f"{name}()", ""])


class _Script(Writer):
    def __init__(self, program: RobotProgram, signals: dict[str, str], frames: dict[str, str]) -> None:
        super().__init__(program, signals)
        self._frames = frames

    def use(self, tool: str) -> list[str]:
        return [f"set_tcp({_pose(self.program.tools[tool])})"]

    def comment(self, text: str) -> str:
        return f"# {text}"

    def dwell(self, seconds: float) -> str:
        return f"sleep({number(seconds)})"

    def set(self, at: str, setting: SetSignal) -> str:
        kind, way, bit = _parts(self.signals[setting.signal])
        if way != "out":
            raise said(at, f"an input that is set, {setting.signal!r},", "URScript")
        return f"set_{kind}_digital_out({bit}, {_bool(at, setting.value)})"

    def move(self, at: str, move: Move) -> list[str]:
        ends = _radius(move.zone)
        if isinstance(move, PointToPoint):
            joints = ", ".join(_angle(one) for one in move.goal.joints.tolist())
            acceleration, velocity = number(move.acceleration), number(move.leading)
            return [f"movej([{joints}], a={acceleration}, v={velocity}{ends})"]
        goal = self._place(move.goal)
        speeds = f"a={number(move.acceleration)}, v={number(move.speed)}{ends}"
        if isinstance(move, Line):
            return [f"movel({goal}, {speeds})"]
        return [f"movec({self._place(move.via)}, {goal}, {speeds}, mode=0)"]

    def _place(self, goal: Goal) -> str:
        assert goal.frame_t_tcp is not None
        pose = _pose(goal.frame_t_tcp)
        return f"pose_trans({self._frames[f'frame {goal.frame}']}, {pose})" if goal.frame else pose

    def wait(self, at: str, wait: WaitSignal) -> list[str]:
        address, waiting = self.signals[wait.signal], self._holds(at, wait, False)
        if wait.seconds is None:
            return [f"while {waiting}:", "  sync()", "end"]
        return [
            "waited = 0.0",
            f"while {waiting}:",
            f"  if waited >= {number(wait.seconds)}:",
            f'    popup("{address} did not come within {number(wait.seconds)} s", title="program", error=True)',
            "    halt",
            "  end",
            "  sync()",
            "  waited = waited + get_steptime()",
            "end",
        ]

    def decide(self, at: str, condition: Condition, then: list[str], otherwise: list[str]) -> list[str]:
        ends = ["else:", *indented(otherwise), "end"] if otherwise else ["end"]
        return [f"if {self._holds(at, condition)}:", *indented(then), *ends]

    def repeat(self, at: str, condition: Condition | None, body: list[str]) -> list[str]:
        # A round without a move or a wait would take no time, which a controller doesn't allow.
        return [f"while {self._holds(at, condition) if condition else 'True'}:", *indented([*body, "sync()"]), "end"]

    def forget(self) -> None:
        """Do nothing: each line tells all that it needs."""

    def _holds(self, at: str, condition: Condition, wanted: bool = True) -> str:
        """Return the text of a condition, or of its contrary."""
        kind, way, bit = _parts(self.signals[condition.signal])
        if condition.comparison not in ("==", "!="):
            raise said(at, f"a digital signal that is {condition.comparison} a number", "URScript")
        on = (_bool(at, condition.value) == "True") == (condition.comparison == "==")
        return f"{'' if on == wanted else 'not '}get_{kind}_digital_{way}({bit})"


def _parts(address: str) -> tuple[str, str, str]:
    kind, _, rest = address.partition("_")
    way, _, bit = rest.rstrip("]").partition("[")
    return kind, way, bit


def _bool(at: str, value: object) -> str:
    if not isinstance(value, bool):
        raise said(at, f"a digital signal of {value!r}", "URScript")
    return str(value)


def _radius(zone: Zone | None) -> str:
    return f", r={number(zone.meters)}" if zone is not None else ""


def _angle(value: float) -> str:
    return f"{round(value, 12) + 0.0:.14g}"


def _pose(pose: Matrix) -> str:
    numbers = [*np.asarray(pose)[:3, 3].tolist(), *rotation_vector_of(pose).tolist()]
    return f"p[{', '.join(_angle(one) for one in numbers)}]"
