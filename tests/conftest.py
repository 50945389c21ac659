"""Fixtures for every test: fresh random numbers whose seed a failure prints."""

from __future__ import annotations

import secrets
import signal

import numpy as np
import pytest

# A shell that starts the tests in the background makes them ignore Ctrl-C, and they would hand that on to the processes
# that some tests send Ctrl-C to.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def seed() -> int:
    """Return a seed drawn anew for each test; set VIRTUALROBOT_TEST_SEED to repeat a failure."""
    import os

    value = int(os.environ.get("VIRTUALROBOT_TEST_SEED", secrets.randbits(32)))
    print(f"seed: {value} (repeat with VIRTUALROBOT_TEST_SEED={value})")
    return value


@pytest.fixture
def rng(seed: int) -> np.random.Generator:
    """Return a generator on the printed seed."""
    return np.random.default_rng(seed)
