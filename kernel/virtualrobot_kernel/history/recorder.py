"""Recorder: entries as rows of the store, in the journal's thread."""

from __future__ import annotations

from collections.abc import Sequence

from virtualrobot_kernel.history.codec import Codec
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.store import Row, Store
from virtualrobot_kernel.history.upkeep import Upkeep


class Recorder:
    """Keeper that writes entries into a store; what is answered is there."""

    def __init__(self, store: Store, codec: Codec, upkeep: Upkeep) -> None:
        """Write into `store` what `codec` makes of entries; tell `upkeep` of them."""
        self._store = store
        self._encode = codec.encode
        self._upkeep = upkeep
        self._last = store.last_seq

    def keep(self, told: Sequence[Told]) -> None:
        """Write entries as one transaction, but those that are written already."""
        rows = [self._row(one) for one in told if one.number > self._last]
        if rows:
            self._store.write(rows)
            self._last = rows[-1].seq
            self._upkeep.kept(told[-1], len(rows), sum(len(row.commands) for row in rows))

    def _row(self, told: Told) -> Row:
        entry = told.entry
        return Row(told.number, entry.tick, entry.wall_time, entry.author, self._encode(entry.commands))
