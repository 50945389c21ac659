"""Recorder: entries and what they are as steps, as rows of the store."""

from __future__ import annotations

from collections.abc import Sequence

from virtualrobot_kernel.history.codec import Codec
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.rows import Row
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.stored_steps import StoredSteps
from virtualrobot_kernel.history.upkeep import Upkeep


class Recorder:
    """Keeper that writes entries into a store, with the steps that were made of them before."""

    def __init__(self, store: Store, codec: Codec, steps: StoredSteps, upkeep: Upkeep) -> None:
        """Write into `store` what `codec` makes of entries, and what `steps` has; tell `upkeep` of them."""
        self._store = store
        self._encode = codec.encode
        self._steps = steps
        self._upkeep = upkeep
        self._last = store.last_seq

    def keep(self, told: Sequence[Told]) -> None:
        """Write entries and their steps as one transaction."""
        # Others may have failed to keep what is written already.
        rows = [self._row(one) for one in told if one.number > self._last]
        self._store.write(rows, self._steps.waiting())
        self._steps.written()
        self._last = told[-1].number
        self._upkeep.kept(len(rows), sum(len(row.commands) for row in rows))

    def _row(self, told: Told) -> Row:
        entry = told.entry
        commands = told.encoded or self._encode(entry.commands)
        return Row(told.number, entry.tick, entry.wall_time, entry.author, commands)
