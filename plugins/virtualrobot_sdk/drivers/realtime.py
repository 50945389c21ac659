"""Punctuality of a driver's process as far as the system gives it: scheduling class, garbage, and a clock."""

from __future__ import annotations

import gc
import os
import sys
import time

PRIORITY = 20
"""Real-time priority of a driver's loop; above it are those of the system's own threads."""


def calm() -> str:
    """Make the calling thread as punctual as it may be, and return what was had: `fifo`, `nice`, `high` or `ordinary`.

    Linux: SCHED_FIFO where permitted (`ulimit -r`, or CAP_SYS_NICE), else the least niceness that is. Windows: the
    process class HIGH, and timers of a millisecond. macOS gives real-time classes to signed programs alone. Whatever is
    loaded already is no garbage any more; none is looked for while the loop runs.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    if sys.platform == "win32":
        import ctypes

        ctypes.windll.winmm.timeBeginPeriod(1)
        ctypes.windll.kernel32.SetPriorityClass(ctypes.windll.kernel32.GetCurrentProcess(), 0x80)
        return "high"
    if hasattr(os, "sched_setscheduler"):
        try:
            # What the driver starts itself gets the ordinary class again.
            policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
            os.sched_setscheduler(0, policy, os.sched_param(PRIORITY))
            return "fifo"
        except OSError:
            pass  # not permitted
    try:
        os.setpriority(os.PRIO_PROCESS, 0, -10)
        return "nice"
    except OSError:
        return "ordinary"


def sleep_until(ns: int) -> None:
    """Sleep until a time (ns, CLOCK_MONOTONIC); returns at once where it is over."""
    left = ns - time.monotonic_ns()
    if left > 0:
        time.sleep(left * 1e-9)
