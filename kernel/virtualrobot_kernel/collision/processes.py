"""The processes in which long work on collisions is done: checks of many configurations, and planning of paths."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any

from virtualrobot_kernel.background import spare_cores
from virtualrobot_kernel.collision.process import Job, Process
from virtualrobot_kernel.collision.scene_transfer import TransferredWorld, transferred_world
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Structure

IDLE_SECONDS = 60.0
"""Time (s) that a process waits for another job before it ends."""
SILENT_SECONDS = 60.0
"""Longest time (s) that a job neither reports nor asks whether anybody waits, before it counts as hung."""
CLOSING_SECONDS = 2.0


class Processes:
    """Owns the processes, and a thread for each; they start when there is work, and end when there is none for long."""

    def __init__(
        self,
        shapes: ShapeLibrary,
        count: int | None = None,
        idle_seconds: float = IDLE_SECONDS,
        silent_seconds: float = SILENT_SECONDS,
    ) -> None:
        """Start nothing yet.

        Args:
            shapes: gives the triangles of meshes.
            count: how many processes at most; None leaves one core free.
            idle_seconds: how long a process waits for another job.
            silent_seconds: how long a job may be silent.
        """
        self.count = count or spare_cores()
        self._shapes = shapes
        self._idle_seconds = idle_seconds
        self._silent_seconds = silent_seconds
        self._awake = threading.Condition()
        self._line: deque[Job] = deque()
        self._at_work: dict[threading.Thread, tuple[Process, Job | None]] = {}
        self._idle = 0
        self._closed = False
        self._last: tuple[Structure, TransferredWorld] | None = None

    @property
    def pids(self) -> list[int]:
        """Return the numbers of the processes that there are."""
        return [pid for process, _ in list(self._at_work.values()) if (pid := process.pid) is not None]

    def submit(
        self, path: str, snapshot: Snapshot, *arguments: object, told: Callable[[Any], object] | None = None
    ) -> Job:
        """Queue work for a process; its exceptions are those of `Job`.

        Jobs have their turn in the order in which they came: keep many of them back.

        Args:
            path: `module:function` of the work. It is called with a `Site` and the arguments, and returns plain data:
                numbers, text, lists, dicts, NumPy arrays.
            snapshot: the world that the work sees.
            arguments: anything that can be pickled.
            told: is called with what the work reports, the newest about 20 times a second, in another thread.

        Raises:
            KernelError: SHUTTING_DOWN.
        """
        job = Job(path, snapshot, arguments, told)
        with self._awake:
            if self._closed:
                raise _shutting_down()
            self._line.append(job)
            if len(self._line) > self._idle and len(self._at_work) < self.count:
                process = Process(f"collision {len(self._at_work) + 1}", self._world_of, self._silent_seconds)
                thread = threading.Thread(target=self._work, args=(process,), name=process.name, daemon=True)
                self._at_work[thread] = process, None
                thread.start()
            else:
                self._awake.notify()
        return job

    def close(self) -> None:
        """Begin nothing more; give up what has begun, and end the processes."""
        with self._awake:
            self._closed = True
            waiting = list(self._line)
            self._line.clear()
            working = dict(self._at_work)
            self._awake.notify_all()
        for job in waiting:
            if job.set_running_or_notify_cancel():
                job.set_exception(_shutting_down())
        for _, job in working.values():
            if job is not None:
                job.give_up(_shutting_down())
        for thread in working:
            thread.join(CLOSING_SECONDS)

    def _work(self, process: Process) -> None:
        """Do one job after the other in a process."""
        thread = threading.current_thread()
        while (job := self._next(thread, process)) is not None:
            process.do(job)
        process.close()

    def _next(self, thread: threading.Thread, process: Process) -> Job | None:
        """Return the next job; None when there was none for long, or when all ends."""
        with self._awake:
            self._at_work[thread] = process, None
            self._idle += 1
            self._awake.wait_for(lambda: self._line or self._closed, self._idle_seconds)
            self._idle -= 1
            if not self._line:
                del self._at_work[thread]
                return None
            job = self._line.popleft()
            self._at_work[thread] = process, job
            return job

    def _world_of(self, structure: Structure) -> TransferredWorld:
        """Return what is sent of a structure; the same for all processes."""
        last = self._last
        if last is None or last[0] is not structure:
            self._last = last = structure, transferred_world(structure, self._shapes)
        return last[1]


def _shutting_down() -> KernelError:
    return KernelError("the kernel is ending", reason=Reason.SHUTTING_DOWN)
