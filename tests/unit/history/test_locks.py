"""Locks of the history: whoever takes several takes them in one order, so that nobody waits for ever."""

from __future__ import annotations

import threading
from collections import defaultdict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Any

import numpy as np
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.history import History

from tests.tiers import Draws
from tests.unit.history.test_history import GUARD, kernel, random_batch, setup

LOCKS = (
    ("journal", "_settling"),
    ("journal", "_changing"),
    ("checkpoints", "_lock"),
    ("upkeep", "_checkpointing"),
    ("upkeep", "_looking_after"),
    ("store", "_writing"),
    ("store", "_reading"),
    ("store", "_tidying"),
)


class Order:
    """Order in which locks are taken: which ones a thread has that takes another."""

    def __init__(self) -> None:
        """Begin with none."""
        self.before: defaultdict[str, set[str]] = defaultdict(set)
        self._held = threading.local()

    @property
    def held(self) -> list[str]:
        """Names of the locks that this thread has."""
        return self._held.__dict__.setdefault("names", [])

    def watch(self, owner: object, name: str) -> None:
        """Look who takes a lock."""
        setattr(owner, name, _Watched(self, name, getattr(owner, name)))


class _Watched:
    def __init__(self, order: Order, name: str, lock: Any) -> None:  # noqa: ANN401 Lock or RLock
        self._order, self._name, self._lock = order, name, lock

    def __enter__(self) -> None:
        held = self._order.held
        if self._name not in held:
            self._order.before[self._name].update(held)
        self._lock.acquire()
        held.append(self._name)

    def __exit__(self, *_: object) -> None:
        self._order.held.remove(self._name)
        self._lock.release()


def test_locks_are_taken_in_one_order(tmp_path: Path, rng: np.random.Generator, draws: Draws) -> None:
    """Also where a return to a checkpoint is settled, whose keeper writes and removes checkpoints."""
    order, rounds = Order(), range(draws(50))
    with kernel(tmp_path) as (world, history):
        for owner, name in LOCKS:
            order.watch(getattr(history, owner), name)
        setup(world)

        def edit() -> None:
            for _ in rounds:
                random_batch(world, rng)

        def keep(name: str) -> None:
            for number in rounds:
                history.settle()
                made = history.checkpoints.create(f"{name} {number}", "ann")
                with suppress(KernelError):  # an arm moves
                    command = history.checkpoints.restoring(made)
                    world.submit([command], "ann").result(GUARD)
                    history.settle()
                    assert history.checkpoints.left_by(command)
                history.checkpoints.remove(made.name)

        def again(work: Callable[[], object]) -> None:
            for _ in rounds:
                work()

        works: list[Callable[[], object]] = [
            *(edit, lambda: keep("noon"), lambda: keep("night")),
            *(lambda: again(history.upkeep.look_after), lambda: again(history.settle)),
            lambda: again(lambda: _read(history)),
        ]
        with ThreadPoolExecutor(len(works)) as pool:
            for done in [pool.submit(work) for work in works]:
                done.result(GUARD)
    assert {"_lock", "_settling", "_writing"} <= order.before.keys()
    assert "_settling" in order.before["_lock"], "a keeper takes it"
    list(TopologicalSorter(order.before).static_order())  # raises CycleError


def _read(history: History) -> None:
    """Read all as clients do."""
    history.settle()
    with suppress(KernelError):
        history.steps.to_undo()
    with suppress(KernelError):
        history.steps.to_redo()
    for checkpoint in history.checkpoints.all:
        assert checkpoint.name
    assert history.store.last_seq > 0
