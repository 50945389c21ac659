"""Work that gives way: what it makes may be late, what ticks and calls make may not."""

from __future__ import annotations

import contextlib
import os
import sys
import threading

NICENESS = 5
"""By how much the thread's niceness grows: a third of the share of a core, where others want it. Measured with ten
lidars on two busy cores: calls take a tenth less, and as many readings are made; at 10 a third of them is left out."""


def give_way() -> None:
    """Have the calling thread give way to other threads where cores are scarce; on Linux alone, nothing elsewhere.

    There niceness is a thread's own. It cannot be taken back, and processes that the thread starts later have it too.
    """
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            thread = threading.get_native_id()
            os.setpriority(os.PRIO_PROCESS, thread, os.getpriority(os.PRIO_PROCESS, thread) + NICENESS)


def spare_cores() -> int:
    """Return how many cores this process may use, but one, which is for ticks and calls; at least one."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, count - 1)
