"""From starting the process to the first answered call, warm: compiled code and files are cached."""

from __future__ import annotations

import subprocess
import sys
import time

import grpc
import numpy as np
from virtualrobot.v1 import kernel_pb2, kernel_pb2_grpc

from benchmarks.processes import kernel
from benchmarks.rows import Row, row

STARTS = 5
BUDGET_SECONDS = 1.0


def first_call_seconds(*options: str) -> float:
    """Return the time until a fresh kernel has answered one call."""
    start = time.perf_counter()
    with kernel(*options) as (address, _), grpc.insecure_channel(address) as channel:
        kernel_pb2_grpc.KernelServiceStub(channel).GetInfo(kernel_pb2.GetInfoRequest(), wait_for_ready=True)
        return time.perf_counter() - start


def python_seconds() -> float:
    """Return the time that Python takes to start, import gRPC and numba, and end."""
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", "import grpc.aio, numba"], check=True)
    return time.perf_counter() - start


def run() -> list[Row]:
    """Measure and return the rows."""
    first_call_seconds("--headless")
    seconds = float(np.median([first_call_seconds("--headless") for _ in range(STARTS)]))
    bare = float(np.median([python_seconds() for _ in range(STARTS)]))
    return [
        row("start to first answered call, warm", seconds, BUDGET_SECONDS, "the budget", "s", 1.0),
        row("start to first answered call, warm", seconds, bare, "python importing grpc and numba", "s", None),
    ]


if __name__ == "__main__":
    for result in run():
        print(result)
