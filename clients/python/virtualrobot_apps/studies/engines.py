"""Engines, which run the blocks of a study somewhere: in this process, or in worker processes of this machine.

`ray_engine` has one more, for clusters.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Generator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Protocol

from virtualrobot.errors import WrongStateError

from virtualrobot_apps.studies.threads import ONE_THREAD
from virtualrobot_apps.studies.work import Block, Done, Job, work


@dataclass(frozen=True)
class Lost:
    """End of a block whose worker died: how."""

    how: str


Ends = Generator[tuple[Block, Done | Lost], None, None]
"""Blocks, each as it ends."""


class Engine(Protocol):
    """Place where blocks are done; it knows nothing of what they are.

    Attributes:
        workers: number of blocks that are done at once.
    """

    workers: int

    def run(self, job: Job, following: Callable[[], Block | None]) -> Ends:
        """Do the blocks that `following` gives, and yield each as it ends, in any order.

        `following` is asked whenever a worker is free, after all that has ended was yielded; None means none for now.
        It ends when there is none and nothing is running.

        Raises:
            OSError, VirtualRobotError: what `work` raises, which no other try would mend.
        """
        ...


class Here:
    """This process: for looking into a function with a debugger. What kills it, ends the run."""

    workers = 1

    def run(self, job: Job, following: Callable[[], Block | None]) -> Ends:
        """Do one block after the other; raise WrongStateError where cells have a time after which they are killed."""
        if job.study.cell_seconds is not None:
            raise WrongStateError("cell_seconds needs worker processes, which may be killed: take one worker or more")
        while (block := following()) is not None:
            yield block, work(job, block)


class Local:
    """Worker processes of this machine, by loky, each in a pool of its own: one that dies loses its own block alone."""

    def __init__(self, workers: int | None = None) -> None:
        """Choose their number, that of the cores which this process may use by default; they start with the blocks."""
        from loky import cpu_count

        self.workers = workers or cpu_count()

    def run(self, job: Job, following: Callable[[], Block | None]) -> Ends:
        """Do blocks side by side; the workers end with the iterator."""
        free = [_Worker() for _ in range(self.workers)]
        running: dict[Future[Done], tuple[_Worker, Block]] = {}
        try:
            while True:
                while free and (block := following()) is not None:
                    worker = free.pop()
                    running[worker.submit(job, block)] = worker, block
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    worker, block = running.pop(future)
                    free.append(worker)
                    try:
                        answer = future.result()
                    except BrokenProcessPool as error:
                        worker.end()
                        answer = Lost(" ".join(str(error).split()))
                    yield block, answer
        finally:
            for worker in [*free, *(worker for worker, _ in running.values())]:
                worker.end()


class _Worker:
    """A process, which is started anew after it died."""

    def __init__(self) -> None:
        self._pool = None

    def submit(self, job: Job, block: Block) -> Future[Done]:
        from loky import ProcessPoolExecutor

        for _ in range(2):
            if self._pool is None:
                self._pool = ProcessPoolExecutor(1, initializer=_begin, initargs=(os.getpid(),), env=ONE_THREAD)
            try:
                return self._pool.submit(work, job, block, True)
            except BrokenProcessPool:  # it died while it had nothing to do
                self.end()
        raise WrongStateError("worker processes die as soon as they are started")

    def end(self) -> None:
        """Kill the process, whatever it does."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, kill_workers=True)
            self._pool = None


def _begin(parent: int) -> None:
    """Prepare a worker: Ctrl-C is its parent's affair, and it ends when that is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def look() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=look, daemon=True).start()
