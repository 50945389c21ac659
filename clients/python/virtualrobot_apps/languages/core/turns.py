"""Turns: tasks of one program that run one at a time while time stands still, so that equal runs are the same."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from virtualrobot_apps.languages.core.task import Task, TaskStopped


class Turns:
    """Tasks that take turns: one runs until it rests; when all do, time goes on to the tick at which the first is due.

    Of tasks that are due at the same tick the first one of `tasks` runs first.
    """

    def __init__(self, tasks: Sequence[Task], static: Sequence[Task], step: Callable[[int], int]) -> None:
        """Begin with tasks that are all still to come; `step` lets so many ticks pass at most, and tells how many.

        `static` ones are stopped when the others have ended, and all are when one has ended by an error.
        """
        self._tasks, self._static, self._step = list(tasks), list(static), step
        self._changed = threading.Condition()
        self._due: dict[Task, int] = {}
        self._now, self._begun = 0, False
        self._at: Task | None = None
        self._error: BaseException | None = None

    @property
    def working(self) -> list[Task]:
        """Tasks that have not ended, in their order."""
        return [one for one in self._tasks if one in self._due]

    @contextmanager
    def at_work(self, task: Task) -> Iterator[None]:
        """Have a task run, in its turn, for the length of a block; the first turn comes when all tasks are there."""
        with self._changed:
            self._due[task] = self._now
            if not self._begun and len(self._due) == len(self._tasks):
                self._begun = True
                self._choose()
            self._wait(task)
        try:
            yield
        except TaskStopped:
            raise
        except BaseException:
            for one in self._tasks:
                if one is not task:
                    one.stop("another task ended by an error")
            raise
        finally:
            with self._changed:
                del self._due[task]
                if all(one in self._static for one in self._due):
                    for one in self._due:
                        one.stop("the other tasks have ended")
                self._choose()

    def rest(self, task: Task, ticks: int) -> None:
        """Let the others run, and time go on, until so many ticks have passed."""
        with self._changed:
            self._due[task] = self._now + ticks
            self._choose()
            self._wait(task)

    def _choose(self) -> None:
        """Give the turn to the task that is due first, and let time go on until then."""
        if self._due:
            first = min(self.working, key=self._due.__getitem__)
            try:
                while self._now < self._due[first]:
                    self._now += self._step(self._due[first] - self._now)
            except BaseException as error:
                self._error = error
                raise
            finally:
                self._at = first
                self._changed.notify_all()

    def _wait(self, task: Task) -> None:
        while self._at is not task:
            if self._error is not None:
                raise self._error
            self._changed.wait()
