"""Store that is made of what is left of a damaged one."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from itertools import islice
from typing import Any

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.rows import UNSOUND, part_hashes, uids
from virtualrobot_kernel.history.store import NOTE, ROWS_AT_ONCE, Store


class SalvagedStore(Store):
    """Store into which rows come that were found somewhere, and which is then cut to what belongs together."""

    def adopt(self, found: Iterable[tuple[Any, ...]]) -> None:
        """Take rows of another store, whichever table they are of, that have the right checksum; leave out all else.

        Of two that have one place the later one counts.
        """
        tables = {
            6: ("entries", self._columns.entry),
            12: ("steps", self._columns.step),
            10: ("checkpoints", self._columns.checkpoint),
            4: ("hashes", self._columns.hashes),
            3: ("parts", self._columns.part),
        }
        found = iter(found)
        while some := list(islice(found, ROWS_AT_ONCE)):
            with self._transaction() as writer:
                for one in some:
                    if len(one) in tables:
                        table, check = tables[len(one)]
                        with suppress(KernelError, *UNSOUND):
                            check(one)
                            marks = ",".join("?" * len(one))
                            writer.execute(f"INSERT OR REPLACE INTO {table} VALUES ({marks})", one)

    def runs(self) -> list[tuple[int, int]]:
        """Return (number of the first, of the last) entry of each row of entries without a gap, in their order."""
        sql = "SELECT seq FROM entries AS here WHERE NOT EXISTS (SELECT 1 FROM entries WHERE seq = here.seq {} 1)"
        first, last = (self._all(f"{sql.format(side)} ORDER BY seq") for side in "-+")
        return [(a, b) for (a,), (b,) in zip(first, last, strict=True)]

    def entries_of_steps(self) -> set[int]:
        """Return the numbers of the entries that the steps which are there were made of."""
        spans = self._all("SELECT first, number FROM steps")
        return {number for first, last in spans for number in range(first, last + 1)}

    def keep_only(self, after: int, last: int, last_tick: int) -> None:
        """Delete entries but those after a number, up to and with a last one, and what came after that one.

        Steps and named checkpoints from before stay; hashes stay that go no further than to `last_tick`.
        """
        with self._transaction() as writer:
            run = writer.execute
            run("DELETE FROM entries WHERE seq <= ? OR seq > ?", (after, last))
            run(NOTE, ("forgotten", after))
            run("DELETE FROM steps WHERE number > ?", (last,))
            # A step that was drawn out later has the same first entry, and its row has been deleted.
            later = "SELECT 1 FROM steps AS later WHERE later.first = steps.first AND later.number > steps.number"
            run(f"DELETE FROM steps WHERE EXISTS ({later})")
            run("DELETE FROM hashes WHERE last_tick > ?", (last_tick,))
            run("DELETE FROM checkpoints WHERE seq < ? AND name = ''", (after,))
            unused = {key for (key,) in run("SELECT hash FROM parts").fetchall()}
            for (blob,) in run("SELECT parts FROM checkpoints").fetchall():
                unused.difference_update(part_hashes(blob))
            writer.executemany("DELETE FROM parts WHERE hash = ?", [(key,) for key in unused])
            for number, touched in run("SELECT number, touched FROM steps").fetchall():
                rows = [(uid, number) for uid in uids(touched)]
                writer.executemany("INSERT OR IGNORE INTO touched VALUES (?,?)", rows)
