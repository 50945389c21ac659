"""Backlog of a reader who wants all: order, what is dropped, and both ends at once."""

from __future__ import annotations

import threading

import numpy as np
from virtualrobot_kernel.api.backlog import Backlog


def test_all_comes_in_order_while_it_is_taken_in_time(rng: np.random.Generator) -> None:
    backlog: Backlog[int] = Backlog(lambda _: 1)
    taken: list[int] = []
    for item in range(5000):
        backlog.put(item)
        if rng.random() < 0.01:
            taken += backlog.take(int(rng.integers(1, 200)))
    while part := backlog.take():
        taken += part
    assert taken == list(range(5000))


def test_of_too_many_the_oldest_are_dropped() -> None:
    backlog: Backlog[int] = Backlog(lambda _: 0, most_items=100)
    for item in range(250):
        backlog.put(item)
    assert len(backlog) == 100
    assert backlog.take(3) == [150, 151, 152]


def test_of_too_large_ones_the_oldest_are_dropped_and_the_newest_never() -> None:
    backlog: Backlog[int] = Backlog(lambda item: item, most_bytes=100)
    for item in (40, 50, 60, 30):
        backlog.put(item)
    assert backlog.take() == [60, 30]
    backlog.put(500)
    assert backlog.take() == [500]
    backlog.put(1)  # what was taken and dropped counts no more
    backlog.put(99)
    assert backlog.take() == [1, 99]


def test_a_reader_beside_a_writer_gets_each_once_and_in_order() -> None:
    backlog: Backlog[int] = Backlog(lambda _: 1, most_items=50)
    done = threading.Event()

    def write() -> None:
        for item in range(20_000):
            backlog.put(item)
        done.set()

    threading.Thread(target=write, daemon=True).start()
    taken: list[int] = []
    while not (done.is_set() and not backlog):
        taken += backlog.take(7)
    assert taken == sorted(set(taken)) and taken[-1] == 19_999
