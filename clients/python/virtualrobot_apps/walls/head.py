"""Heads and flysticks by UDP: one line of words in a datagram, which any tracker's program can write.

    head COUNTER X Y Z QX QY QZ QW      pose of the tracked body: m and a quaternion, in the tracker's frame
    fly COUNTER AHEAD LEFT UP TURN      a flystick's axes, each from -1 to 1

The counter grows with each datagram of its kind, so that one that was overtaken on the way counts no more.
"""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType

import numpy as np
from virtualrobot.errors import InvalidArgumentError, WrongStateError
from virtualrobot.geometry import pose_from_quaternion

from virtualrobot_apps.walls.display import Display, flown

LONGEST = 512
"""Bytes of a datagram at most."""

COUNTS = {"head": 7, "fly": 4}
"""Count of the numbers that follow the counter, by kind."""

SILENT = 0.5
"""Time (s) without a datagram of a kind after which it counts as lost: a head stays, a flystick is let go."""


@dataclass(frozen=True, slots=True)
class Told:
    """Line of a datagram: its kind, its counter, and its numbers."""

    kind: str
    counter: int
    values: tuple[float, ...]


def told(datagram: bytes) -> Told:
    """Return what a datagram says.

    Raises:
        InvalidArgumentError: for one that is no such line, and for a quaternion that is far from a unit one.
    """
    if len(datagram) > LONGEST:
        raise InvalidArgumentError(f"a datagram has {len(datagram)} bytes; one line has at most {LONGEST}")
    try:
        kind, counter, *words = datagram.decode("ascii").split()
        number, values = int(counter), tuple(float(word) for word in words)
    except ValueError:
        raise InvalidArgumentError(f"{datagram[:60]!r} is no line such as 'head 1 0 0 1.7 0 0 0 1'") from None
    if kind not in COUNTS or len(values) != COUNTS[kind]:
        forms = " or ".join(f"'{one}', a counter and {count} numbers" for one, count in COUNTS.items())
        raise InvalidArgumentError(f"{datagram[:60]!r} is not {forms}")
    if number < 0 or not all(math.isfinite(one) for one in values):
        raise InvalidArgumentError(f"{datagram[:60]!r} has a number that is not finite, or a counter below 0")
    if kind == "head" and abs(math.hypot(*values[3:]) - 1.0) > 0.01:
        raise InvalidArgumentError(f"{datagram[:60]!r} has a quaternion of length {math.hypot(*values[3:]):.3g}, not 1")
    return Told(kind, number, values)


class Observer:
    """Observer before a display, as datagrams tell of head and flystick. No thread, no socket: time is given."""

    def __init__(self, display: Display) -> None:
        """Stand where the file says, with no head tracked."""
        self.display = display
        self.world_t_room = display.world_t_room
        self.room_t_head = display.standing
        self._axes = (0.0, 0.0, 0.0, 0.0)
        self._counters = dict.fromkeys(COUNTS, -1)
        self._heard = dict.fromkeys(COUNTS, -math.inf)
        self._now = -math.inf

    def tracked(self, now: float) -> bool:
        """Return whether a head was told of within the last half second."""
        return now - self._heard["head"] <= SILENT

    def hear(self, datagram: bytes, now: float) -> bool:
        """Take what a datagram says that came at `now` (s), and return whether it counts; raise for nonsense.

        One with an older counter doesn't, unless its kind was silent: then its sender has begun anew.
        """
        said = told(datagram)
        if said.counter <= self._counters[said.kind] and now - self._heard[said.kind] <= SILENT:
            return False
        self.advance(now)
        self._counters[said.kind], self._heard[said.kind] = said.counter, now
        if said.kind == "fly":
            self._axes = said.values[0], said.values[1], said.values[2], said.values[3]
        else:
            tracker = self.display.tracker
            body = pose_from_quaternion(said.values[:3], said.values[3:])
            self.room_t_head = tracker.room_t_tracker @ body @ tracker.body_t_head
        return True

    def advance(self, now: float) -> None:
        """Fly up to `now` (s) by the flystick's axes, which are let go when it is silent."""
        until = min(now, self._heard["fly"] + SILENT)
        if until > self._now and math.isfinite(self._now):
            self.world_t_room = flown(self.world_t_room, self._axes, self.display.speed, until - self._now)
        self._now = max(self._now, now)


class Listener:
    """Socket that datagrams come to; `close` it, or use it in a `with` block."""

    def __init__(self, host: str, port: int) -> None:
        """Listen at an address; port 0 means any. Raises WrongStateError where it is taken or isn't this machine's."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            raise WrongStateError(f"nothing can be heard at {host}:{port}: {error.strerror or error}") from error

    @property
    def port(self) -> int:
        """The port that it listens at."""
        return self._socket.getsockname()[1]

    def listen(
        self,
        observer: Observer,
        changed: Callable[[], None],
        refused: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Wait for a datagram, 50 ms at most, and take all that have come: `changed` is called once for all of them.

        While a flystick is held it is called without one, too; `refused` is told what was wrong with a datagram.
        """
        before = observer.world_t_room
        self._socket.settimeout(0.05)
        counts = False
        try:
            while True:
                data = self._socket.recv(LONGEST + 1)
                try:
                    counts |= observer.hear(data, clock())
                except InvalidArgumentError as error:
                    refused(str(error))
                self._socket.setblocking(False)
        except (TimeoutError, BlockingIOError):
            pass
        observer.advance(clock())
        if counts or not np.array_equal(before, observer.world_t_room):
            changed()

    def close(self) -> None:
        """Listen no more."""
        self._socket.close()

    def __enter__(self) -> Listener:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()
