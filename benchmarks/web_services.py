"""Robot Web Services of the emulated controller of ABB: calls over one connection, as abb-robot-client makes them."""

from __future__ import annotations

import statistics
import sys
import time

import requests
import virtualrobot
from requests.auth import HTTPDigestAuth

from benchmarks.processes import kernel, process
from benchmarks.rows import Row, row

ROUNDS = 300
BUDGET_MILLISECONDS = 5.0
CALLS = {
    "signals": "/rw/iosystem/signals",
    "state of the motors": "/rw/panel/ctrlstate",
    "joints": "/rw/motionsystem/mechunits/ROB_1/jointtarget",
    "place and configuration": "/rw/motionsystem/mechunits/ROB_1/robtarget",
}


def times(url: str) -> list[float]:
    """Return how long calls take (ms), but for the first ones, of which one is asked for its password."""
    with requests.Session() as session:
        session.auth = HTTPDigestAuth("Default User", "robotics")
        taken = []
        for _ in range(ROUNDS):
            begun = time.perf_counter()
            session.get(url, params={"json": "1"}).raise_for_status()
            taken.append(1e3 * (time.perf_counter() - begun))
    return taken[10:]


def run() -> list[Row]:
    """Return the medians of an arm that stands, and of one that moves."""
    with kernel("--headless") as (address, _), virtualrobot.connect(address) as client:
        arm = client.load_robot("model://irb120", name="arm")
        program = "import sys; from virtualrobot.cli import main; sys.exit(main())"
        command = [sys.executable, "-c", program, "emulate", "abb", "arm", "--address", address]
        with process(command, "Robot Web Services at ") as (told, _):
            base = told.partition(";")[0]
            rows = [_row(f"Robot Web Services: {what}", times(base + path)) for what, path in CALLS.items()]
            motion = arm.move_joints([1.5] + [0.0] * 5, speed_factor=0.05, wait=False)
            rows.append(_row("the same of an arm that moves", times(base + CALLS["place and configuration"])))
            motion.cancel()
        return rows


def _row(what: str, taken: list[float]) -> Row:
    note = f"median of {len(taken)}; p95 {sorted(taken)[int(0.95 * len(taken))]:.1f} ms"
    return row(what, statistics.median(taken), BUDGET_MILLISECONDS, f"{BUDGET_MILLISECONDS:g} ms", "ms", 1.0, note)


if __name__ == "__main__":
    for result in run():
        print(result)
