"""What it costs that a component runs in a process of its own: a call of `chain` there against one in this process."""

from __future__ import annotations

import time
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.connection import Connection

import numpy as np
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.worker import Worker

from benchmarks.kinematics import ARMS, chain_of
from benchmarks.rows import Row, row

CALLS = 2000
DEADLINE_SECONDS = 5.0


def median_microseconds(call: Callable[[], object]) -> float:
    """Return the median time of a call."""
    call()
    times = []
    for _ in range(CALLS):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return float(np.median(times)) * 1e6


def echo(pipe: Connection) -> None:
    """Send back what comes, until nothing does: the peer's process."""
    while (value := pipe.recv()) is not None:
        pipe.send(value)


def bare_echo_microseconds(value: object) -> float:
    """Return the median time in which a bare pipe of multiprocessing brings `value` to a process and back."""
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=echo, args=(theirs,), daemon=True)
    process.start()

    def call() -> object:
        ours.send(value)
        return ours.recv()

    microseconds = median_microseconds(call)
    ours.send(None)
    process.join()
    return microseconds


def run() -> list[Row]:
    """Measure and return the rows."""
    chain = chain_of(ARMS[0])
    here = ChainKinematics(chain)
    q = np.array([0.1, 0.5, 0.2, -1.0, 0.3, 0.6, 0.1])
    target = here.forward(q)[-1]
    start = time.perf_counter()
    with Worker("benchmark") as worker:
        worker.make_from("virtualrobot_plugins.chain.component:ChainKinematics", chain, deadline_seconds=60.0)
        started = time.perf_counter() - start

        def there(method: str, argument: np.ndarray) -> Callable[[], object]:
            return lambda: worker.call(method, argument, deadline_seconds=DEADLINE_SECONDS)

        forward = median_microseconds(there("forward", q))
        inverse = median_microseconds(there("inverse", target))
    bare = bare_echo_microseconds(here.forward(q))
    name = "component, 7 axes"
    return [
        row(f"{name}, forward, own process", forward, bare, "bare pipe of multiprocessing, echo", "µs", None),
        row(
            f"{name}, forward, own process",
            forward,
            median_microseconds(lambda: here.forward(q)),
            "in process",
            "µs",
            None,
        ),
        row(
            f"{name}, inverse, own process",
            inverse,
            median_microseconds(lambda: here.inverse(target)),
            "in process",
            "µs",
            None,
        ),
        row("component, process started and component made", started, 1.0, "one second", "s", None),
    ]


if __name__ == "__main__":
    for result in run():
        print(result)
