"""Teleoperation: twists of a craft from keys, or what else is wanted, and none without somebody who holds on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from virtualrobot.cli.gamepad_mapping import FRAMES
from virtualrobot.cli.key_screen import HeldKey
from virtualrobot.errors import VirtualRobotError

if TYPE_CHECKING:
    from virtualrobot.motions.setpoints import SetpointStream
    from virtualrobot.robots.robot import Robot

Twist = tuple[float, float, float]
"""Twist of a craft: vx and vy in m/s along the axes of its base, and its turning rate in rad/s to the left."""

REST: Twist = (0.0, 0.0, 0.0)

Values = tuple[float, ...]
"""Twist of a craft or a tool, or speeds of joints (rad/s or m/s)."""

RATE_HERTZ = 20.0
"""Rate at which twists are sent."""

TIMEOUT_SECONDS = 0.5
"""Simulation time (s) without a twist after which the kernel stops the craft: this program has gone."""

IDLE_SECONDS = 1.0
"""Time (s) after the last key for which the craft is kept; then others may move it."""

REST_SECONDS = 10.0
"""Longest time (s) to wait until the craft rests."""

KEYS: dict[str, Twist] = {
    **dict.fromkeys(("w", "up", "i"), (1.0, 0.0, 0.0)),
    **dict.fromkeys(("s", "down", ","), (-1.0, 0.0, 0.0)),
    **dict.fromkeys(("a", "left", "j"), (0.0, 0.0, 1.0)),
    **dict.fromkeys(("d", "right", "l"), (0.0, 0.0, -1.0)),
    "u": (1.0, 0.0, 1.0),
    "o": (1.0, 0.0, -1.0),
    "m": (-1.0, 0.0, -1.0),
    ".": (-1.0, 0.0, 1.0),
    "J": (0.0, 1.0, 0.0),
    "L": (0.0, -1.0, 0.0),
}
"""Twists that keys mean, as parts of the limits; those from u to L as in teleop_twist_keyboard of ROS."""

HELP = (
    "w s, up down: ahead, back   a d, left right: turn   u o, m .: ahead, back in a bow   J L: sideways\n"
    "hold a key to go on: without one it stops   space or k stops   [ ] slower, faster   q ends"
)


class ToolLimits(NamedTuple):
    """Frame of a tool's twists, a name of FRAMES or a node's, and its greatest speeds (m/s, rad/s)."""

    frame: str
    speed: float
    turn: float


class Share:
    """Share of the limits that is moved with, in tenths."""

    def __init__(self) -> None:
        """Begin with all of them."""
        self._tenths = 10

    @property
    def part(self) -> float:
        """The share, 0.1 to 1."""
        return self._tenths / 10.0

    def change(self, tenths: int) -> None:
        """Take some tenths more, or less, as far as that goes."""
        self._tenths = min(10, max(1, self._tenths + tenths))


class DriveKeys:
    """Values that the keys of a terminal mean: those of the one which is held down."""

    def __init__(
        self,
        limits: Values,
        meanings: Mapping[str, Values] = KEYS,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Take the greatest values, and which parts of them each key means."""
        self._limits, self._meanings = limits, meanings
        self._held = HeldKey(clock)
        self._share = Share()

    @property
    def share(self) -> float:
        """Share of the limits that is driven with, 0.1 to 1."""
        return self._share.part

    def press(self, key: str) -> None:
        """Take a key; one that means nothing changes nothing."""
        if key in ("[", "]"):
            self._share.change(1 if key == "]" else -1)
        elif key in self._meanings:
            self._held.press(key)
        elif key in (" ", "k"):
            self._held.release()

    def wanted(self) -> Values:
        """Return the values that are wanted now, in the units of the limits."""
        parts = self._meanings.get(self._held.key, (0.0,) * len(self._limits))
        return tuple(self.share * most * part for most, part in zip(self._limits, parts, strict=True))


class Teleoperation:
    """Drives a craft, or moves joints or a tool, by what somebody wants, RATE_HERTZ times a second, in a thread.

    A context manager. The robot is this program's only while something is wanted, and for IDLE_SECONDS. What the kernel
    refuses is in `error`, and nothing is moved until nothing was wanted for a moment: who holds a key on lets go first.
    At the end of the block the robot comes to rest, and also when the program dies.
    """

    def __init__(
        self,
        robot: Robot,
        wanted: Callable[[], Values],
        preempt: bool = False,
        joints: Sequence[str] = (),
        tool: ToolLimits | None = None,
    ) -> None:
        """Drive a craft as `wanted` says, or move `joints` or a tool; `preempt`: cancel motions in the way.

        Raises WrongStateError when the robot is no craft and no joints or tool are named.
        """
        if not joints and tool is None:
            robot.way([])
        self._robot, self._wanted, self._preempt = robot, wanted, preempt
        self._joints, self._tool = list(joints), tool
        self._resting: Values = (0.0,) * 6 if tool else (0.0,) * len(joints) if joints else REST
        self._stream: SetpointStream | None = None
        self._wanted_at = 0.0
        self._refused = False
        self._ended = threading.Event()
        self.twist, self.error = self._resting, ""
        self._thread = threading.Thread(target=self._run, name="teleoperation", daemon=True)
        self._thread.start()

    @property
    def held_by(self) -> str:
        """Cause that keeps a tool slower than wanted: a joint's name, or `singularity`; empty when nothing does."""
        stream = self._stream
        return stream.state.held_by if stream is not None else ""

    @property
    def place(self) -> tuple[float, float, float]:
        """Place (x and y in m) and heading (rad) of the craft's base."""
        return self._robot.way([]).begin

    def _run(self) -> None:
        while not self._ended.wait(1.0 / RATE_HERTZ):
            try:
                self.twist = self._wanted()
                if self.twist == self._resting:
                    self._rest()
                elif not self._refused:
                    self._drive(self.twist)
            except VirtualRobotError as error:
                self._refused, self.error = True, str(error)
                self._give_up()

    def _drive(self, twist: Values) -> None:
        self._wanted_at, self.error = time.monotonic(), ""
        if self._stream is None:
            robot, preempt = self._robot, self._preempt
            if (tool := self._tool) is not None:
                self._stream = robot.stream_tool(
                    frame=tool.frame if tool.frame in FRAMES else None,
                    node=None if tool.frame in FRAMES else tool.frame,
                    max_velocity=tool.speed,
                    max_rotation_velocity=tool.turn,
                    timeout=TIMEOUT_SECONDS,
                    preempt=preempt,
                )
            elif self._joints:
                self._stream = robot.stream("velocity", self._joints, timeout=TIMEOUT_SECONDS, preempt=preempt)
            else:
                self._stream = robot.stream_twist(timeout=TIMEOUT_SECONDS, preempt=preempt)
        self._stream.send(twist)

    def _rest(self) -> None:
        self._refused = False
        if self._stream is None:
            return
        if time.monotonic() - self._wanted_at < IDLE_SECONDS:
            self._stream.send(self._resting)
        else:
            self._stream.close(REST_SECONDS)
            self._stream = None

    def _give_up(self) -> None:
        if self._stream is not None:
            self._stream.cancel("what drives it was refused")
            self._stream = None

    def close(self) -> None:
        """Let the robot come to rest."""
        self._ended.set()
        self._thread.join()
        try:
            if self._stream is not None:
                self._stream.close(REST_SECONDS)
        except VirtualRobotError as error:  # it was stopped already, or cannot be reached
            self.error = str(error)

    def __enter__(self) -> Teleoperation:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Let the craft come to rest."""
        self.close()
