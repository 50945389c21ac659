"""Slots: as many as there are, given back once, and nobody waits for ever."""

from __future__ import annotations

import threading

from virtualrobot_kernel.sensing.cpu_slots import CpuSlots


def test_no_more_at_once_than_there_are_turns() -> None:
    turns, lock = CpuSlots(2), threading.Lock()
    busy, most = 0, 0

    def work() -> None:
        nonlocal busy, most
        for _ in range(200):
            give_back = turns.take(30.0)
            with lock:
                busy += 1
                most = max(most, busy)
            with lock:
                busy -= 1
            give_back()

    threads = [threading.Thread(target=work) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30.0)
    assert most <= 2
    assert busy == 0


def test_a_turn_that_is_never_given_back_holds_up_nobody_for_ever() -> None:
    turns = CpuSlots(1)
    held = turns.take()
    late = turns.take(0.01)
    late()  # it had none
    late = turns.take(0.01)
    held()
    held()  # twice is once
    first, second = turns.take(30.0), turns.take(0.0)
    second()
    assert turns._free.qsize() == 0
    first()
    assert turns._free.qsize() == 1
