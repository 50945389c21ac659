"""Fixtures for every test: random numbers whose seed comes from the test's own name."""

from __future__ import annotations

import os
import signal
import zlib

import numpy as np
import pytest

# A shell that starts the tests in the background makes them ignore Ctrl-C, and they would hand that on to the processes
# that some tests send Ctrl-C to.
signal.signal(signal.SIGINT, signal.default_int_handler)

GIVEN_SEED = os.environ.get("VIRTUALROBOT_TEST_SEED", "")
"""What repeats a failure, or hunts for one; without it each test has the seed of its name."""


def seed_of(node: pytest.Item | pytest.Collector) -> int:
    """Return the seed of a test, class or file: the same in every run and on every machine."""
    return int(GIVEN_SEED or zlib.crc32(node.nodeid.encode()))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Give the plugins' test suites, and programs that a test starts, the seed of the test's class or file."""
    os.environ["VIRTUALROBOT_TEST_SEED"] = str(seed_of(item.parent or item))


@pytest.fixture
def seed(request: pytest.FixtureRequest) -> int:
    """Return the seed of this test's name; set VIRTUALROBOT_TEST_SEED to have another one."""
    value = seed_of(request.node)
    print(f"seed: {value} (repeat with VIRTUALROBOT_TEST_SEED={value})")
    return value


@pytest.fixture
def rng(seed: int) -> np.random.Generator:
    """Return a generator on the printed seed."""
    return np.random.default_rng(seed)
