"""A CRS controller that is computed: RAPL-II commands typed at its prompt, and an arm that goes to points by itself.

The forms of STATUS and W2, the prompt and the echo are those of recorded sessions with a C500 (RAPL-II 2.60). The codes
012 and 019 are known; 050 and 051 are made up.
"""

from __future__ import annotations

import math
import re
import time

import numpy as np

PULSES = np.array([-66.6, -66.6667, -66.6, -140.278, -277.776, -140.278])
"""Pulses per degree of the joints."""


class Controller:
    """A controller with an arm of six joints, which go at up to `speed` degrees a second, all as long as each other."""

    def __init__(self, joints: int = 6, speed: float = 400.0) -> None:
        """Stand at zero, homed, with power."""
        self.at, self.goal = np.zeros(joints), np.zeros(joints)
        self.speed, self.percent = speed, 10
        self.moved = time.monotonic()
        self.limp = False
        self.homed = True
        self.manual = False
        self.error = "000-NO ERROR."
        self.locations: dict[str, np.ndarray] = {}
        self.typed: list[str] = []
        self.held = ""
        self.says = True

    def __call__(self, data: bytes) -> bytes:
        """Return echo, answers and prompts to what is typed."""
        self.held += data.decode("latin-1")
        *commands, self.held = self.held.split("\r")
        said = "".join(f"{command}\r\n{self.answer(command)}>>" for command in commands)
        return said.encode() if self.says else b""

    def answer(self, command: str) -> str:
        """Do a command, and return its answer; one that is wrong is answered by its error."""
        self.advance()
        if command:
            self.typed.append(command)
        name, _, rest = command.partition(" ")
        try:
            lines = getattr(self, f"do_{name.lower()}")(rest) if name else []
        except (AttributeError, ValueError, KeyError):
            lines = ["012-COMMAND ERROR."]
        if lines and re.match(r"\d{3}-", lines[0]):
            self.error = lines[0]
        return "".join(f"{line}\r\n" for line in lines)

    def advance(self) -> None:
        """Go on for the time that has passed."""
        now = time.monotonic()
        passed, self.moved = now - self.moved, now
        if self.limp:
            self.goal = self.at.copy()
        way = np.abs(self.goal - self.at).max()
        step = self.speed * self.percent / 100.0 * passed
        self.at = self.goal.copy() if way <= step else self.at + (self.goal - self.at) * step / way

    def do_w2(self, rest: str) -> list[str]:
        """Tell the actual position, as recorded: five columns, and what is more below."""
        joints = [f"{value:+09.4f}" for value in self.at]
        pulses = [f"{round(value):+011d}" for value in self.at * PULSES[: len(self.at)]]
        return [
            *("", "CURRENT ACTUAL POSITION :"),
            "NAME       AX#1/6      AX#2/7      AX#3/8      AX#4        AX#5",
            f"PULSES   {' '.join(pulses[:5])}",
            *([f"         {' '.join(pulses[5:])}"] if pulses[5:] else []),
            "NAME       JT#1/6    JT#2/7    JT#3/8    JT#4      JT#5",
            f"JOINTS   {' '.join(joints[:5])}",
            *([f"         {' '.join(joints[5:])}"] if joints[5:] else []),
            "WORLD     +000.0198 +000.0149 -076.1849 +000.0000 +089.9964 +000.8198",
            ".",
        ]

    def do_status(self, rest: str) -> list[str]:
        """Tell the status, as recorded."""

        def row(flag: bool) -> str:
            return " ".join(("Y" if flag else "N") * len(self.at))

        return [
            *("RAPL-II Version 2.60     A465 Robot", f"LAST ERROR CODE: {self.error}"),
            *(f"SPEED (% OF FULL) :    {self.percent:+d}", "MAX LINEAR SPEED: +990.6000"),
            *("CURRENT PROGRAM EXECUTING:", "JOINT LIMIT CHECK IS ON"),
            f"CONTROLLER IS {'' if self.homed else 'NOT '}HOMED",
            *("TOOL TRANSFORM", "NULL      +000.0000 +000.0000 +000.0000 +000.0000 +000.0000 +000.0000"),
            "GRIPPER TYPE:  SERVO",
            f"AXIS#        {' '.join(str(i + 1) for i in range(len(self.at)))}",
            *(f"LOCK         {row(False)}", f"DONE         {row(bool(np.all(self.at == self.goal)))}"),
            *(f"LIMP         {row(self.limp)}", f"HOMED        {row(self.homed)}"),
            "REQUESTED ROBOT CONFIG : UPRIGHT/REACH FORWARD/ELBOW UP/WRIST FREE",
            f"MANUAL MODE STATUS IS {'ON' if self.manual else 'OFF'}",
            "METRIC UNITS.",
        ]

    def do_speed(self, rest: str) -> list[str]:
        """Set the speed of the next moves."""
        percent = int(rest)
        if not 1 <= percent <= 100:
            raise ValueError(rest)
        self.percent = percent
        return []

    def do_ma(self, rest: str) -> list[str]:
        """Go to radians."""
        return self.go(np.degrees([float(value) for value in rest.split(",")]))

    def do_point(self, rest: str) -> list[str]:
        """Keep a location in pulses."""
        name, _, values = rest.partition(" ")
        self.locations[name] = np.array([int(value) for value in values.split(",")])
        return []

    def do_move(self, rest: str) -> list[str]:
        """Go to a location."""
        return self.go(self.locations[rest] / PULSES[: len(self.at)])

    def do_halt(self, rest: str) -> list[str]:
        """Stop where it is."""
        self.goal = self.at.copy()
        return []

    def go(self, goal: np.ndarray) -> list[str]:
        """Go to degrees, unless something is against it."""
        if self.limp:
            return ["050-ARM POWER IS OFF."]
        if len(goal) != len(self.at) or not math.isfinite(goal.sum()):
            raise ValueError(goal)
        if np.abs(goal).max() > 175.0:
            return [f"051-JOINT {int(np.abs(goal).argmax()) + 1} OUT OF RANGE."]
        self.goal = goal
        return []
