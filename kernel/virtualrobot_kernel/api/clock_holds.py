"""Time that is stepped for as long as a client holds it, and runs as before once that is gone."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager, suppress

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World


class ClockHolds:
    """Hold of the clock by one client at a time, for the API's thread."""

    def __init__(self, world: World) -> None:
        """Begin with none."""
        self._world = world
        self._holder = ""
        self._before: Clock | None = None

    def forget(self) -> None:
        """Leave the clock as somebody sets it now, at the end of the hold, too."""
        self._before = None

    @asynccontextmanager
    async def held(self, holder: str) -> AsyncGenerator[Snapshot, None]:
        """Let time be stepped for the length of a block; yield the snapshot from which on it is.

        `holder` is who holds it, for people. Raises KernelError (WRONG_STATE) while another one does, and where time
        must follow the wall clock.
        """
        world = self._world
        if self._holder:
            raise KernelError(
                f"time is stepped by {self._holder}; one at a time holds the clock, so wait for its end",
                reason=Reason.WRONG_STATE,
            )
        self._holder, self._before = holder, world.clock
        try:
            yield await asyncio.wrap_future(world.set_clock(Mode.STEPPED, world.clock.speed_factor))
        finally:
            self._holder = ""
            if (before := self._before) is not None:
                ended = asyncio.wrap_future(world.set_clock(before.mode, before.speed_factor))
                with suppress(KernelError):  # the kernel ends
                    await asyncio.shield(ended)  # the call of a client that is gone is cancelled more than once
