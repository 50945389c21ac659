"""Queue of a program's motions: an open program of the kernel, to which moves are appended as the language gives them.

A program runs ahead of its robot by a few moves. What touches the world waits for the robot first: after a move without
a zone until it stands, after one with a zone until shortly before its end, so that the next move can still join it.
"""

from __future__ import annotations

import operator
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import Any, TypeAlias

from virtualrobot.connection import Client
from virtualrobot.errors import MotionAbortedError, VirtualRobotError, WrongStateError
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.moves import Move
from virtualrobot.motions.program import Program
from virtualrobot.motions.state import MotionState, Phase, PlanNote, Search

from virtualrobot_apps.languages.core.task import Task
from virtualrobot_apps.languages.core.zones import Corner, Zone, size_of, zone_of

SignalValue: TypeAlias = bool | int | float | str
"""A value that a signal is given."""

AHEAD = 4
"""Number of moves that are not done by which a program may be ahead.

Planning takes its time, and a move that comes when the one before has ended begins from rest.
"""
LEAD_SECONDS = 0.3
"""Time (s) before the end of a move with a zone, or before a controller's zone, at which a waiting program goes on."""
STOP_SECONDS = 10.0
"""Time (s of the wall clock) that a robot has to come to rest; in stepped time nobody may let it."""
POLL_SECONDS = 0.01
"""Time (s of the wall clock) from one look at a motion to the next while a program waits for it."""
COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    **{"==": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
}
PLACES = 1000
"""Number of the latest steps whose place in the program is known."""
ASIDE = "the program puts its path aside"


def _moving(move: Move, beside: Sequence[Move], zone: Zone, **timed: float) -> Callable[[Program], Program]:
    """Return what adds a move, and others beside it, to a program."""
    return lambda program: program.move(move, *beside, **zone_of(zone), **timed)


class SignalTimeout(Exception):
    """A signal did not have its value in time."""


@dataclass(frozen=True, slots=True)
class Step:
    """A step on its way to the kernel.

    Attributes:
        add: adds it to a program.
        moves: whether it is a move.
        again: makes the step that does what is left of it from where the robot stands; None: itself.
        place: the place, as `Task.place` tells it, of the statement that it comes from; empty before it is sent.
    """

    add: Callable[[Program], Program]
    moves: bool = False
    again: Callable[[], Step] | None = None
    place: str = ""

    def rest(self) -> Step:
        """Return the step that does what is left of it, at the same place."""
        return self if self.again is None else replace(self.again(), place=self.place)


@dataclass(slots=True)
class Stored:
    """Path that was put aside: its steps that are not done, whether it was stopped, and whether its end has a zone."""

    steps: list[Step]
    stopped: bool
    zone: bool


@dataclass(frozen=True, slots=True)
class _Mark:
    """Something that is called when a step of a motion has begun, or at a nominal time (s) of it where that is told."""

    number: int
    what: Callable[[], None]
    time: float = inf

    def passed(self, state: MotionState) -> bool:
        """Return whether that is so."""
        over = state.step >= self.number or state.phase is Phase.STARVED or state.phase.ended
        return over or state.progress * state.planned_duration >= self.time


