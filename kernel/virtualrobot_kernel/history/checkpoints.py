"""Checkpoints: worlds under names, to which the world goes back as a whole."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.world.apply_checkpoint import checkpoint_of
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import RestoreWorld

MOST_CHECKPOINTS = 100
"""Greatest number of checkpoints that clients have made."""

MOST_AUTOMATIC = 10
"""Greatest number of those that the kernel has made; the oldest goes."""

LONGEST_NAME = 200


@dataclass(frozen=True, slots=True, eq=False)
class Checkpoint:
    """World under a name: who made it, when (seconds since 1970), and the command that goes back to it.

    `automatic`: the kernel made it before it went back to another one.
    """

    name: str
    author: str
    wall_time: float
    restore: RestoreWorld
    automatic: bool = False


class Checkpoints:
    """Checkpoints of a world; as a keeper of the journal it notes the world that each return to one leaves."""

    def __init__(self) -> None:
        """Begin with none."""
        self._by_name: dict[str, Checkpoint] = {}
        self._left: deque[tuple[RestoreWorld, Checkpoint]] = deque(maxlen=MOST_AUTOMATIC)
        self._lock = threading.Lock()

    @property
    def all(self) -> list[Checkpoint]:
        """Checkpoints, oldest first."""
        return list(self._by_name.values())

    def get(self, name: str) -> Checkpoint:
        """Return a checkpoint; raise UnknownNameError."""
        try:
            return self._by_name[name]
        except KeyError:
            raise UnknownNameError("checkpoint", name, self._by_name) from None

    def create(self, name: str, author: str, world: Change) -> Checkpoint:
        """Keep a world under a name (empty: one that is free); raise KernelError when it is taken, or for too many."""
        with self._lock:
            if not name:
                name = next(free for n in range(1, 10**9) if (free := f"checkpoint {n}") not in self._by_name)
            if len(name) > LONGEST_NAME or not name.isprintable() or name != name.strip():
                raise KernelError(
                    f"a checkpoint's name has at most {LONGEST_NAME} characters that can be printed, and no space at "
                    f"its ends; this one is {name[:LONGEST_NAME]!r}",
                    field="name",
                )
            if name in self._by_name:
                raise KernelError(
                    f"the name {name!r} is taken by another checkpoint; choose another one, or remove it first",
                    reason=Reason.NAME_TAKEN,
                    name=name,
                )
            if sum(not one.automatic for one in self._by_name.values()) >= MOST_CHECKPOINTS:
                raise KernelError(
                    f"there are {MOST_CHECKPOINTS} checkpoints already; remove one first",
                    reason=Reason.TOO_LARGE,
                    limit=MOST_CHECKPOINTS,
                )
            made = Checkpoint(name, author, time.time(), checkpoint_of(world, name))
            self._by_name = {**self._by_name, name: made}
            return made

    def remove(self, name: str) -> Checkpoint:
        """Forget a checkpoint and return it; raise UnknownNameError."""
        with self._lock:
            found = self.get(name)
            self._by_name = {other: one for other, one in self._by_name.items() if other != name}
            return found

    def left_by(self, command: RestoreWorld) -> Checkpoint:
        """Return the world as it was right before a return to a checkpoint; there must have been one."""
        return next(checkpoint for one, checkpoint in reversed(self._left) if one is command)

    def keep(self, told: Sequence[Told]) -> None:
        """Keep the worlds that were left for a checkpoint."""
        for one in told:
            for command in one.entry.commands:
                if isinstance(command, RestoreWorld):
                    self._note(one, command)

    def _note(self, told: Told, command: RestoreWorld) -> None:
        with self._lock:
            name = f"before step {told.number}"
            made = Checkpoint(
                name, told.entry.author, told.entry.wall_time, checkpoint_of(told.before, name), automatic=True
            )
            others = [one for one in self._by_name.values() if one.automatic]
            gone = {one.name for one in others[: max(0, len(others) + 1 - MOST_AUTOMATIC)]}
            self._by_name = {**{key: one for key, one in self._by_name.items() if key not in gone}, name: made}
            self._left.append((command, made))
