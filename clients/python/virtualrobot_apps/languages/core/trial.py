"""Trials: a program is run in a kernel of its own first, in a copy of the world, and what it meets there is told."""

from __future__ import annotations

import re
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Protocol

import virtualrobot
from virtualrobot.clock import Observation
from virtualrobot.connection import Client
from virtualrobot.errors import MissingFileError, WrongStateError
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.stepping import Event, collides

from virtualrobot_apps.languages.core.motion import MotionQueue
from virtualrobot_apps.languages.core.source import read_source
from virtualrobot_apps.languages.core.task import Task, TaskStopped
from virtualrobot_apps.languages.core.turns import Turns

STILL_SECONDS = 60.0
"""Time (s of the wall clock) after which a program is given up that lets no time pass: it computes for ever."""


@dataclass(frozen=True, slots=True)
class Finding:
    """Fault that a trial has found: file, line and column (from 1) of the statement that was at work, and words."""

    file: str
    line: int
    column: int
    message: str

    def __str__(self) -> str:
        """Return it as compilers do: `file:line:column: message`."""
        return f"{self.file}:{self.line}:{self.column}: {self.message}" if self.file else self.message


@contextmanager
def copied_world(client: Client) -> Iterator[Client]:
    """Give a client of a kernel of its own for the length of a block: its world is a copy, its time goes on by steps.

    The copy has no drivers: no real robot moves by it.
    """
    with TemporaryDirectory() as folder:
        file = Path(folder) / "world.yaml"
        client.scene.save(file, bundle=True)
        with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as own:
            own.scene.load_scene(file)
            yield own


class Moving(Protocol):
    """World of a program in any language: it has the queue of the program's motions, which may become another one."""

    @property
    def queue(self) -> MotionQueue:
        """The motions of the program."""
        ...


@dataclass(slots=True, eq=False)
class Member:
    """A task of a trial.

    Attributes:
        task: the task, and `world` its world.
        waits: the place of the statement in which it lets time pass.
        moving: the place of the step that its robot makes now; empty where it stands.
        moved: whether its robot made a step while time passed.
        place: the place of that step, or else where it waited.
    """

    task: Task
    world: Moving
    waits: str = ""
    moving: str = ""
    moved: bool = False
    place: str = ""

    def pass_by(self, seen: Observation) -> None:
        """Take notice of the world, after a piece of time."""
        moving = self.world.queue.place(seen.motions)
        # A step that has just ended took the last ticks; after the program's last statement there is no place.
        self.place = moving or self.moving or self.waits or self.place
        self.moved, self.moving = bool(moving or self.moving), moving
        self.world.queue.passed(seen.motions)
        self.task.passed(seen)


