"""Faults that are planted: kernels killed under load, disks without power, flipped bits, bytes and clients at random.

What is lost or broken is told beside how often it was tried; each number is of a hunted test, with a fresh seed.
`python -m benchmarks.faults 60` takes about an hour.
"""

from __future__ import annotations

import os
import re
import secrets
import subprocess
import sys
from collections.abc import Callable
from typing import NamedTuple

from benchmarks.rows import Row, row

MINUTES = 3.0
"""Length that `make bench` has time for."""


class Hunt(NamedTuple):
    """Hunt for a kind of fault: the test, its share of the time, and how many tries its output tells."""

    name: str
    test: str
    share: float
    tries: Callable[[str], int]
    what: str


def _sum(pattern: str) -> Callable[[str], int]:
    return lambda said: sum(map(int, re.findall(pattern, said)))


HUNTS = (
    Hunt(
        "answers lost by kernels killed under load",
        "tests/api/test_data_folder.py::test_kills_under_load_lose_nothing",
        0.3,
        _sum(r"(\d+) answers"),
        "answers",
    ),
    Hunt(
        "worlds lost by kernels killed between calls",
        "tests/faults/test_kills.py::test_a_kernel_that_is_killed_has_lost_nothing",
        0.3,
        _sum(r"(\d+) worlds"),
        "worlds of 25 calls, each verified",
    ),
    Hunt(
        "first differences that a verification misses",
        "tests/unit/history/test_replay.py::test_a_thousand_differences_are_named",
        0.0,
        lambda _: 1000,
        "bits of joints, flipped",
    ),
    Hunt(
        "damaged journals repaired to what never was",
        "tests/unit/history/test_repair.py::test_whatever_is_damaged_what_is_kept_is_what_was",
        0.0,
        lambda _: 40,
        "journals with pages and bits overwritten",
    ),
    Hunt(
        "ghosts, gaps and losses after power is lost",
        "tests/unit/history/test_power_loss.py",
        0.0,
        lambda _: 2 * 500,
        "disks as a crash may leave them",
    ),
    Hunt(
        "inputs that break a reader or the contract",
        "tests/fuzz/test_inputs.py::test_no_bytes_break_anything",
        0.4,
        _sum(r"Done (\d+) runs"),
        "inputs, led by coverage",
    ),
    Hunt(
        "worlds that random clients broke",
        "tests/faults/test_world.py",
        0.0,
        lambda _: 30,
        "worlds of 30 calls, each replayed to the same bits",
    ),
)


def run(minutes: float = MINUTES) -> list[Row]:
    """Return a row for each kind of fault: how many were found, and how often it was tried."""
    return [_hunted(hunt, 60.0 * minutes * hunt.share) for hunt in HUNTS]


def _hunted(hunt: Hunt, seconds: float) -> Row:
    seed = str(secrets.randbits(32))
    environment = {**os.environ, "VIRTUALROBOT_TEST_SEED": seed, "VIRTUALROBOT_HUNT_SECONDS": str(seconds)}
    command = [sys.executable, "-m", "pytest", "-q", "-s", "-m", "", "-p", "no:cacheprovider", hunt.test]
    ended = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)
    failed = int(counted[1]) if (counted := re.search(r"(\d+) failed", ended.stdout)) else int(ended.returncode != 0)
    if failed:
        print(ended.stdout[-6000:], file=sys.stderr)
    kills = re.search(r"\d+ kills", ended.stdout)
    note = kills[0] if kills else ""
    return row(hunt.name, failed, hunt.tries(ended.stdout), hunt.what, "", 0.0, note)


if __name__ == "__main__":
    from benchmarks.run import table

    print(table(run(float(sys.argv[1]) if len(sys.argv) > 1 else MINUTES)))
