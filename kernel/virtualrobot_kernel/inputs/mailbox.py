"""Mailbox of a tick: what writers at the rate of ticks have for the world, the newest of each.

Setpoints, measured joints, physics and moving bases come as often as ticks or more often. They do not queue: the world
thread takes all that is there as a tick begins (`World`), as one entry of the journal and one publication.
"""

from __future__ import annotations

from collections.abc import Hashable

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.tick_inputs import TickInput

MOST_TARGETS = 4096
"""Greatest number of inputs that wait for a tick: it must stay short, whoever writes."""


class Mailbox:
    """Inputs that wait for the next tick; any thread may put one in, the world thread takes them out.

    There is no lock: adding to a dictionary, listing its keys and taking one out are each atomic in CPython while keys
    are strings and numbers. So no writer ever holds the world thread up.
    """

    def __init__(self) -> None:
        """Begin empty."""
        self._waiting: dict[Hashable, TickInput] = {}

    def put(self, target: Hashable, item: TickInput) -> None:
        """Have the world take an input with the next tick; it replaces the one of the same writer for this target.

        Raises KernelError (TOO_LARGE) when `MOST_TARGETS` others wait already.
        """
        key = item.writer, target
        if len(self._waiting) >= MOST_TARGETS and key not in self._waiting:
            raise KernelError(
                f"{MOST_TARGETS} inputs wait for the next tick already, and {item.writer!r} has one more; "
                "let time go on, or write to fewer targets",
                reason=Reason.TOO_LARGE,
                writer=item.writer,
                target=target,
            )
        self._waiting[key] = item

    def take(self) -> list[TickInput]:
        """Return the inputs that wait, in the order in which their targets were first written to; none is left."""
        if not self._waiting:
            return []
        taken = (self._waiting.pop(key, None) for key in list(self._waiting))
        return [item for item in taken if item is not None]
