"""Turns of tasks: one runs at a time, time goes on when all rest, and equal runs are the same."""

from __future__ import annotations

import threading

import pytest
from virtualrobot_apps.languages.core.task import Task, TaskStopped
from virtualrobot_apps.languages.core.turns import Turns


class Counted:
    """Tasks of different rests, what they do, and the ticks that pass meanwhile."""

    def __init__(self, rests: list[int], static: int = 0) -> None:
        """Begin at tick 0; the last tasks are static."""
        self.tasks, self.rests = [Task() for _ in rests], rests
        self.static = self.tasks[len(rests) - static :]
        self.turns = Turns(self.tasks, self.static, self._step)
        self.now = 0
        self.log: list[tuple[int, int]] = []
        self.ends: list[str] = []

    def _step(self, ticks: int) -> int:
        self.now += min(ticks, 3)  # an event may end a step early
        return min(ticks, 3)

    def _work(self, number: int, rounds: int, fails: bool) -> None:
        task = self.tasks[number]
        try:
            with self.turns.at_work(task):
                done = 0
                while done < rounds or task in self.static:
                    self.log.append((self.now, number))
                    self.turns.rest(task, self.rests[number])
                    if task.flags:
                        task.poll()
                    done += 1
                if fails:
                    raise ValueError(number)
        except TaskStopped as error:
            self.ends.append(str(error))
        except ValueError:
            self.ends.append("failed")

    def run(self, rounds: list[int], fails: int = -1) -> None:
        """Run all in threads, which begin in the other order."""
        threads = [
            threading.Thread(target=self._work, args=(number, rounds[number], number == fails))
            for number in reversed(range(len(self.tasks)))
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60.0)
            assert not thread.is_alive()


@pytest.mark.parametrize("_", range(3))
def test_tasks_run_in_the_order_in_which_they_are_due(_: int) -> None:
    counted = Counted([2, 5, 5])
    counted.run([4, 2, 2])
    assert counted.log == [(0, 0), (0, 1), (0, 2), (2, 0), (4, 0), (5, 1), (5, 2), (6, 0)]
    assert counted.now == 10


def test_static_tasks_are_stopped_at_the_tick_at_which_the_others_have_ended() -> None:
    counted = Counted([5, 2], static=1)
    counted.run([2, 0])
    assert counted.ends == ["the other tasks have ended"]
    assert counted.now == 10
    assert counted.log[-1] == (8, 1)


def test_an_error_of_one_stops_the_others() -> None:
    counted = Counted([5, 2])
    counted.run([1, 100], fails=0)
    assert counted.ends == ["failed", "another task ended by an error"]
    assert counted.now == 6
