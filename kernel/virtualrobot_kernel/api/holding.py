"""Hold-to-run: motions that go on only while beats of a client come, and slow to standstill on their path without."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncGenerator, AsyncIterator
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import replace

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.motion_calls import find_motion
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.commands import PauseMotion, ResumeMotion, StartMotion
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import Applied

BEAT_SECONDS = 0.2
"""Time (s of the wall clock) for which a beat is good."""

LOOK_SECONDS = 0.02
"""Time (s) after which it is looked again whether beats come."""

DRIFT = 1e-3
"""Greatest part by which a client's clock goes slower than the kernel's."""

OVER = (Reason.WRONG_STATE, Reason.UNKNOWN_NAME)
"""Reasons for refusing to pause a motion that stops or has ended."""


def check_can_be_held(spec: motion_pb2.MotionSpec) -> None:
    """Raise KernelError for a motion that would move all the same."""
    if spec.HasField("tracking"):
        raise KernelError(
            "a motion that goes along with a frame moves with it while it is paused, so it can't be held; start it "
            "without `hold`, or without `tracking`",
            field="hold",
        )


def held_at_start(command: StartMotion) -> StartMotion:
    """Return a start after which the motion stands until it is resumed."""
    first, *others = command.program.stages
    program = replace(command.program, stages=(replace(first, pauses=True), *others))
    return replace(command, program=program)


class BeatClock:
    """Clock of the beats of one call: when each was sent, however late it comes.

    What a network has held up comes in a burst: those beats are of a time when the key was down, and say nothing of
    now.
    """

    def __init__(self) -> None:
        """Know nothing of the client's clock."""
        self._offset, self._last = math.inf, 0.0

    def sent(self, now: float, said: float) -> float:
        """Return when a beat was sent that comes now, both by the kernel's clock; `said`: that by the client's (s).

        The beat that was the least late so far counts as one that came at once.
        """
        self._offset = min(self._offset + DRIFT * (now - self._last), now - said)
        self._last = now
        return said + self._offset


class Holds:
    """Motions that run only while they are held, and which of them are."""

    def __init__(self, kernel: KernelServices) -> None:
        """Begin with none."""
        self._kernel = kernel
        self._only_held: set[str] = set()
        self._held: set[str] = set()

    def remember(self, id: str) -> None:
        """Have a motion run only while it is held; those that have ended are forgotten."""
        self._only_held &= {motion.id for motion in self._kernel.world.snapshot.state.motions}
        self._only_held.add(id)

    def check_free(self, id: str) -> None:
        """Raise KernelError (WRONG_STATE) for a motion that runs only while it is held."""
        if id in self._only_held:
            raise KernelError(
                f"{id!r} was started to run only while it is held, which HoldMotion does",
                reason=Reason.WRONG_STATE,
                motion=id,
            )

    async def hold(
        self,
        first: motion_pb2.HoldMotionRequest,
        beats: AsyncIterator[motion_pb2.HoldMotionRequest],
        context: object,
    ) -> AsyncGenerator[Snapshot, None]:
        """Yield the world whenever a motion goes on or slows down, and at its end; it is let go when this ends.

        `first` names it, and is the first beat.
        """
        id = first.id
        if id in self._held:
            raise KernelError(
                f"another call holds {id!r} already; let it go there first", reason=Reason.WRONG_STATE, motion=id
            )
        loop, clock = asyncio.get_running_loop(), BeatClock()

        def sent(beat: motion_pb2.HoldMotionRequest) -> float:
            now, said = loop.time(), beat.sent_seconds
            if not math.isfinite(said):
                raise KernelError(f"sent_seconds must be finite, not {said}", field="sent_seconds")
            return clock.sent(now, said) if beat.HasField("sent_seconds") else now

        newest = sent(first)
        self._held.add(id)
        submit = self._kernel.submitting(context)

        async def read() -> None:
            nonlocal newest
            async for beat in beats:
                if beat.id not in ("", id):
                    raise KernelError(f"this call holds {id!r}; hold {beat.id!r} by another one", field="id")
                newest = max(newest, sent(beat))

        reading, goes = asyncio.create_task(read()), False
        try:
            while not find_motion(self._kernel.world.snapshot, id).running.ended:
                is_held = loop.time() - newest < BEAT_SECONDS and not reading.done()
                if is_held != goes:
                    goes = is_held
                    change = submit([ResumeMotion(id)]) if goes else self._let_go(id)
                    with suppress(_Over):
                        yield await _applied(change)
                if reading.done():
                    reading.result()
                    return
                await self._kernel.publications.end_of_motion(id, LOOK_SECONDS)
            yield self._kernel.world.snapshot
        finally:
            reading.cancel()
            self._held.discard(id)
            if goes:
                self._let_go(id)

    def _let_go(self, id: str) -> Future[Applied]:
        return self._kernel.world.submit([PauseMotion(id)], "kernel")


class _Over(Exception):
    """Motion that ends already."""


async def _applied(change: Future[Applied]) -> Snapshot:
    """Return the world after a change; raise _Over where the motion stops or has ended."""
    try:
        return (await asyncio.wrap_future(change)).snapshot
    except KernelError as error:
        if error.reason not in OVER:
            raise
        raise _Over from error
