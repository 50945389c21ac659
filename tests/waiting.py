"""Waits of tests for what comes by itself: by looking again and again, with a guard against what never comes."""

from __future__ import annotations

import time
from collections.abc import Callable

PATIENCE_SECONDS = 60.0
"""Time (s) after which a test fails that waits for what should come."""


def until(is_so: Callable[[], object]) -> None:
    """Wait until something is so; fail when it never comes to be."""
    end = time.monotonic() + PATIENCE_SECONDS
    while not is_so():
        assert time.monotonic() < end, "it never came to be so"
        time.sleep(0.005)
