"""One collision process, the kernel's side: gives it the world and a job, and waits for what that comes to."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from virtualrobot_sdk.errors import ComponentFault, FaultKind, PluginError
from virtualrobot_sdk.worker import Worker

from virtualrobot_kernel.collision.job_host import Answer, Ending
from virtualrobot_kernel.collision.scene_transfer import TransferredWorld, transferred_state
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Structure

log = logging.getLogger(__name__)

HOST = "virtualrobot_kernel.collision.job_host:JobHost"
START_SECONDS = 120.0
"""Longest time (s) that a process may take to begin a job: FCL makes what it needs of the meshes of its world."""
LOOK_SECONDS = 0.05
"""Interval (s) at which a job's report is asked for, and whether anybody still waits."""
GRACE_SECONDS = 1.0
"""Longest time (s) that a job goes on for which nobody waits, before its process is ended."""
MEMORY_BYTES = 4 << 30
"""By how much a process may grow: the triangles of a whole factory, and what FCL makes of them."""


class Job(Future):
    """Work that a process does: a future of what it returns.

    Its exceptions are the KernelError that the work raised; WRONG_STATE when it was given up, INTERNAL when the process
    failed, and SHUTTING_DOWN.
    """

    def __init__(
        self, path: str, snapshot: Snapshot, arguments: tuple[object, ...], told: Callable[[Any], object] | None
    ) -> None:
        """Describe work for a process: see `Processes.submit`."""
        super().__init__()
        self.path, self.snapshot, self.arguments, self.told = path, snapshot, arguments, told
        self.gone = threading.Event()
        self.why = KernelError("nobody waits for this any more", reason=Reason.WRONG_STATE)

    def give_up(self, why: KernelError | None = None) -> None:
        """Say that nobody waits any more: the process hears it within a tenth of a second. Any thread may say it.

        The job then ends with `why`, unless it has ended before.
        """
        self.why = why or self.why
        self.gone.set()

    def cancel(self) -> bool:
        """Give it up; return whether it had not begun."""
        self.give_up()
        return super().cancel()


class Process:
    """Owns a worker process; used by one thread. It starts with the first job, and anew after it has failed."""

    def __init__(
        self, name: str, transferred_world: Callable[[Structure], TransferredWorld], silent_seconds: float
    ) -> None:
        """Make ready.

        Args:
            name: stands before what the process prints, in the log.
            transferred_world: what is sent of a structure.
            silent_seconds: how long a job may neither report nor ask whether anybody waits, before it counts as hung.
        """
        self.name = name
        self._world_of = transferred_world
        self._silent = silent_seconds
        self._worker: Worker | None = None
        self._structure: Structure | None = None

    @property
    def pid(self) -> int | None:
        """Return the number of the process, None while there is none."""
        return self._worker.pid if self._worker else None

    def do(self, job: Job) -> None:
        """Do a job, whose future then has its result or its exception."""
        # First of all, so that nobody can cancel it between a look and what follows from it.
        if not job.set_running_or_notify_cancel():
            return
        try:
            if job.gone.is_set():
                raise job.why
            result = self._done(job)
        except KernelError as error:
            job.set_exception(error)
        except (ComponentFault, PluginError) as error:
            self.close()
            job.set_exception(_failed(error))
        except BaseException as error:
            self.close()
            job.set_exception(error)
        else:
            job.set_result(result)

    def close(self) -> None:
        """End the process."""
        worker, self._worker, self._structure = self._worker, None, None
        if worker is not None:
            worker.close()

    def _done(self, job: Job) -> object:
        idle = self._worker is not None
        try:
            worker = self._begun(job)
        except ComponentFault as error:
            if not idle or error.kind is not FaultKind.DIED:
                raise
            # It ended while it had nothing to do: that is not this job's matter.
            self.close()
            worker = self._begun(job)
        return self._result(job, worker)

    def _begun(self, job: Job) -> Worker:
        """Send a job, with its world where the process has another one."""
        worker = self._started()
        structure, state = job.snapshot.structure, transferred_state(job.snapshot.state)
        world = None if structure is self._structure else self._world_of(structure)
        self._structure = None
        asked = job.path, world, state, job.snapshot.tick_seconds, job.arguments
        worker.call("start", *asked, deadline_seconds=START_SECONDS)
        self._structure = structure
        return worker

    def _started(self) -> Worker:
        if self._worker is None:
            self._worker = worker = Worker(self.name, memory_limit_bytes=MEMORY_BYTES)
            worker.make_from(HOST, deadline_seconds=START_SECONDS)
        return self._worker

    def _result(self, job: Job, worker: Worker) -> object:
        """Wait for the end of a job that has begun, pass on what it reports, and raise what it raised."""
        heard, left = 0, float("inf")
        while True:
            if job.gone.is_set() and left == float("inf"):
                worker.call("give_up", deadline_seconds=self._silent)
                left = time.monotonic() + GRACE_SECONDS
            answer = worker.call("wait", LOOK_SECONDS, deadline_seconds=self._silent)
            if answer[0] != Ending.RUNS.value:
                return _returned(job, answer)
            _, count, report, silence = answer
            if count > heard and job.told is not None:
                job.told(report)
            heard = count
            if time.monotonic() > left:
                self.close()
                raise job.why
            if silence > self._silent:
                raise ComponentFault(FaultKind.HUNG, f"nothing was heard of it for {silence:.0f} s")


def _returned(job: Job, answer: Answer) -> object:
    """Return what a job returned, or raise what it raised."""
    match Ending(answer[0]), *answer[1:]:
        case Ending.DONE, result:
            return result
        case Ending.REFUSED, reason, message, metadata:
            error = KernelError(message, reason=Reason(reason))
            error.metadata.update(metadata)
            raise error
        case Ending.FAILED, said, details:
            raise KernelError(f"work on collisions failed: {said}", reason=Reason.INTERNAL, details=details)
    raise job.why


def _failed(error: ComponentFault | PluginError) -> KernelError:
    reason = error.reason if isinstance(error, ComponentFault) else str(error)
    details = error.details if isinstance(error, ComponentFault) else ""
    return KernelError(
        f"a process that checks collisions failed: {reason}; the next call starts it anew",
        reason=Reason.INTERNAL,
        details=details,
    )