class Trial:
    """Run of one program in a copy of a world, whose time goes on for this program alone.

    Attributes:
        findings: the faults, in the order in which the program met them.
        seconds: time (s of the simulation) that statements took, by `file:line`; tasks side by side take theirs each.
        duration: time (s of the simulation) that the program took.
    """

    def __init__(
        self,
        client: Client,
        tasks: Mapping[Task, Moving],
        longest: float,
        still: float = STILL_SECONDS,
        *,
        static: Sequence[Task] = (),
    ) -> None:
        """Watch the tasks, with their worlds, of a stepped kernel, whose collisions are told from now on.

        The program is given up after `longest` (s of the simulation), and where it lets no time pass for `still` (s of
        the wall clock). `static` tasks are those that are stopped when the others have ended.
        """
        self.findings: list[Finding] = []
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.duration = 0.0
        self._client, self._longest, self._still = client, longest, still
        self._members = {task: Member(task, world) for task, world in tasks.items()}
        modes = dict.fromkeys(client.collisions.settings.robots)
        client.collisions.set("monitor", robots=modes, look_ahead=0.0)
        self._events: list[Event] = [collides(robot.name) for robot in client.robots()]
        self._touching = self._pairs()
        self._told: set[tuple[str, object]] = set()
        self._end = longest
        self._given_up_at = ""
        self._tick = client.clock.read().tick_length
        self._passed_at = 0.0
        self._turns = Turns(list(tasks), static, self._step)
        for task in tasks:
            task.at_work = partial(self._turns.at_work, task)
            task.passing = partial(self._pass, task)

    def run(self, run: Callable[[], None]) -> None:
        """Run the program; an error that ends it is a finding, and so is an end that does not come."""
        over = threading.Event()
        self._passed_at = time.monotonic()
        threading.Thread(target=self._watch, args=(over,), name="trial", daemon=True).start()
        try:
            run()
        except WrongStateError as error:
            file, line = error.metadata.get("file", ""), int(error.metadata.get("line", 0))
            message = error.message.removeprefix(f"{file}:{line}: ")
            self._found(f"{file}:{line}" if line else "", message, message)
        except TaskStopped as error:
            stopped = (task.stopped_at for task in self._members)
            self._found(self._given_up_at or next(filter(None, stopped), ""), str(error), str(error))
        finally:
            over.set()

    def _pass(self, task: Task, seconds: float) -> None:
        """Let time go on for a task."""
        self._members[task].waits = task.place()
        self._turns.rest(task, max(1, round(seconds / self._tick)))

    def _step(self, ticks: int) -> int:
        """Let time go on by so many ticks at most, look what touches, and return how many it were."""
        seen = self._client.clock.step(ticks, until=[] if self._touching else self._events)
        seconds = seen.ticks * self._tick
        self.duration += seconds
        for one in self._members.values():
            one.pass_by(seen)
            if one.place:
                self.seconds[one.place] += seconds
        if self._touching or seen.events:
            self._look()
        if self.duration > self._end:
            self._end += self._longest  # what the program does at its end may last for ever, too
            self._given_up_at = self._given_up_at or self._places()[0]
            self._stop(f"the program has not ended after {self._longest:g} s")
        self._passed_at = time.monotonic()
        return seen.ticks

    def _places(self) -> list[str]:
        """Return the places of tasks that have not ended."""
        return [self._members[task].place for task in self._turns.working]

    def _stop(self, why: str) -> None:
        for task in self._members:
            task.stop(why)

    def _watch(self, over: threading.Event) -> None:
        """Stop a program that computes for ever."""
        while not over.wait(min(self._still, 1.0)):
            if time.monotonic() - self._passed_at > self._still:
                self._passed_at = time.monotonic()
                self._stop(f"the program has let no time pass for {self._still:g} s of the wall clock")

    def _look(self) -> None:
        now = self._pairs()
        moved = [one.place for one in self._members.values() if one.moved]
        for pair in sorted(now.keys() - self._touching.keys()):
            for place in moved or self._places()[:1]:
                self._found(place, pair, now[pair])
        self._touching = now

    def _pairs(self) -> dict[tuple[str, str], str]:
        found = self._client.collisions.check(detail="contacts")
        return {
            (one.first, one.second): f"{one.first!r} touches {one.second!r}"
            + (f" at ({', '.join(f'{value:z.3f}' for value in one.points[0])}) m" if len(one.points) else "")
            for one in found.pairs
        }

    def _found(self, place: str, what: object, message: str) -> None:
        """Keep a fault, of one place and one kind (`what`) the first alone."""
        if (place, what) not in self._told:
            self._told.add((place, what))
            file, _, line = place.rpartition(":")
            self.findings.append(Finding(file, int(line or 0), column_of(file, int(line or 0)), message))


def column_of(file: str, line: int) -> int:
    """Return the column, from 1, where the statement of a line begins, after the number of a numbered line."""
    try:
        lines = read_source(Path(file)).text.split("\n")
    except MissingFileError:
        return 1
    text = lines[line - 1] if 0 < line <= len(lines) else ""
    found = re.match(r"\s*(?:\d+\s+)?", text)
    return len(found.group()) + 1 if found else 1
