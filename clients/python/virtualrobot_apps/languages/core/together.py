"""Moves of several programs that start and end together: each step of the kernel's program has one move of each."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from typing import NoReturn

from virtualrobot.connection import Client
from virtualrobot.errors import VirtualRobotError, WrongStateError
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.moves import Move
from virtualrobot.motions.program import Program
from virtualrobot.motions.state import Search

from virtualrobot_apps.languages.core.motion import POLL_SECONDS, MotionQueue, SignalValue, Step
from virtualrobot_apps.languages.core.task import Task
from virtualrobot_apps.languages.core.zones import Zone, size_of, zone_of


class Round:
    """A step on its way: what each member gives to it, and what has become of it."""

    def __init__(self) -> None:
        """Begin empty."""
        self.steps: list[Step] = []
        self.moves: dict[str, Move | None] = {}
        self.number: int | None = None
        self.zone: Zone | None = None
        self.places = range(0)
        self.over = False
        self.error: Exception | None = None


class Group:
    """Programs whose moves go together, by name, and the motion that they share.

    Attributes:
        names: the members' names.
        motion: the motion; None before the first step.
    """

    def __init__(self, client: Client, names: frozenset[str], gone: Callable[[], set[str]]) -> None:
        """Begin without a step; `gone` tells the names of those that have ended."""
        self.names = names
        self._client, self._gone = client, gone
        self._lock = threading.Lock()
        self._round, self._count = Round(), 0
        self.motion: Motion | None = None
        self._ends = False

    def give(
        self,
        name: str,
        task: Task,
        steps: list[Step],
        move: Move | Exception,
        zone: Zone = 0.0,
        number: int | None = None,
    ) -> range:
        """Give a member's next move, with steps before it; return the numbers of all that was appended.

        It waits until all have given theirs. `number` is the step's own, which all must give alike; of zones (m) the
        smallest counts. The planner's error, or one that is given instead of a move, is raised in each member.
        """
        with self._lock:
            round = self._round
            if round.moves and round.number != number:
                raise WrongStateError(
                    f"moves that go together have one number (ID), and this one has {_told(number)}, not "
                    f"{_told(round.number)} as that of {', '.join(sorted(round.moves))}"
                )
            round.number = number
            round.steps += steps
            round.zone = zone if round.zone is None else min(zone, round.zone, key=size_of)
            round.moves[name] = None if isinstance(move, Exception) else move
            if isinstance(move, Exception):
                round.error = move
            if round.moves.keys() == self.names:
                self._round = Round()
                try:
                    round.places = self._append(round)
                except VirtualRobotError as error:
                    round.error = error
                round.over = True
        while not round.over:
            gone = (self.names - round.moves.keys()) & self._gone()
            if gone:
                raise WrongStateError(f"{', '.join(sorted(gone))} has ended, and this move would go together with its")
            task.pause(POLL_SECONDS)
        if round.error is not None:
            raise round.error
        return round.places

    def _append(self, round: Round) -> range:
        moves = [move for _, move in sorted(round.moves.items()) if move is not None]
        if round.error is not None:
            return range(0)
        program = self._client.program()
        for step in round.steps:
            program = step.add(program)
        program = program.move(*moves, **zone_of(round.zone or 0.0))
        if self.motion is None:
            self.motion, self._count = program.start(open=True), 0
        else:
            self.motion.state.raise_early_end()
            self.motion.append(program)
        begin, self._count = self._count, self._count + len(program)
        return range(begin, self._count)

    def end(self, task: Task) -> None:
        """End the motion, when the robots stand; each member calls it."""
        with self._lock:
            motion = self.motion
            if motion is not None and not self._ends and not motion.state.phase.ended:
                motion.append(last=True)
                self._ends = True
        while motion is not None and not motion.state.phase.ended:
            task.pause(POLL_SECONDS)
        with self._lock:
            if self.motion is motion:
                self.motion, self._ends = None, False


def _told(number: int | None) -> str:
    return "none" if number is None else str(number)


class GroupQueue(MotionQueue):
    """Queue of a program whose moves go together with those of others.

    Attributes:
        group: all of them.
        number: the number of the next move.
        count: the number of moves, and of errors instead, that were given.
    """

    def __init__(self, client: Client, task: Task, group: Group, name: str) -> None:
        """Become a member, by a name."""
        super().__init__(client, task)
        self.group = group
        self.number: int | None = None
        self._name = name
        self._giving, self.count = False, 0

    def move(
        self,
        move: Move,
        zone: Zone = 0.0,
        *,
        concurrent: bool = False,
        again: Callable[[], Step] | None = None,
        beside: Sequence[Move] = (),
    ) -> None:
        """Append a move together with those of the others; `again` doesn't count."""
        if beside:
            _refuse("a move of external axes")
        if concurrent:
            raise WrongStateError("moves that go together can't let the program go on at once (Conc)")
        if self._giving:
            raise WrongStateError("a trap can't move while its program waits to move together with others")
        self._room()
        places = self._give(move, zone)
        self._motion, self._held = self.group.motion, []
        self._sent += [(number, Step(_nothing, number == places[-1])) for number in places]
        place = self._task.place()
        self._places += ((number, place) for number in places)
        self._zone = size_of(zone) > 0.0

    def _give(self, move: Move | Exception, zone: Zone = 0.0) -> range:
        self._giving, self.count = True, self.count + 1
        try:
            return self.group.give(self._name, self._task, self._held, move, zone, self.number)
        finally:
            self._giving = False

    def fail(self, error: Exception) -> None:
        """Give an error instead of a move: it is raised in all others."""
        with suppress(type(error)):
            self._give(error)

    def set(self, signal: str, value: SignalValue, lead: float = 0.0) -> None:
        """Set a signal in the zone after the last move, or else when that is done; a lead doesn't count then."""
        if self._zone and not self.free:
            self._held.append(Step(lambda program: program.set(signal, value)))
        else:
            self.settle()
            self._client.signals[signal] = value

    def flush(self) -> None:
        """Set signals that wait for the next move when the robot stands."""
        if self._held:
            held, self._held, self._zone = self._held, [], False
            self._wait(lambda _: False)
            program = self._client.program()
            for step in held:
                program = step.add(program)
            program.start(wait=True)

    def add(self, add: Callable[[Program], Program]) -> None:
        """Refuse."""
        _refuse("such a step")

    def dwell(self, seconds: float) -> None:
        """Wait for so many seconds of simulation time when all before it is done; the others go on."""
        self.finish()
        end = self._client.clock.simulation_time + seconds
        while self._client.clock.simulation_time < end:
            self._task.pause(POLL_SECONDS)

    def wait_signal(self, signal: str, value: SignalValue, timeout: float | None, comparison: str = "==") -> None:
        """Wait until a signal compares so with a value when all before it is done, as `MotionQueue.wait_signal`."""
        self.finish()
        self.look(signal, value, timeout, comparison)

    def close(self) -> None:
        """Wait for all, and end the motion that all share."""
        self.finish()
        self.group.end(self._task)
        self._forget()

    def search(self, program: Program) -> Search | None:
        """Refuse."""
        _refuse("a search")

    def store(self) -> None:
        """Refuse."""
        _refuse("a path that is put aside")

    def together(self) -> AbstractContextManager[None]:
        """Refuse."""
        _refuse("a move with triggers")

    def forget_path(self) -> None:
        """Refuse."""
        _refuse("a path that is left out")


def _nothing(program: Program) -> Program:
    return program


def _refuse(what: str) -> NoReturn:
    raise WrongStateError(f"{what} can't be used yet while moves go together with others'")
