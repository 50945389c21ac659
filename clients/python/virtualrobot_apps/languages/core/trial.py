"""Trials: a program is run in a kernel of its own first, in a copy of the world, and what it meets there is told."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import virtualrobot
from virtualrobot.connection import Client
from virtualrobot.errors import MissingFileError, WrongStateError
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.stepping import Event, collides

from virtualrobot_apps.languages.core.motion import MotionQueue
from virtualrobot_apps.languages.core.source import read_source
from virtualrobot_apps.languages.core.task import Task, TaskStopped

LONGEST = 300.0
"""Time (s of the simulation) after which a trial is given up, unless somebody says another one."""


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


class Trial:
    """Run of one program in a copy of a world, whose time goes on for this program alone.

    Attributes:
        findings: the faults, in the order in which the program met them.
        seconds: time (s of the simulation) that statements took, by `file:line`.
    """

    def __init__(self, client: Client, task: Task, queue: MotionQueue, longest: float = LONGEST) -> None:
        """Watch a task of a stepped kernel, whose collisions are told from now on, and stop nothing."""
        self.findings: list[Finding] = []
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._client, self._task, self._queue, self._longest = client, task, queue, longest
        modes = dict.fromkeys(client.collisions.settings.robots)
        client.collisions.set("monitor", robots=modes, look_ahead=0.0)
        self._events: list[Event] = [collides(robot.name) for robot in client.robots()]
        self._touching = self._pairs()
        self._given_up_at = ""
        self._tick = client.clock.read().tick_length
        task.passing = self._pass

    def run(self, run: Callable[[], None]) -> None:
        """Run the program; an error that ends it is a finding, and so is an end that does not come."""
        try:
            run()
        except WrongStateError as error:
            file, line = error.metadata.get("file", ""), int(error.metadata.get("line", 0))
            self._found(f"{file}:{line}" if line else "", error.message.removeprefix(f"{file}:{line}: "))
        except TaskStopped as error:
            self._found(self._given_up_at, str(error))

    @property
    def duration(self) -> float:
        """Time (s of the simulation) that the program took."""
        return sum(self.seconds.values())

    def _pass(self, seconds: float) -> None:
        """Let time go on, and look what touches."""
        place, left = self._queue.place(), max(1, round(seconds / self._tick))
        while left > 0:
            seen = self._client.clock.step(left, until=[] if self._touching else self._events)
            left -= seen.ticks
            self.seconds[place] += seen.ticks * self._tick
            if self._touching or seen.events:
                self._look()
        if self.duration > self._longest and not self._given_up_at:
            self._given_up_at = place
            self._task.stop(f"the program has not ended after {self._longest:g} s")

    def _look(self) -> None:
        now = self._pairs()
        for pair in sorted(now.keys() - self._touching.keys()):
            self._found(self._queue.place(), now[pair])
        self._touching = now

    def _pairs(self) -> dict[tuple[str, str], str]:
        found = self._client.collisions.check(detail="contacts")
        return {
            (one.first, one.second): f"{one.first!r} touches {one.second!r}"
            + (f" at ({', '.join(f'{value:z.3f}' for value in one.points[0])}) m" if len(one.points) else "")
            for one in found.pairs
        }

    def _found(self, place: str, message: str) -> None:
        file, _, line = place.rpartition(":")
        finding = Finding(file, int(line or 0), column_of(file, int(line or 0)), message)
        if finding not in self.findings:
            self.findings.append(finding)


def column_of(file: str, line: int) -> int:
    """Return the column, from 1, where the statement of a line begins, after the number of a numbered line."""
    try:
        lines = read_source(Path(file)).text.split("\n")
    except MissingFileError:
        return 1
    text = lines[line - 1] if 0 < line <= len(lines) else ""
    found = re.match(r"\s*(?:\d+\s+)?", text)
    return len(found.group()) + 1 if found else 1
