"""Inside a collision process: does one job at a time in a thread of its own, so that the kernel is always answered.

`Process` is the kernel's side. Answers are plain data: the kernel reads nothing else from a process.
"""

from __future__ import annotations

import atexit
import importlib
import os
import threading
import time
from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any

from virtualrobot_sdk.worker.blame import describe_error, traceback_of

from virtualrobot_kernel.collision.scene_transfer import TransferredWorld
from virtualrobot_kernel.collision.site import GivenUp, Site
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.state import State

LAST_SECONDS = 0.5
"""Longest time (s) that a job may take to end when its process ends."""


class Ending(Enum):
    """End of a job, and what comes with it."""

    RUNS = "runs"
    """Number of its reports, the last of them, and the time (s) since anything was heard of the job."""
    DONE = "done"
    """Value that it returned."""
    REFUSED = "refused"
    """A KernelError: its reason, message and metadata."""
    GIVEN_UP = "given up"
    """Nothing: nobody waited for it any more."""
    FAILED = "failed"
    """Anything else that it raised, in a line and with the traceback."""


Answer = tuple[Any, ...]
"""The value of an Ending, and what comes with it."""


class JobHost:
    """Owns the site of this process, and the thread of the job that runs."""

    def __init__(self) -> None:
        """Make ready for the first job."""
        self._site = Site()
        self._over = threading.Event()
        self._answer: Answer = ()
        self._thread = threading.Thread()
        atexit.register(self._end)

    def start(
        self, job: str, world: TransferredWorld | None, state: State, tick_seconds: float, arguments: tuple[object, ...]
    ) -> None:
        """Make ready for a job, `module:function`, in another world or in the same structure (None)."""
        self._over.clear()
        function = _function(job)
        self._site.put(world, state, tick_seconds)
        self._thread = threading.Thread(target=self._work, args=(function, arguments), name="job", daemon=True)

    def wait(self, seconds: float) -> Answer:
        """Return what the job has come to when it ends, or so many seconds from now; the first call begins it.

        Work that never lets this thread run can so only hold up an answer that the kernel does not wait for long.
        """
        if self._thread.ident is None:
            self._thread.start()
        if self._over.wait(seconds):
            self._thread.join()
            return self._answer
        return Ending.RUNS.value, *self._site.report, time.monotonic() - self._site.heard

    def give_up(self) -> None:
        """Say that nobody waits for the job any more."""
        self._site.gone.set()

    def _work(self, function: Callable[..., object], arguments: tuple[object, ...]) -> None:
        self._answer = _come_to(lambda: function(self._site, *arguments))
        self._over.set()

    def _end(self) -> None:
        """End with the kernel: a thread that is left in C code when the interpreter ends would end in an abort."""
        self._site.gone.set()
        if self._thread.is_alive():
            self._thread.join(LAST_SECONDS)
        if self._thread.is_alive():
            os._exit(1)


def _come_to(work: Callable[[], object]) -> Answer:
    try:
        return Ending.DONE.value, work()
    except KernelError as error:
        metadata: Mapping[str, str] = error.metadata
        return Ending.REFUSED.value, error.reason.value, str(error), dict(metadata)
    except GivenUp:
        return (Ending.GIVEN_UP.value,)
    except BaseException as error:
        # Also SystemExit: to end the process is the kernel's right alone.
        return Ending.FAILED.value, describe_error(error, "virtualrobot_kernel"), traceback_of(error)


def _function(job: str) -> Callable[..., object]:
    module, _, name = job.partition(":")
    return getattr(importlib.import_module(module), name)
