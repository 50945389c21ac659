"""Threads that give way do so alone: the threads beside them, and the process, stay as they are."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from virtualrobot_kernel.background import ARENAS, NICENESS, give_way, share_memory


def niceness() -> int:
    return os.getpriority(os.PRIO_PROCESS, threading.get_native_id())


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere niceness is a whole process's")
def test_a_thread_gives_way_alone() -> None:
    before = niceness()
    with ThreadPoolExecutor(1, initializer=give_way) as giving, ThreadPoolExecutor(1) as other:
        assert giving.submit(niceness).result() == min(before + NICENESS, 19)
        assert other.submit(niceness).result() == before
    assert niceness() == before == os.getpriority(os.PRIO_PROCESS, 0)


def test_where_it_cannot_be_set_nothing_happens(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "setpriority", refuse)
    give_way()


def test_the_threads_of_a_process_share_few_arenas_where_its_c_library_has_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[tuple[int, int]] = []

    class Glibc:
        def mallopt(self, option: int, value: int) -> None:
            asked.append((option, value))

    monkeypatch.setattr(ctypes, "CDLL", lambda name: Glibc())
    share_memory()
    monkeypatch.setattr(ctypes, "CDLL", lambda name: object())  # another C library
    share_memory()
    assert asked == [(-8, ARENAS)]
