"""A hundred clients for as long as a hunt has: nothing grows, and nothing of theirs is left."""

from __future__ import annotations

import sys

import pytest

from benchmarks.soak import soaked

POOLS = 12
"""Threads that pools may make late: the workers' eight, and those that plan."""


@pytest.mark.hunted
@pytest.mark.timeout(0)
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere descriptors are counted otherwise")
def test_a_hundred_clients_leave_nothing_behind(hunt_seconds: float) -> None:
    soak = soaked(hunt_seconds / 60.0)
    print(f"{soak.calls} rounds of calls, real-time factor {soak.factor:.4f}")
    assert soak.after.threads <= soak.before.threads + POOLS, "pools make threads as they need them, up to a number"
    assert soak.after.descriptors <= soak.before.descriptors
    assert soak.megabytes(3) <= 1.05 * soak.megabytes(1), [round(one.megabytes) for one in soak.during]
