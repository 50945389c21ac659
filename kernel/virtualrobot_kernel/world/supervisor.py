"""Supervisors of the world: parts of the kernel that command it between two ticks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.state import Snapshot


class Supervisor(Protocol):
    """Part of the kernel that the world thread asks for commands, which it applies, journals and publishes.

    So a replay needs no supervisor. What it raises counts as wanting nothing, and is logged.
    """

    author: str
    """Author of its commands in the journal."""

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None:
        """Raise KernelError when commands of others must not make `before` what is `after`; nothing changes then."""
        ...

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Return commands to apply to `now` before time goes on to `later`, which is not published yet.

        When there are some, `later` is made again, or only what they tell for the tick is put into it, and all
        supervisors are asked again. Raises Late (`lateness.py`) where an answer is not there yet: all are asked again
        once it is, in the same tick, and others may have changed the world meanwhile.
        """
        ...

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        """Return commands to apply after a publication: of a tick, a batch of commands, a change of the clock.

        They are applied in the same tick, and nobody is asked because of them.
        """
        ...
