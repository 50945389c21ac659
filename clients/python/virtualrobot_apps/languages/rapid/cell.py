"""Cells of several tasks: programs that run side by side, share persistents, and meet at points of synchronization."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from virtualrobot_apps.languages.core.diagnostics import did_you_mean
from virtualrobot_apps.languages.core.published import Label, Published
from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.core.together import Group
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.symbols import Datum

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask

LOOK_SECONDS = 0.01
"""Time (s of the wall clock) from one look for the other tasks to the next."""


@dataclass(slots=True)
class Meeting:
    """A point at which tasks meet: those that shall, those that are there, whether all were, and what they become."""

    wanted: frozenset[str]
    there: set[str] = field(default_factory=set)
    over: bool = False
    group: Group | None = None


class Cell:
    """Tasks that run side by side, and what they share.

    Attributes:
        tasks: the tasks, by name in small letters.
        lock: held while one task tests and sets a variable.
    """

    def __init__(self) -> None:
        """Begin without a task; each one enters itself."""
        self.tasks: dict[str, RapidTask] = {}
        self.lock = threading.Lock()
        self._holders: dict[str, list[Any]] = {}
        self._given: set[str] = set()
        self._meetings: dict[str, Meeting] = {}
        self._ended: set[str] = set()

    # Persistents.

    def holder(self, datum: Datum) -> list[Any]:
        """Return the list that holds a datum: one for all tasks of a common one."""
        return self._holders.setdefault(datum.name.lower(), [None]) if datum.common else [None]

    def set_first_values(self, data: Iterable[Datum], set_all: Callable[[], None]) -> None:
        """Have a task set its first values; of a common datum that of the first task that gives one stays."""
        common = [datum for datum in data if datum.common]
        before = {datum.name.lower(): self._holders[datum.name.lower()][0] for datum in common}
        set_all()
        for datum in common:
            name, gives = datum.name.lower(), datum.node is not None and datum.node.value is not None
            if name in self._given or (before[name] is not None and not gives):
                self._holders[name][0] = before[name]
            if gives:
                self._given.add(name)

    # Points of synchronization.

    def meet(self, task: RapidTask, point: str, names: Sequence[str], longest: float | None = None) -> Meeting:
        """Wait until all tasks of these names wait at a point; ERR_WAITSYNCTASK after `longest` (s of the simulation).

        Raises RapidStopped where the tasks can't meet: the list has not this task or has another one than theirs,
        or one of them is not there, or has ended.
        """
        own, wanted = task.name.lower(), frozenset(name.lower() for name in names)
        for name in names:
            if name.lower() not in self.tasks:
                known = [one.name for one in self.tasks.values()]
                raise RapidStopped(
                    f"there is no task {name!r}{did_you_mean(name, known)}; there are: {', '.join(known)}"
                )
        if own not in wanted:
            raise RapidStopped(f"the task {task.name} waits for others, and is not in its own list: {', '.join(names)}")
        with self.lock:
            meeting = self._meetings.setdefault(point, Meeting(wanted))
            if meeting.wanted != wanted:
                others = ", ".join(sorted(meeting.wanted))
                raise RapidStopped(f"tasks that meet at {point} have the same list, and others have {others}")
            meeting.there.add(own)
            if meeting.there == wanted:
                meeting.over = True
                del self._meetings[point]
        end = None if longest is None else task.time() + longest
        try:
            while not meeting.over:
                gone = (meeting.wanted - meeting.there) & self._ended
                if gone and not meeting.over:
                    told = ", ".join(self.tasks[name].name for name in sorted(gone))
                    raise RapidStopped(f"at {point} the task {told} is waited for, and has ended")
                if end is not None and task.time() >= end:
                    lacking = ", ".join(self.tasks[name].name for name in sorted(wanted - meeting.there))
                    raise RapidFault("ERR_WAITSYNCTASK", f"{lacking} did not come to {point} within {longest:g} s")
                task.pause(LOOK_SECONDS)
        except BaseException:
            with self.lock:
                if not meeting.over:
                    meeting.there.discard(own)
                    if not meeting.there:
                        self._meetings.pop(point, None)
            raise
        return meeting

    def synchronize(self, task: RapidTask, point: str, names: Sequence[str], longest: float | None) -> Group:
        """Return the group whose robots move together, after all its tasks have met at a point."""
        meeting = self.meet(task, point, names, longest)
        with self.lock:
            if meeting.group is None:
                meeting.group = Group(task.world.client, meeting.wanted, lambda: self._ended)
            return meeting.group

    # The run.

    def run(
        self,
        routine: str = "main",
        static: Sequence[RapidTask] = (),
        *,
        forever: bool = False,
        idle: Sequence[RapidTask] = (),
    ) -> None:
        """Run all tasks side by side until they have ended; `static` ones make round after round, and are stopped then.

        All do so where they shall run `forever`, and `idle` ones don't run. The error of one stops all others, and is
        raised when all have ended; so does Ctrl-C.
        """
        self._ended = {task.name.lower() for task in idle}
        for task in self.tasks.values():
            if not task.prepared:
                task.prepare_alone()
        errors: list[tuple[RapidTask, BaseException]] = []
        told: list[Published] = []

        def run(task: RapidTask) -> None:
            seen = _published(task)
            told.extend(seen)
            failed: BaseException | None = None
            try:
                task.run(routine, forever=forever or task in static)
            except BaseException as error:
                failed = error
                errors.append((task, error))
            finally:
                self._ended.add(task.name.lower())
                for one in seen:
                    one.close(failed)

        threads = {
            task.name: threading.Thread(target=run, args=(task,), name=f"rapid {task.name}", daemon=True)
            for task in self.tasks.values()
            if task not in idle
        }
        for thread in threads.values():
            thread.start()
        why, stopped = "", False
        try:
            steady = {task.name for task in static}
            while not stopped and any(one.is_alive() for name, one in threads.items() if name not in steady):
                stopped = bool(errors)
                time.sleep(LOOK_SECONDS)
            why = f"the task {errors[0][0].name} ended by an error" if errors else "the other tasks have ended"
        except KeyboardInterrupt:
            why = "stopped"
            raise
        finally:
            for task in self.tasks.values():
                undoes = task.undoing and why != "stopped"  # it has ended by itself, and makes its last moves
                if task.name in threads and threads[task.name].is_alive() and not undoes:
                    task.stop(why)
            for thread in threads.values():
                thread.join()
            for one in told:
                one.join()
        for task, error in errors:
            if task not in static or not isinstance(error, TaskStopped):
                raise error


def _published(task: RapidTask) -> list[Published]:
    """Return what tells everybody of a task: nothing where it has no kernel, or time goes on for it alone."""
    world = task.own_world
    if world is None or task.passing is not None:
        return []
    robot = task.world.robot.name if task.has_robot else ""
    return [Published(world.client, task, task.pendant, Label(task.name, "RAPID", task.program.files, robot))]
