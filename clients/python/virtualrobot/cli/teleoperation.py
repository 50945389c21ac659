"""Teleoperation of a craft: twists from keys or a gamepad, within limits, and none without somebody who wants them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from virtualrobot.errors import InvalidArgumentError, VirtualRobotError

if TYPE_CHECKING:
    from virtualrobot.robots.robot import Robot

Twist = tuple[float, float, float]
"""vx and vy in m/s along the axes of the base, and its turning rate in rad/s to the left."""

REST: Twist = (0.0, 0.0, 0.0)
RATE_HERTZ = 20.0
"""Rate at which twists are sent."""
TIMEOUT_SECONDS = 0.5
"""Simulation time (s) without a twist after which the craft stops: this program has gone."""
HELD_SECONDS = 0.6
"""Time (s) for which a key counts as held: terminals repeat a key that is held, and tell nothing when it is let go."""

KEYS: dict[str, Twist] = {
    **{key: (1.0, 0.0, 0.0) for key in ("w", "up")},
    **{key: (-1.0, 0.0, 0.0) for key in ("s", "down")},
    **{key: (0.0, 0.0, 1.0) for key in ("a", "left")},
    **{key: (0.0, 0.0, -1.0) for key in ("d", "right")},
    "e": (1.0, 0.0, 1.0),
    "r": (1.0, 0.0, -1.0),
    "z": (0.0, 1.0, 0.0),
    "x": (0.0, -1.0, 0.0),
}
"""Twist of each key, as parts of the limits."""

HELP = (
    "w or up, s or down drive   a or left, d or right turn   e and r in a bow   z and x sideways\n"
    "hold a key to go on: without one it stops   space stops   [ ] slower, faster   q ends"
)


@dataclass(frozen=True, slots=True)
class Limits:
    """Greatest speed (m/s) and turning rate (rad/s)."""

    speed: float = 0.5
    turn: float = 1.0

    def __post_init__(self) -> None:
        """Raise InvalidArgumentError for limits that are none."""
        if not (0.0 < self.speed < 1e3 and 0.0 < self.turn < 1e3):
            raise InvalidArgumentError(f"limits are above 0, not {self.speed:g} m/s and {self.turn:g} rad/s")

    def twist(self, forward: float, left: float, turn: float) -> Twist:
        """Return the twist of parts of the limits; what is beyond -1 and 1 counts as these."""
        forward, left, turn = (min(1.0, max(-1.0, part)) for part in (forward, left, turn))
        return forward * self.speed, left * self.speed, turn * self.turn


@dataclass(slots=True)
class HeldKeys:
    """The key that is held down, as far as a terminal tells: it counts for HELD_SECONDS after it came last."""

    limits: Limits
    clock: Callable[[], float] = time.monotonic
    scale: float = 1.0
    _key: str = ""
    _came: float = field(default=0.0)

    def press(self, key: str) -> None:
        """Take a key."""
        if key in "[]":
            self.scale = min(1.0, max(0.1, self.scale + (0.1 if key == "]" else -0.1)))
        elif key in KEYS:
            self._key, self._came = key, self.clock()
        elif key == " ":
            self._key = ""

    def twist(self) -> Twist:
        """Return the twist that is wanted now."""
        if not self._key or self.clock() - self._came > HELD_SECONDS:
            return REST
        return self.limits.twist(*(self.scale * part for part in KEYS[self._key]))


@dataclass(frozen=True, slots=True)
class Gamepad:
    """Mapping of a gamepad: which axes drive, which button is the dead man's, as `inputs` calls them.

    lowest, highest: what an axis tells at its ends; dead_zone: part of the way from its middle that counts as none.
    """

    forward: str = "ABS_Y"
    turn: str = "ABS_X"
    left: str = "ABS_RX"
    dead_man: str = "BTN_TL"
    lowest: float = -32768.0
    highest: float = 32767.0
    dead_zone: float = 0.1

    def part(self, value: float) -> float:
        """Return how far an axis is off its middle, -1 to 1."""
        middle, half = (self.lowest + self.highest) / 2.0, (self.highest - self.lowest) / 2.0
        off = min(1.0, max(-1.0, (value - middle) / half))
        beyond = (abs(off) - self.dead_zone) / (1.0 - self.dead_zone)
        return 0.0 if beyond <= 0.0 else beyond if off > 0.0 else -beyond


@dataclass(slots=True)
class HeldGamepad:
    """Sticks and the dead man's button of a gamepad, as its events have told them; all that is told is kept."""

    limits: Limits
    pad: Gamepad = field(default_factory=Gamepad)
    gone: bool = False
    _axes: dict[str, float] = field(default_factory=dict)
    _held: bool = False

    def take(self, code: str, value: float) -> None:
        """Take an event."""
        if code == self.pad.dead_man:
            self._held = value > 0
        elif code in (self.pad.forward, self.pad.turn, self.pad.left):
            self._axes[code] = self.pad.part(value)

    def follow(self, events: Iterable[tuple[str, float]]) -> None:
        """Take events until there are no more: then nobody holds it any more."""
        try:
            for code, value in events:
                self.take(code, value)
        finally:
            self.gone, self._held = True, False

    def twist(self) -> Twist:
        """Return the twist that is wanted now: none while the dead man's button is up. A stick tells less upwards."""
        if not self._held:
            return REST
        forward, turn, left = (self._axes.get(one, 0.0) for one in (self.pad.forward, self.pad.turn, self.pad.left))
        return self.limits.twist(-forward, -left, -turn)


class Teleoperation:
    """Drives a craft by what somebody wants, RATE_HERTZ times a second, in a thread; a context manager.

    At the end, and when this program dies, the craft comes to rest. The kernel keeps its drives within their limits.
    """

    def __init__(self, robot: Robot, wanted: Callable[[], Twist]) -> None:
        """Drive a craft as `wanted` says; raises as `Robot.stream_twist` does."""
        self._wanted = wanted
        self._stream = robot.stream_twist(timeout=TIMEOUT_SECONDS, preempt=True)
        self._robot = robot
        self._ended = threading.Event()
        self.error: VirtualRobotError | None = None
        self.twist: Twist = REST
        self._thread = threading.Thread(target=self._run, name="teleoperation", daemon=True)
        self._thread.start()

    @property
    def place(self) -> tuple[float, float, float]:
        """Place (m) and heading (rad) of the craft."""
        x, y, heading = self._stream.state.positions.tolist()
        return x, y, heading

    def _run(self) -> None:
        while not self._ended.is_set():
            self.twist = self._wanted()
            try:
                self._stream.send(self.twist)
            except VirtualRobotError as error:
                # Such as one that a guard has stopped: what is wanted next starts anew once nothing is wanted.
                self.error = error
                if not self._anew():
                    return
            self._ended.wait(1.0 / RATE_HERTZ)

    def _anew(self) -> bool:
        """Open another stream once nothing is wanted any more; return whether there is one."""
        while not self._ended.is_set():
            self.twist = REST
            if self._wanted() == REST:
                try:
                    self._stream = self._robot.stream_twist(timeout=TIMEOUT_SECONDS, preempt=True)
                    return True
                except VirtualRobotError as error:
                    self.error = error
            self._ended.wait(1.0 / RATE_HERTZ)
        return False

    def close(self) -> None:
        """Let the craft come to rest."""
        self._ended.set()
        self._thread.join()
        try:
            self._stream.close(10.0)
        except VirtualRobotError as error:  # it rests already, or cannot be reached
            self.error = error

    def __enter__(self) -> Teleoperation:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Let the craft come to rest."""
        self.close()
