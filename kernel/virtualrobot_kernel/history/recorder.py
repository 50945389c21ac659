"""Recorder: entries as rows of the store, in the journal's thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from virtualrobot_kernel.history.codec import Codec
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.store import Row, Store
from virtualrobot_kernel.history.upkeep import Upkeep


@dataclass(frozen=True, slots=True, eq=False)
class Described:
    """Description of a step: in words, what sort it is, its encoded difference for undo, the nodes it was about."""

    label: str = ""
    kind: str = ""
    records: bytes | None = None
    touched: tuple[int, ...] = ()


class Recorder:
    """Keeper that writes entries into a store; what is answered is there."""

    def __init__(
        self,
        store: Store,
        codec: Codec,
        upkeep: Upkeep,
        describe: Callable[[Told], Described] = lambda told: Described(),
    ) -> None:
        """Write into `store` what `codec` and `describe` make of entries; tell `upkeep` of them."""
        self._store = store
        self._encode = codec.encode
        self._describe = describe
        self._upkeep = upkeep
        self._last = store.last_seq

    def keep(self, told: Sequence[Told]) -> None:
        """Write entries as one transaction; those that are written already, since others could not keep them, not."""
        rows = [self._row(one) for one in told if one.number > self._last]
        if not rows:
            return
        self._store.write(rows)
        self._last = rows[-1].seq
        self._upkeep.kept(told[-1], len(rows), sum(len(row.commands) + len(row.records or b"") for row in rows))

    def _row(self, told: Told) -> Row:
        entry, about = told.entry, self._describe(told)
        return Row(
            told.number,
            entry.tick,
            entry.wall_time,
            entry.author,
            about.label,
            about.kind,
            self._encode(entry.commands),
            about.records,
            about.touched,
        )
