"""What the tests of the worker process share."""

from __future__ import annotations

import psutil
import pytest
from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.worker import Worker

CASES = "tests.unit.sdk.worker_cases:Cases"
PATIENCE = 30.0
"""A deadline that no test waits for."""
MIB = 1 << 20


def call(worker: Worker, method: str, *arguments: object) -> object:
    return worker.call(method, *arguments, deadline_seconds=PATIENCE)


def fault_of(worker: Worker, method: str, *arguments: object, seconds: float = PATIENCE) -> ComponentFault:
    with pytest.raises(ComponentFault) as raised:
        worker.call(method, *arguments, deadline_seconds=seconds)
    return raised.value


def is_gone(pid: int | None) -> bool:
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True
