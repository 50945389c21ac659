"""Fixtures for every test: random numbers whose seed comes from the test's own name."""

from __future__ import annotations

import functools
import gc
import os
import re
import signal
import time
import zlib
from pathlib import Path

import numpy as np
import pytest
from _pytest.runner import runtestprotocol

from tests.tiers import Draws

TRIES = 3
"""Number of times that a patient test is tried."""

ROOT = Path(__file__).resolve().parent.parent

IN_REAL_TIME = ("apps", "drawing", "drivers")
"""Rooms whose tests play demos, browsers and controllers in real time, and so are patient."""

AGAIN = "tried again"
"""Name of what a report tells of a test that another try has passed."""

# A shell that starts the tests in the background makes them ignore Ctrl-C, and they would hand that on to the processes
# that some tests send Ctrl-C to.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Each worker collects thousands of tests, which all stay: to look for garbage among them is a sixth of what tests cost.
gc.disable()

pytest_plugins = ["tests.kernels"]

GIVEN_SEED = os.environ.get("VIRTUALROBOT_TEST_SEED", "")
"""Seed that repeats a failure, or hunts for one; without it each test has the seed of its name."""

END = float(os.environ.get("VIRTUALROBOT_TEST_END", "inf"))
"""When (s since 1970) no further test begins, as `.ci/run` says: what a slow machine has no time for is skipped."""

HUNT_SECONDS = "VIRTUALROBOT_HUNT_SECONDS"
"""Name in the environment of the time (s) that a hunt leaves to tests which take as long as they are given."""


def seed_of(node: pytest.Item | pytest.Collector) -> int:
    """Return the seed of a test, class or file: the same in every run and on every machine."""
    return int(GIVEN_SEED or zlib.crc32(node.nodeid.encode()))


LONG = re.compile(r"\bmark\.long\b|\bevery_fifth\b")
"""Pattern that stands somewhere in the source of a file with long tests."""


@functools.cache
def may_be_long(file: Path) -> bool:
    """Return whether a file of tests says that some are long."""
    return LONG.search(file.read_text(encoding="utf-8")) is not None


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out files without long tests where only these are run: more than half of what is to be imported."""
    if config.option.markexpr == "long" and collection_path.match("test_*.py") and not may_be_long(collection_path):
        return True
    return None


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark what `make hunt` has other seeds for, and what is patient."""
    fixtures = getattr(item, "fixturenames", ())
    if "seed" in fixtures or hasattr(getattr(item, "cls", None), "seed"):
        item.add_marker("seeded")
    if ROOT.joinpath("tests") not in item.path.parents:
        return
    if item.get_closest_marker("long") and not may_be_long(item.path):
        raise pytest.UsageError(f"{item.nodeid} is long, but its file has no mark.long of its own to be found by")
    if item.path.relative_to(ROOT).parts[1] in IN_REAL_TIME or "kernel" in fixtures:
        item.add_marker("patient")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what only `make hunt` has the minutes for."""
    if HUNT_SECONDS not in os.environ:
        left_out = [item for item in items if item.get_closest_marker("hunted")]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what there is no time for; give plugins' suites, and programs of a test, the seed of its class or file."""
    if time.time() > END:
        pytest.skip("the machine is slow, and CI's 75 minutes were over before this test: make test-long runs it")
    os.environ["VIRTUALROBOT_TEST_SEED"] = str(seed_of(item.parent or item))


def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Try a patient test up to three times, with new fixtures; the last try tells how those before failed.

    One that another try has passed is named at the end of the run.
    """
    if item.get_closest_marker("patient") is None:
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    told: list[tuple[str, str]] = []
    for number in range(1, TRIES + 1):
        item._initrequest()  # pyright: ignore[reportAttributeAccessIssue]
        reports = runtestprotocol(item, log=False, nextitem=nextitem)
        failed = [report for report in reports if report.failed]
        if not failed:
            reports[-1].user_properties += [(AGAIN, _reason(text)) for _, text in told]
            break
        failed[0].sections[:0] = told
        told.append((f"Try {number} failed", failed[0].longreprtext))
        item.session._setupstate.teardown_exact(None)  # what the file's tests share is made anew, too
    for report in reports:
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def _reason(text: str) -> str:
    """Return the line of a failure that says what was wrong."""
    lines = text.strip().splitlines()
    return next((line[1:].strip() for line in lines if line.startswith("E ")), lines[-1])


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Name the patient tests that another try has passed, with how each try before has failed."""
    reports = [report for reports in terminalreporter.stats.values() for report in reports]
    tries = [(one.nodeid, how) for one in reports for name, how in getattr(one, "user_properties", ()) if name == AGAIN]
    if tries:
        terminalreporter.section("passed by another try")
    for nodeid, how in tries:
        terminalreporter.write_line(f"{nodeid}: {how}")


def pytest_collection_finish() -> None:
    """Look for garbage again, but not among what has been collected."""
    gc.freeze()
    gc.enable()


def pytest_make_parametrize_id(val: object) -> str | None:
    """Name a file by its last two names, so that tests and their seeds are called the same on every machine."""
    path = Path(val) if isinstance(val, str | Path) and os.path.isabs(val) else None
    return "/".join(path.parts[-2:]) if path else None


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


@pytest.fixture
def hunt_seconds() -> float:
    """Return the time (s) that tests marked as hunted have together."""
    return float(os.environ[HUNT_SECONDS])


@pytest.fixture
def draws(request: pytest.FixtureRequest) -> Draws:
    """Return a function that says how many of so many draws are made: a fifth in short tests without a given seed."""
    few = "not long" in request.config.option.markexpr and not GIVEN_SEED
    return lambda count: -(-count // 5) if few else count
