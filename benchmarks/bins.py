"""Bins of twenty parts under physics, by seed: how many are brought unaided, in which time, and what fails.

In a kernel, in steps; times are simulated ones, so that no load changes any of these numbers.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import redirect_stdout

import numpy as np
import virtualrobot
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.bins import run as bins

from benchmarks.rows import Row, row

BINS, PARTS = 10, 20
"""Seeds from 1 on, and parts on the belt for each."""
LEFT = 0.1
"""Part of the parts in a bin that may be left there: 2 of 20."""


def run() -> list[Row]:
    """Measure."""
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        found = list(results(client))
    fallen, brought, tries = (np.array([getattr(one, of) for one in found]) for of in ("fallen", "brought", "tries"))
    seconds = np.concatenate([one.seconds for one in found])
    left = (fallen - brought) / fallen
    worst = int(left.argmax())
    note = f"seed {1 + worst}: {brought[worst]} of the {fallen[worst]} that fell in; each: " + ", ".join(
        f"{one.brought}/{one.fallen}" for one in found
    )
    failed = int(tries.sum()) - len(seconds)
    return [
        row(f"parts left in the worst of {BINS} bins", float(left[worst]), LEFT, "2 of 20", "of 1", 1.0, note),
        row("parts left in all bins", float(left.mean()), LEFT, "2 of 20", "of 1", 1.0, f"{brought.sum()} brought"),
        row(
            "tries that failed", failed / int(tries.sum()), LEFT, "2 of 20", "of 1", None, f"{failed} of {tries.sum()}"
        ),
        row("a cycle, median", float(np.median(seconds)), 10.0, "10 s", "s, simulated", None),
        row("a cycle, the longest", float(seconds.max()), 10.0, "10 s", "s, simulated", None),
    ]


def results(client: virtualrobot.Client) -> Iterator[bins.Result]:
    """Yield how each bin was emptied."""
    for seed in range(1, 1 + BINS):
        with redirect_stdout(io.StringIO()):
            result = bins.main(client, PARTS, seed)
        yield result
