"""World of a replay: time goes through what was instead of making what comes; everybody reads it, and nothing else."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import replace
from typing import Protocol

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.clock import Clock, Mode, Recorded
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.journal import Answer, Entry
from virtualrobot_kernel.world.state import Snapshot, State
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.supervisor import Supervisor

log = logging.getLogger(__name__)


def is_past() -> KernelError:
    """Return the refusal of what would change a replay."""
    return KernelError(
        "this is a replay, and what was can only be looked at; change the world of a kernel that runs",
        reason=Reason.WRONG_STATE,
    )


class Past(Protocol):
    """Past of a world, at one moment of it; the world thread alone calls it."""

    @property
    def first_tick(self) -> int:
        """First tick that is recorded."""
        ...

    @property
    def last_tick(self) -> int:
        """Last tick that is recorded."""
        ...

    def later(self) -> Change:
        """Go on by a tick; return the world with all that was done in it."""
        ...

    def at(self, tick: int) -> Change:
        """Go to a tick; return the world with all that was done in it."""
        ...


class NoJournal:
    """Journal of a world that nothing changes."""

    def admit(self, commands: Sequence[Command]) -> None:
        """Raise KernelError (WRONG_STATE): what was is not changed."""
        raise is_past()

    def append(self, entry: Entry, before: Change, after: Change) -> None:
        """Keep nothing."""

    def answer(self, answer: Answer) -> None:
        """Answer at once."""
        answer(None)

    def ticked(self, structure: Structure, state: State) -> None:
        """Keep nothing."""


class PastWorld(World):
    """World of a replay: ticks, steps and speed go through a past, and `seek` goes to any moment of it.

    At the last tick the clock goes over to STEPPED. Supervisors are told what is, and what they want is not done: what
    they did then is part of the past.
    """

    publishes_each_tick = True

    def __init__(self, forward: Forward, clock: Clock, past: Past) -> None:
        """Begin at the first moment of a past; nothing runs before `start`."""
        self._past = past
        self._jumps = 0
        begin = past.at(past.first_tick)
        self._recorded = Recorded(past.first_tick, past.last_tick)
        super().__init__(forward, NoJournal(), replace(clock, recorded=self._recorded), begin.structure, begin.state)

    def seek(self, tick: int) -> Future[Snapshot]:
        """Go to a tick, back or forth; the epoch rises, since that is no way that the world has gone."""
        return self._told(lambda: self._seek(tick))

    def _seek(self, tick: int) -> Snapshot:
        first, last = self._recorded.first_tick, self._recorded.last_tick
        if not first <= tick <= last:
            raise KernelError(
                f"the record goes from {self._seconds(first)} to {self._seconds(last)}, not to {self._seconds(tick)}",
                tick=tick,
                first_tick=first,
                last_tick=last,
            )
        change = self._past.at(tick)
        self._jumps += 1
        self._show(change)
        return self.snapshot

    def _seconds(self, tick: int) -> str:
        """Return the moment of a tick for people; clients seek by seconds."""
        return f"{tick * self.clock.tick_seconds:.9g} s"

    def _step(self, ticks: int, until: Callable[[Snapshot], bool] | None) -> Snapshot:
        left = self._recorded.last_tick - self.snapshot.state.tick
        if ticks > left:
            raise KernelError(
                f"the record ends {left} ticks from here, at {self._seconds(self._recorded.last_tick)}",
                reason=Reason.WRONG_STATE,
                ticks=ticks,
                left=left,
            )
        return super()._step(ticks, until)

    def _tick(self) -> None:
        if self.snapshot.state.tick >= self._recorded.last_tick:
            self._pacer.set(Mode.STEPPED, self.clock.speed_factor, time.monotonic())
            self._publish(self._later(self.snapshot.structure, self.snapshot.state))
            return
        self._show(self._past.later())
        self._tick_listeners.tell(self.snapshot)

    def _show(self, change: Change) -> None:
        state = change.state
        if self._jumps:
            state = replace(state, epoch=state.epoch + self._jumps)
        self._publish(self._later(change.structure, state))
        self._supervise_change()

    def _enacted(self, supervisor: Supervisor, ask: Callable[..., Sequence[Command]], *about: Snapshot) -> bool:
        try:
            ask(*about)
        except Exception:
            log.exception("%s failed inside the kernel", supervisor.author)
        return False
