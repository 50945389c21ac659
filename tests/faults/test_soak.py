"""A hundred clients for as long as a hunt has: nothing grows, and nothing of theirs is left."""

from __future__ import annotations

import sys

import pytest
from virtualrobot_kernel.api.keyed_limiter import THREADS as SOLVERS
from virtualrobot_kernel.kernel import WORKERS

from benchmarks.soak import soaked

POOLS = WORKERS + SOLVERS
"""Threads that pools may make late; how many of them a machine makes hangs on how busy it is. A hundred clients come
again 12,000 times in an hour: a thread that one of them leaves behind would be many more."""


@pytest.mark.hunted
@pytest.mark.timeout(0)
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere descriptors are counted otherwise")
def test_a_hundred_clients_leave_nothing_behind(hunt_seconds: float) -> None:
    soak = soaked(hunt_seconds / 60.0)
    print(f"{soak.calls} rounds of calls, real-time factor {soak.factor:.4f}")
    assert soak.after.threads <= soak.before.threads + POOLS, "pools make threads as they need them, up to a number"
    assert soak.after.descriptors <= soak.before.descriptors
    assert soak.megabytes(3) <= 1.05 * soak.megabytes(1), [round(one.megabytes) for one in soak.during]
