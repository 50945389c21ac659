"""Queue of a program's motions: an open program of the kernel, to which moves are appended as the language gives them.

A program runs ahead of its robot by a few moves. What touches the world waits for the robot first: after a move without
a zone until it stands, after one with a zone until shortly before its end, so that the next move can still join it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import TypeAlias

from virtualrobot.connection import Client
from virtualrobot.errors import CallTimeoutError, MotionAbortedError, MotionEndedError
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.moves import Move
from virtualrobot.motions.program import Program
from virtualrobot.motions.state import MotionState, Phase, PlanNote

from virtualrobot_apps.languages.core.task import Task

SignalValue: TypeAlias = bool | int | float | str
"""A value that a signal is given."""

AHEAD = 4
"""Number of moves that are not done by which a program may be ahead.

Planning takes its time, and a move that comes when the one before has ended begins from rest.
"""
LEAD_SECONDS = 0.3
"""Time (s) before the end of a move with a zone at which a program goes on that has waited for it."""
STOP_SECONDS = 10.0
"""Time (s of the wall clock) that a robot has to come to rest; in stepped time nobody may let it."""
POLL_SECONDS = 0.01
"""Time (s of the wall clock) from one look at a motion to the next while a program waits for it."""


class SignalTimeout(Exception):
    """A signal did not have its value in time."""


class MotionQueue:
    """Moves, signals and dwells of one program, on their way to the kernel."""

    def __init__(self, client: Client, task: Task) -> None:
        """Begin without a motion."""
        self._client, self._task = client, task
        self._motion: Motion | None = None
        self._held: Program | None = None
        self._count = 0
        self._moves: deque[int] = deque()
        self._zone = False
        self.notes: list[PlanNote] = []

    def move(self, move: Move, zone: float = 0.0) -> None:
        """Append a move; `zone` is the radius (m) of its corner with the next move, 0: none.

        Raises the error of the planner, and then the robot goes on as if the move had not been given.
        """
        self._room()
        self._send(self._taken().move(move, zone=zone or None))
        self._moves.append(self._count - 1)
        self._zone = zone > 0.0

    def set(self, signal: str, value: SignalValue) -> None:
        """Set a signal: in the zone after the last move, or else when all before it is done."""
        if self._motion is None:
            self._client.signals[signal] = value
        elif self._zone:
            self._held = (self._held or self._client.program()).set(signal, value)
        else:
            self._send(self._client.program().set(signal, value))

    def dwell(self, seconds: float) -> None:
        """Stand still for so many seconds of simulation time when all before it is done."""
        self.flush()
        self._send(self._client.program().dwell(seconds))
        self._zone = False

    def wait_signal(self, signal: str, value: SignalValue, timeout: float | None) -> None:
        """Stand still until a signal has a value; with a timeout (s of simulation time) until that is so.

        Raises SignalTimeout when it has not.
        """
        self.flush()
        self._send(self._client.program().wait(signal, value, timeout))
        self._zone = False
        if timeout is None:
            return
        try:
            self.finish()
        except MotionAbortedError as error:
            if error.metadata["end_cause"] != "signal_timeout":
                raise
            self._forget()
            raise SignalTimeout(error.message) from error

    def flush(self) -> None:
        """Send signals that wait for the next move: they are set at rest."""
        if self._held is not None:
            self._send(self._taken())
            self._zone = False

    def settle(self) -> None:
        """Wait until the world may be looked at: at rest, or shortly before the end of a move with a zone."""
        self.flush()
        if self._zone:
            self._wait(lambda state: (1.0 - state.progress) * state.planned_duration <= LEAD_SECONDS)
        else:
            self.finish()

    def finish(self) -> None:
        """Wait until all is done and the robot stands."""
        self.flush()
        self._wait(lambda _: False)
        self._moves.clear()
        self._zone = False

    def close(self) -> None:
        """Wait for all, and end the kernel's program."""
        self.finish()
        if self._motion is not None:
            self._motion.append(last=True)
            self._motion.wait(timeout=600.0)
            self._forget()

    def cancel(self, why: str) -> None:
        """Stop the robot on its path, wait until it stands, and forget what was not done."""
        if self._motion is not None and not self._motion.phase.ended:
            self._motion.cancel(why)
            with suppress(MotionEndedError, CallTimeoutError):
                self._motion.wait(timeout=STOP_SECONDS)
        self._forget()

    def _forget(self) -> None:
        self._motion, self._held, self._zone, self._count = None, None, False, 0
        self._moves.clear()

    def _taken(self) -> Program:
        held, self._held = self._held, None
        return held if held is not None else self._client.program()

    def _send(self, steps: Program) -> None:
        if self._motion is None:
            self._motion = steps.start(open=True)
            notes = self._motion.notes
        else:
            self._motion.state.raise_early_end()
            notes = self._motion.append(steps)
        self.notes += notes
        self._count += len(steps)

    def _room(self) -> None:
        """Wait until another move may be appended."""

        def fewer(state: MotionState) -> bool:
            while self._moves and self._moves[0] < state.step:
                self._moves.popleft()
            return len(self._moves) < AHEAD

        if len(self._moves) >= AHEAD:
            self._wait(fewer)

    def _wait(self, enough: Callable[[MotionState], bool]) -> None:
        """Wait until a state of the motion is enough, or it has done all its steps."""
        while self._motion is not None:
            state = self._motion.state
            state.raise_early_end()
            if state.phase is Phase.STARVED:
                self._moves.clear()
                return
            if enough(state):
                return
            self._task.pause(POLL_SECONDS)