class MotionQueue:
    """Moves, signals and dwells of one program, on their way to the kernel.

    Attributes:
        concurrent: whether the last move lets the program go on at once, and so touch the world while it is made.
        stopped: whether moves wait until somebody starts them.
        notes: what the planner had to tell of all moves.
    """

    def __init__(self, client: Client, task: Task) -> None:
        """Begin without a motion."""
        self._client, self._task = client, task
        self._motion: Motion | None = None
        self._held: list[Step] = []
        self._count = 0
        self._sent: deque[tuple[int, Step]] = deque()
        self._places: deque[tuple[int, str]] = deque(maxlen=PLACES)
        self._marks: list[tuple[Motion, _Mark]] = []
        self._zone, self._lead = False, LEAD_SECONDS
        self._stored: list[Stored] = []
        self._waiting: list[Step] = []
        self._batch: list[Step] | None = None
        self._calls: list[tuple[int, float, Callable[[], None]]] = []
        self.concurrent = self.stopped = False
        self.notes: list[PlanNote] = []

    def move(
        self,
        move: Move,
        zone: Zone = 0.0,
        *,
        concurrent: bool = False,
        again: Callable[[], Step] | None = None,
        beside: Sequence[Move] = (),
        min_duration: float | None = None,
    ) -> None:
        """Append a move; `zone` is that of its corner with the next move, 0: none; others go `beside` it.

        It takes `min_duration` (s) at least, where that is told; what is left of it after a stop takes what it takes.

        Raises the error of the planner, and then the robot goes on as if the move had not been given.
        """
        if self._batch is None:
            self._room()
        timed = {} if min_duration is None else {"min_duration": min_duration}
        rest = again or (None if min_duration is None else lambda: Step(_moving(move, beside, zone), True))
        self._send([*self._held, Step(_moving(move, beside, zone, **timed), True, rest)])
        self._held = []
        self._zone, self.concurrent = size_of(zone) > 0.0, concurrent
        self._lead = LEAD_SECONDS + (zone.seconds if isinstance(zone, Corner) else 0.0)

    def set(self, signal: str, value: SignalValue, lead: float = 0.0) -> None:
        """Set a signal: in the zone after the last move, or else when all before it is done.

        lead: how much earlier (s), where the move before is given `together` with it or has a zone.
        """
        step = Step(lambda program: program.set(signal, value, lead=lead))
        if (self._motion is None and not self._batch) or self.free:
            self._client.signals[signal] = value
        elif self._zone:
            self._held.append(step)
        else:
            self._send([step])

    def dwell(self, seconds: float) -> None:
        """Stand still for so many seconds of simulation time when all before it is done."""
        self.add(lambda program: program.dwell(seconds))

    def wait_signal(self, signal: str, value: SignalValue, timeout: float | None, comparison: str = "==") -> None:
        """Stand still until a signal compares so with a value; with a timeout (s of simulation time) until that is so.

        Raises SignalTimeout when it has not.
        """
        self.add(lambda program: program.wait(signal, value, timeout, comparison))
        if timeout is None:
            return
        try:
            self.finish()
        except MotionAbortedError as error:
            if error.metadata["end_cause"] != "signal_timeout":
                raise
            self._forget()
            raise SignalTimeout(error.message) from error

    def look(self, signal: str, value: SignalValue, timeout: float | None, comparison: str = "==") -> None:
        """Wait until a signal compares so with a value, while the robot moves; otherwise as `wait_signal`."""
        compare = COMPARE[comparison]
        begin = self._client.clock.simulation_time
        while not compare(self._client.signals[signal], value):
            if timeout is not None and self._client.clock.simulation_time - begin >= timeout:
                raise SignalTimeout(f"the signal {signal!r} did not compare so within {timeout:g} s")
            self._task.pause(POLL_SECONDS)

    def search(self, program: Program) -> Search | None:
        """Make a program of its own, whose last step searches, and return what it has found."""
        self.close()
        while self.stopped:
            self._task.pause(POLL_SECONDS)
        self._motion = program.start(wait=False)
        self._count = len(program)
        self._wait(lambda state: state.phase is Phase.SUCCEEDED)
        found = self._motion.search
        self._forget()
        return found

    def add(self, add: Callable[[Program], Program]) -> None:
        """Append another step, which begins when the robot stands; `add` adds it to a program."""
        self.flush()
        self._send([Step(add)])
        self._zone = self.concurrent = False

    @property
    def in_zone(self) -> bool:
        """True where the next move joins the one before it by a zone."""
        return self._zone

    @property
    def rests(self) -> bool:
        """True where all that was given is done."""
        return self._motion is None or self._motion.state.phase is Phase.STARVED

    def place(self, states: Iterable[MotionState]) -> str:
        """Return the place, as `Task.place` tells it, of the step that is done in states of motions; else nothing."""
        for state in states:
            motion = self._motion
            if motion is not None and state.id == motion.id:
                done = state.phase is Phase.STARVED or state.phase.ended
                # A copy, since the program's own thread goes on meanwhile.
                return "" if done else next((place for number, place in (*self._places,) if number == state.step), "")
        return ""

    def doing(self) -> str:
        """Return the place of the step that is done now; else nothing."""
        motion = self._motion
        return self.place([motion.state]) if motion is not None else ""

    def begun(self) -> None:
        """Wait until the robot has begun the last move."""
        last = max((number for number, step in self._sent if step.moves), default=-1)
        self._wait(lambda state: state.step >= last)

    def flush(self) -> None:
        """Send signals that wait for the next move: they are set at rest."""
        if self._held:
            held, self._held = self._held, []
            self._send(held)
            self._zone = False

    def settle(self) -> None:
        """Wait until the world may be looked at: at rest, or shortly before the end of a move with a zone."""
        if self.free:
            return
        self.flush()
        if self._zone:
            self._wait(lambda state: (1.0 - state.progress) * state.planned_duration <= self._lead)
        else:
            self.finish()

    def finish(self) -> None:
        """Wait until all is done and the robot stands."""
        self.flush()
        self._wait(lambda _: False)
        self._sent.clear()
        self._zone = self.concurrent = False

    def close(self) -> None:
        """Wait for all, and end the kernel's program."""
        self.finish()
        if self._motion is not None:
            self._motion.append(last=True)
            while not (state := self._motion.state).phase.ended:
                self._task.pause(POLL_SECONDS)
            state.raise_early_end()
            self._forget()

    def cancel(self, why: str) -> None:
        """Stop the robot on its path, wait until it stands, and forget what was not done."""
        self._stored.clear()
        self._waiting, self.stopped = [], False
        self._end(why)

    # Paths that are stopped and put aside.

    @property
    def free(self) -> bool:
        """True where the program may touch the world without waiting for its moves."""
        return self.concurrent or self.stopped

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Let the program touch the world for the length of a block, while the moves before it are made."""
        before, self.concurrent = self.concurrent, True
        try:
            yield
        finally:
            self.concurrent = before

    def stop(self) -> None:
        """Brake on the path, and wait until the robot stands; moves that come now wait for `start`."""
        self.stopped = True
        if self._motion is None:
            return
        self._motion.pause()
        while self._motion.state.phase is Phase.PAUSING:
            self._task.pause(POLL_SECONDS)

    def start(self) -> None:
        """Go on after `stop`."""
        self.stopped = False
        waiting, self._waiting = self._waiting, []
        if waiting:
            self._send([step.rest() for step in waiting])
        elif self._motion is not None and self._motion.state.phase in (Phase.PAUSING, Phase.PAUSED):
            self._motion.resume()

    def store(self) -> None:
        """Put the path aside so that others can be made: after the move that is made now, or where it was stopped."""
        stored = Stored([], self.stopped, self._zone)
        steps, held, self._held = self._pending(), self._held, []
        if not self.stopped and steps:
            first = next((number for number, step in enumerate(steps, 1) if step.moves), len(steps))
            steps, rest = steps[:first], steps[first:]
            if rest:
                self._end(ASIDE)
                self._send([step.rest() for step in steps])
            self.finish()
            steps = rest
        self._end(ASIDE)
        stored.steps = [*steps, *self._waiting, *held]
        self._stored.append(stored)
        self._waiting, self.stopped = [], False

    def restore(self) -> None:
        """Wait until all is done, and go on with the path that was put aside last: at once, or by `start`."""
        self.close()
        stored = self._stored.pop()
        if stored.stopped:
            self.stopped, self._waiting = True, stored.steps
        elif stored.steps:
            self._send(stored.steps)
        self._zone = stored.zone

    @property
    def level(self) -> int:
        """Number of paths that are put aside."""
        return len(self._stored)

    def call_at(self, what: Callable[[], None], lead: float = 0.0) -> None:
        """Call something when the place is passed where the last move ends, or its zone is.

        A thread of its own does so, or `passed`. lead: how much earlier (s) than the last of the moves ends that are
        given `together`.
        """
        number = len(self._batch or ()) + len(self._held)
        if self._batch is not None:
            self._calls.append((number, lead, what))
        elif self._motion is None:
            what()
        else:
            self._call(self._motion, _Mark(self._count + number, what))

    def passed(self, states: Iterable[MotionState]) -> None:
        """Call what `call_at` has kept, where time goes on for this program alone, by states of motions."""
        by_name = {state.id: state for state in states}
        marks, self._marks = self._marks, []
        for motion, mark in marks:
            state = by_name.get(motion.id)
            if state is None or not mark.passed(state):
                self._marks.append((motion, mark))
            elif state.phase not in (Phase.CANCELLED, Phase.ABORTED):
                mark.what()

    def _call(self, motion: Motion, mark: _Mark) -> None:
        if self._task.passing is not None:
            self._marks.append((motion, mark))
            return
        passed = partial(self._call_when_passed, motion, mark)
        threading.Thread(target=passed, name="path mark", daemon=True).start()

    @contextmanager
    def together(self) -> Iterator[None]:
        """Send the steps of a block as one, so that the robot can't come to the end of one before the next is there."""
        self._room()
        self._batch = []
        try:
            yield
            steps, self._batch = self._batch, None
            self._send(steps)
        finally:
            self._batch, self._calls = None, []

    def _call_when_passed(self, motion: Motion, mark: _Mark) -> None:
        with suppress(VirtualRobotError):  # the kernel is gone, which the program notices itself
            if mark.time == inf:
                for event in motion.watch_steps(max_rate=1.0 / POLL_SECONDS):
                    if event.step + (event.kind == "done") >= mark.number:
                        mark.what()
                        return
            while not mark.passed(state := motion.state):
                time.sleep(POLL_SECONDS)
            if state.phase not in (Phase.CANCELLED, Phase.ABORTED):
                mark.what()

    def forget_path(self) -> None:
        """Leave out the moves that are not done; the robot must stand (`stop`)."""
        self._waiting = []
        self._end("the program leaves its path out")

    def _pending(self) -> list[Step]:
        """Return the steps that are not done."""
        if self._motion is None:
            return []
        state = self._motion.state
        state.raise_early_end()
        if state.phase is Phase.STARVED:
            return []
        return [step for number, step in self._sent if number >= state.step]

    def _end(self, why: str) -> None:
        if self._motion is not None and not self._motion.phase.ended:
            with suppress(WrongStateError):  # it, or another member of its group, has just ended it
                self._motion.cancel(why)
            end = time.monotonic() + STOP_SECONDS
            while not self._motion.phase.ended and time.monotonic() < end:
                self._task.rest(POLL_SECONDS)
        self._forget()

    def _forget(self) -> None:
        self._motion, self._held, self._zone, self._count = None, [], False, 0
        self.concurrent = False
        self._sent.clear()
        self._places.clear()

    def _send(self, steps: Sequence[Step]) -> None:
        if self._batch is not None:
            self._batch += steps
            return
        while self.stopped:
            self._task.pause(POLL_SECONDS)
        place = self._task.place()
        steps = [step if step.place else replace(step, place=place) for step in steps]
        program = self._client.program()
        for step in steps:
            program = step.add(program)
        if self._motion is None:
            self._motion = program.start(open=True)
            notes = self._motion.notes
        else:
            self._motion.state.raise_early_end()
            try:
                notes = self._motion.append(program)
            except WrongStateError:
                self._motion.state.raise_early_end()  # somebody has just ended it
                raise
        self.notes += notes
        end = self._motion.state.planned_duration if any(lead for _, lead, _ in self._calls) else inf
        for number, lead, what in self._calls:
            self._call(self._motion, _Mark(self._count + number, what, end - lead if lead else inf))
        self._sent += enumerate(steps, self._count)
        self._places += ((number, step.place) for number, step in enumerate(steps, self._count))
        self._count += len(steps)

    def _room(self) -> None:
        """Wait until another move may be appended."""

        def moves() -> int:
            return sum(step.moves for _, step in self._sent)

        def fewer(state: MotionState) -> bool:
            while self._sent and self._sent[0][0] < state.step:
                self._sent.popleft()
            return moves() < AHEAD

        if moves() >= AHEAD:
            self._wait(fewer)

    def _wait(self, enough: Callable[[MotionState], bool]) -> None:
        """Wait until a state of the motion is enough, or it has done all its steps."""
        while self._motion is not None or self._waiting:
            if self._motion is not None:
                state = self._motion.state
                state.raise_early_end()
                if state.phase in (Phase.STARVED, Phase.SUCCEEDED):
                    self._sent.clear()
                    return
                if enough(state):
                    return
            self._task.pause(POLL_SECONDS)
