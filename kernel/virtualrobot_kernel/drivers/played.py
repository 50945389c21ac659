"""Ticks that a real robot has played, and how each was known to be good; what the journal is told."""

from __future__ import annotations

from itertools import pairwise

from virtualrobot_kernel.world.apply_motions import is_known
from virtualrobot_kernel.world.history_commands import PlayedTicks
from virtualrobot_kernel.world.state import Motion, State

STOOD = "it stood"
WHOLE = "checked as a whole before it began, and guarded tick by tick, with all brakes"
GUARDED = "guarded tick by tick, with all brakes"


class Played:
    """Ticks of one robot (a uid) after the one at which it was let follow.

    The world thread tells each tick of the twin. How far the robot has come, which is a lead earlier, is told before
    its ranges are taken.

    Attributes:
        noted: the tick of the twin at which ranges were taken last.
    """

    def __init__(self, robot: int, tick: int) -> None:
        """Begin after a tick."""
        self._robot = robot
        self.noted = self._told = self._reached = tick
        self._checks: list[tuple[int, str]] = [(tick + 1, STOOD)]
        self._motions: tuple[Motion, ...] | None = None
        self._guarded: frozenset[str] = frozenset()

    def reached(self, tick: int) -> None:
        """Say which tick the robot plays, or did last; -1: none."""
        self._reached = max(self._reached, tick)

    def twin_at(self, state: State) -> None:
        """Say what moves the twin in a new tick."""
        if state.motions is self._motions:
            return
        self._motions = state.motions
        own = [motion for motion in state.motions if self._robot in motion.robots]
        # One that was open once stays guarded when it is closed: what was appended has not been checked before.
        self._guarded = frozenset(motion.id for motion in own if motion.id in self._guarded or not is_known(motion))
        check = STOOD if not own else GUARDED if self._guarded else WHOLE
        if check != self._checks[-1][1]:
            # A motion that has ended has made this tick yet.
            self._checks.append((state.tick + (check == STOOD), check))

    def take(self) -> list[PlayedTicks]:
        """Return what was played and not told yet, a range of ticks for each way in which it was checked."""
        first, last = self._told + 1, self._reached
        ends = [*self._checks, (last + 1, "")]
        found = [
            PlayedTicks(self._robot, max(first, begin), min(last, end - 1), check)
            for (begin, check), (end, _) in pairwise(ends)
            if max(first, begin) <= min(last, end - 1)
        ]
        over = sum(begin <= last for begin, _ in self._checks) - 1
        del self._checks[: max(0, over)]
        self._told = max(self._told, last)
        return found
