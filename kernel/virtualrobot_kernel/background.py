"""Manners of the kernel's process: work that gives way to ticks and calls, and threads that share their memory."""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
import threading
import time

NICENESS = 5
"""By how much the thread's niceness grows: a third of the share of a core, where others want it. Measured with ten
lidars on two busy cores: calls take a tenth less, and as many readings are made; at 10 a third of them is left out."""

ARENAS = 2
"""Number of arenas of the C library. A kernel in which two arms were loaded, moved, checked and cleared 300 times took
404 to 433 MB with two, the growth being the journal's, and up and down 467 to 582 MB without a limit, on two cores."""

_ARENA_MAX = -8
"""M_ARENA_MAX of glibc's malloc.h."""


def give_way() -> None:
    """Have the calling thread give way to other threads where cores are scarce; on Linux alone, nothing elsewhere.

    There niceness is a thread's own. It cannot be taken back, and processes that the thread starts later have it too.
    """
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            thread = threading.get_native_id()
            os.setpriority(os.PRIO_PROCESS, thread, os.getpriority(os.PRIO_PROCESS, thread) + NICENESS)


def let_others_go_on() -> None:
    """Have threads that wait for the interpreter take it, which they do by themselves after half a millisecond only."""
    time.sleep(1e-4)


def share_memory() -> None:
    """Have all threads, from now on, take memory from two arenas of the C library; where it is not glibc, do nothing.

    By default there are eight for each core, and what one thread frees no other one takes: threads that take turns in
    loading would each have memory of their own for it.
    """
    with contextlib.suppress(OSError, AttributeError, TypeError):  # TypeError: on Windows there is no None to load
        ctypes.CDLL(None).mallopt(_ARENA_MAX, ARENAS)


def spare_cores() -> int:
    """Return how many cores this process may use, but one, which is for ticks and calls; at least one."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, count - 1)
