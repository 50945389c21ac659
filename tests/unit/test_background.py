"""Threads that give way do so alone: the threads beside them, and the process, stay as they are."""

from __future__ import annotations

import os
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from virtualrobot_kernel.background import NICENESS, give_way


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
