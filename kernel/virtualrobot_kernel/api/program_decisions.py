"""Decisions of programs: what a text goes on with is looked up, planned and appended when the program gets there."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import Future

from virtualrobot_kernel.api.convert.program import Continuation
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.open_programs import OpenPrograms
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.world.commands import CancelMotion
from virtualrobot_kernel.world.state import Cancellation, EndCause, Snapshot
from virtualrobot_kernel.world.store import Applied

log = logging.getLogger(__name__)


class Decisions:
    """Tasks that take programs on from one decision to the next, in the API's event loop alone."""

    def __init__(self, kernel: KernelServices, programs: OpenPrograms) -> None:
        """Begin with no program."""
        self._kernel, self._programs = kernel, programs
        self._tasks: set[asyncio.Task[None]] = set()

    def take_on(self, id: str, rest: Continuation, submit: Callable[..., Future[Applied]], *, open: bool) -> None:
        """Take a program on from its first decision; `open`: more may be appended when its text is over.

        submit: queues commands with the leases of the client that started it.
        """
        self._programs.decided[id] = open
        task = asyncio.get_running_loop().create_task(self._go_on(id, rest, submit, open))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _go_on(self, id: str, rest: Continuation, submit: Callable[..., Future[Applied]], open: bool) -> None:
        left: Continuation | None = rest
        begun = 0
        try:
            while left is not None:
                snapshot = await self._reached(id, left, begun)
                if snapshot is None:
                    return
                begun, asked = left.numbered, left.condition
                signal = snapshot.state.signals.get(asked.signal) if asked else None
                holds = asked is None or (signal is not None and asked.holds(signal.value))
                steps, left = await self._kernel.in_worker(left.next, holds)
                if steps or not (left or open):
                    await self._programs.go_on(id, steps, submit, last=left is None and not open)
        except KernelError as error:
            self._end(id, str(error))
        except Exception as error:
            log.exception("the program %r failed inside the kernel", id)
            self._end(id, f"it failed inside the kernel: {type(error).__name__}")
        finally:
            self._programs.decided.pop(id, None)

    async def _reached(self, id: str, rest: Continuation, begun: int) -> Snapshot | None:
        """Return the world when a program has got to a decision; None when it has ended before.

        A round that follows whatever is comes as the one before begins, with the step numbered `begun`.
        """
        snapshot = self._kernel.world.snapshot
        while True:
            motion = next((one for one in snapshot.state.motions if one.id == id), None)
            if motion is None or motion.running.phase is Phase.STOPPING:
                return None
            stands = motion.running.phase is Phase.STARVED
            if stands or (rest.condition is None and motion.running.steps_done >= begun):
                return snapshot
            snapshot = await self._kernel.publications.newer_than(snapshot)

    def _end(self, id: str, reason: str) -> None:
        """Abort a program whose next steps can't be done; one that has ended meanwhile stays so."""
        self._kernel.world.submit([CancelMotion(id, Cancellation(EndCause.STEP_REFUSED, reason))], "kernel")
