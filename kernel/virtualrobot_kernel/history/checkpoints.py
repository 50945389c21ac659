"""Checkpoints: worlds under names, to which the world goes back as a whole."""

from __future__ import annotations

import sqlite3
import threading
from collections import deque
from collections.abc import Sequence

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.history.codec import Codec
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.recovery import image
from virtualrobot_kernel.history.store import CheckpointRow, Store
from virtualrobot_kernel.history.upkeep import Moment, Upkeep
from virtualrobot_kernel.world.apply_checkpoint import checkpoint_of
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import RestoreWorld

MOST_CHECKPOINTS = 100
"""Greatest number of checkpoints that clients have made."""

MOST_AUTOMATIC = 10
"""Greatest number of those that the kernel has made; the oldest goes."""

LONGEST_NAME = 200


class Checkpoints:
    """Checkpoints of a world; as a keeper of the journal it keeps the world that each return to one leaves."""

    def __init__(self, store: Store, upkeep: Upkeep, codec: Codec) -> None:
        """Begin with those of `store`; `upkeep` makes others, and `codec` reads them."""
        self._store, self._upkeep, self._codec = store, upkeep, codec
        self._left: deque[tuple[RestoreWorld, CheckpointRow]] = deque(maxlen=MOST_AUTOMATIC)
        self._lock = threading.Lock()

    @property
    def all(self) -> list[CheckpointRow]:
        """Checkpoints, oldest first."""
        return sorted((one for one in self._store.checkpoints() if one.name), key=lambda one: one.id)

    def get(self, name: str) -> CheckpointRow:
        """Return a checkpoint; raise UnknownNameError."""
        by_name = {one.name: one for one in self.all}
        if name not in by_name:
            raise UnknownNameError("checkpoint", name, by_name)
        return by_name[name]

    def restore(self, name: str) -> RestoreWorld:
        """Return the command that goes back to a checkpoint; raise KernelError when there is none, or it is damaged."""
        world = image(self._store, self._codec, self.get(name).id)
        return checkpoint_of(Change(world.structure, world.state), name)

    def create(self, name: str, author: str) -> CheckpointRow:
        """Keep the world as it is under a name (empty: a free one) and return the checkpoint.

        Raises KernelError for a name that is taken or none, for too many, and when it can't be written.
        """
        with self._lock:
            taken = {one.name: one for one in self.all}
            if not name:
                name = next(free for n in range(1, 10**9) if (free := f"checkpoint {n}") not in taken)
            if len(name) > LONGEST_NAME or not name.isprintable() or name != name.strip():
                raise KernelError(
                    f"a checkpoint's name has at most {LONGEST_NAME} characters that can be printed, and no space at "
                    f"its ends; this one is {name[:LONGEST_NAME]!r}",
                    field="name",
                )
            if name in taken:
                raise KernelError(
                    f"the name {name!r} is taken by another checkpoint; choose another one, or remove it first",
                    reason=Reason.NAME_TAKEN,
                    name=name,
                )
            if sum(not one.automatic for one in taken.values()) >= MOST_CHECKPOINTS:
                raise KernelError(
                    f"there are {MOST_CHECKPOINTS} checkpoints already; remove one first",
                    reason=Reason.TOO_LARGE,
                    limit=MOST_CHECKPOINTS,
                )
            try:
                return self._upkeep.checkpoint(name, author)
            except sqlite3.Error as error:
                raise KernelError(f"the checkpoint can't be written: {error}", reason=Reason.WRONG_STATE) from error

    def remove(self, name: str) -> CheckpointRow:
        """Forget a checkpoint and return it; raise UnknownNameError."""
        with self._lock:
            found = self.get(name)
            self._upkeep.remove_checkpoints([found.id])
            return found

    def left_by(self, command: RestoreWorld) -> CheckpointRow:
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
            before = Moment(told.number - 1, told.before.structure, told.before.state)
            made = next((one for one in self.all if one.name == name), None)
            made = made or self._upkeep.checkpoint(name, told.entry.author, before, automatic=True)
            others = [one.id for one in self.all if one.automatic]
            if len(others) > MOST_AUTOMATIC:
                self._upkeep.remove_checkpoints(others[:-MOST_AUTOMATIC])
            self._left.append((command, made))
