"""Checkpoints: worlds under names, to which the world goes back as a whole."""

from __future__ import annotations

import logging
import sqlite3
import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.history.codec import Codec
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.recovery import image
from virtualrobot_kernel.history.rows import CheckpointRow
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.upkeep import KERNEL, Moment, Upkeep
from virtualrobot_kernel.world.apply_checkpoint import checkpoint_of
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.history_commands import RestoreWorld

MOST_CHECKPOINTS = 100
"""Greatest number of checkpoints that clients have made."""

MOST_AUTOMATIC = 10
"""Greatest number of those that the kernel has made; the oldest goes."""

AUTOMATIC = "before step "
"""Begin of the names of these."""

LONGEST_NAME = 200

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """World under a name: who made it, when (seconds since 1970), at which tick, and how many nodes it has.

    `id` is its number in the store.
    """

    id: int
    name: str
    author: str
    wall_time: float
    tick: int
    node_count: int

    @property
    def automatic(self) -> bool:
        """True when the kernel made it, before it went back to another one."""
        return self.name.startswith(AUTOMATIC)


class Checkpoints:
    """Named checkpoints of a store; as a keeper of the journal it keeps the world that each return to one leaves."""

    def __init__(self, store: Store, codec: Codec, upkeep: Upkeep) -> None:
        """Read and remove them in `store`; `upkeep` writes them."""
        self._store, self._codec, self._upkeep = store, codec, upkeep
        self._left: deque[tuple[RestoreWorld, Checkpoint]] = deque(maxlen=MOST_AUTOMATIC)
        self._lock = threading.Lock()

    @property
    def all(self) -> list[Checkpoint]:
        """Checkpoints with a name, oldest first."""
        return [self._known(row) for row in self._store.checkpoints() if row.name]

    def get(self, name: str) -> Checkpoint:
        """Return a checkpoint; raise UnknownNameError."""
        rows = {row.name: row for row in self._store.checkpoints() if row.name}
        if name not in rows:
            raise UnknownNameError("checkpoint", name, rows)
        return self._known(rows[name])

    def restoring(self, checkpoint: Checkpoint) -> RestoreWorld:
        """Return the command that goes back to a checkpoint; raise KernelError when it can't be read."""
        world = image(self._store, self._codec, checkpoint.id)
        return checkpoint_of(Change(world.structure, world.state), checkpoint.name)

    def create(self, name: str, author: str) -> Checkpoint:
        """Keep the world as it was when the history was settled last, under a name (empty: a free one).

        Raises KernelError when the name is taken, and when there are too many.
        """
        with self._lock:
            taken = {row.name for row in self._store.checkpoints() if row.name}
            if not name:
                name = next(free for n in range(1, len(taken) + 2) if (free := f"checkpoint {n}") not in taken)
            if len(name) > LONGEST_NAME or not name.isprintable() or name != name.strip():
                raise KernelError(
                    f"a checkpoint's name has at most {LONGEST_NAME} characters that can be printed, and no space at "
                    f"its ends; this one is {name[:LONGEST_NAME]!r}",
                    field="name",
                )
            if name.startswith(AUTOMATIC):
                raise KernelError(
                    f"names that begin with {AUTOMATIC!r} are the kernel's own; choose another one than {name!r}",
                    field="name",
                )
            if name in taken:
                raise KernelError(
                    f"the name {name!r} is taken by another checkpoint; choose another one, or remove it first",
                    reason=Reason.NAME_TAKEN,
                    name=name,
                )
            if sum(not one.startswith(AUTOMATIC) for one in taken) >= MOST_CHECKPOINTS:
                raise KernelError(
                    f"there are {MOST_CHECKPOINTS} checkpoints already; remove one first",
                    reason=Reason.TOO_LARGE,
                    limit=MOST_CHECKPOINTS,
                )
            try:
                self._upkeep.checkpoint(name, author)
            except sqlite3.Error as error:
                raise KernelError(
                    f"the checkpoint can't be written: {error}. Make room on its disk",
                    reason=Reason.WRONG_STATE,
                ) from error
        return self.get(name)

    def remove(self, name: str) -> Checkpoint:
        """Forget a checkpoint and return it; raise UnknownNameError."""
        with self._lock:
            found = self.get(name)
            self._remove([found.id])
            return found

    def left_by(self, command: RestoreWorld) -> Checkpoint | None:
        """Return the world as it was right before a return to a checkpoint; None when it could not be kept."""
        return next((checkpoint for one, checkpoint in reversed(self._left) if one is command), None)

    def keep(self, told: Sequence[Told]) -> None:
        """Keep the worlds that were left for a checkpoint."""
        for one in told:
            for command in one.entry.commands:
                if isinstance(command, RestoreWorld):
                    try:
                        self._left.append((command, self._note(one)))
                    except Exception:  # the world has gone back all the same
                        log.exception("the world before entry %d could not be kept as a checkpoint", one.number)

    def _note(self, told: Told) -> Checkpoint:
        with self._lock:
            name = f"{AUTOMATIC}{told.number}"
            before = Moment(told.number - 1, told.before.structure, told.before.state)
            self._upkeep.checkpoint(name, told.entry.author, before)
            others = [row.id for row in self._store.checkpoints() if row.name.startswith(AUTOMATIC)]
            if old := others[:-MOST_AUTOMATIC]:
                self._remove(old)
            return self.get(name)

    def _remove(self, ids: Sequence[int]) -> None:
        """Take checkpoints out; the one that the rest of a thinned history begins with loses its name alone."""
        forgotten = self._store.forgotten
        begin = next((row for row in self._store.checkpoints() if row.seq >= forgotten), None) if forgotten else None
        if begin is not None and begin.id in ids and (row := self._store.checkpoint(begin.id)) is not None:
            self._store.add_checkpoint(replace(row, name="", author=KERNEL), {})
        self._upkeep.remove_checkpoints(ids)

    def _known(self, row: CheckpointRow) -> Checkpoint:
        return Checkpoint(row.id, row.name, row.author, row.time, row.tick, row.nodes)
