"""Store of the history: one SQLite database, in a file or in memory, whose rows carry checksums.

Bytes in, bytes out: what they say is the codec's. One thread writes; any thread may read.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.history.database import Connection, Database, connect
from virtualrobot_kernel.history.rows import CheckpointRow, Columns, Row, StepRow, part_hashes

ROWS_AT_ONCE = 500
"""Number of rows that are read at once: between them the writer may tidy up."""

MOST_OLD_EDITS = 10_000
"""Number of edits that are kept, so that they can be undone, when their entries are thinned out."""

_FORGET_STEPS = (
    "DELETE FROM steps WHERE number <= ? AND (kind NOT IN ('edit', 'undo', 'redo') OR number < ifnull((SELECT number "
    "FROM steps WHERE kind IN ('edit', 'undo', 'redo') ORDER BY number DESC LIMIT 1 OFFSET ?), 0))"
)
_ENTRY = "seq, tick, time, author, commands, crc"
_STEP = "number, first, tick, time, author, kind, label, names, undoes, difference, touched, crc"
_HASHES = "first_tick, last_tick, hashes, crc"
_PART = "hash, body, crc"
_HEAD = "id, seq, tick, name, author, time, nodes"
_CHECKPOINT = f"{_HEAD}, body, parts, crc"
_WRITE_ENTRY = f"INSERT INTO entries ({_ENTRY}) VALUES (?,?,?,?,?,?)"
_WRITE_STEP = f"INSERT OR REPLACE INTO steps ({_STEP}) VALUES (?,?,?,?,?,?,?,?,?,?,?,?)"
NOTE = "INSERT OR REPLACE INTO about VALUES (?, ?)"
"""Statement that notes a number under a key."""


class Store(Database):
    """Journal, checkpoints and hashes of ticks in one database.

    Whatever fails in SQLite while it is written is raised as its own error; nothing of that transaction is kept then.
    What is read has all that was written; what was told to the journal and isn't written yet, `Journal.settle` writes.
    """

    def __init__(
        self,
        path: Path | None = None,
        seed: int = 0,
        power: bool = False,
        connect: Callable[[str], Connection] = connect,
        told_as: Path | None = None,
    ) -> None:
        """Open it; see `Database`."""
        super().__init__(path, seed, power, connect, told_as)
        self._columns = Columns(seed, self.damaged)

    # What is written, by one thread.

    def write(self, rows: Sequence[Row], steps: Sequence[tuple[StepRow, int]] = ()) -> None:
        """Write entries and steps as one transaction.

        With each step is the number of the one that it has drawn out, whose place it takes (0: of none). Writing one
        again changes nothing.
        """
        with self._transaction() as writer:
            writer.executemany(_WRITE_ENTRY, [self._columns.of_entry(row) for row in rows])
            for gone in (replaced for _, replaced in steps if replaced):
                writer.execute("DELETE FROM steps WHERE number = ?", (gone,))
                writer.execute("DELETE FROM touched WHERE number = ?", (gone,))
            writer.executemany(_WRITE_STEP, [self._columns.of_step(step) for step, _ in steps])
            if touched := [(uid, step.number) for step, _ in steps for uid in step.touched]:
                writer.executemany("INSERT OR IGNORE INTO touched VALUES (?,?)", touched)

    def note_life(self, life: int) -> None:
        """Note the number of the kernel whose tail has what is not written here yet; 0: there is nothing."""
        with self._transaction() as writer:
            writer.execute(NOTE, ("life", life))

    @property
    def life(self) -> int:
        """Return the number of the kernel whose tail has what is not written here yet; 0 when there is nothing."""
        return self._noted("life")

    def note_tick(self, nanoseconds: int) -> None:
        """Note the length of a tick, of which all numbers of ticks are; raise KernelError when it is another one."""
        try:
            with self._transaction() as writer:
                writer.execute("INSERT OR IGNORE INTO about VALUES ('tick_nanoseconds', ?)", (nanoseconds,))
        except sqlite3.DatabaseError as error:
            raise self.damaged(str(error)) from error
        if (noted := self._noted("tick_nanoseconds")) != nanoseconds:
            raise MalformedFileError(
                f"project.json says that a tick has {nanoseconds * 1e-6:g} ms, the journal {noted * 1e-6:g} ms; put "
                "back the project.json that the journal was written with",
                file=self.told_as or "",
                tick_nanoseconds=noted,
            )

    def add_hashes(self, first_tick: int, hashes: bytes) -> None:
        """Write the hashes of ticks from a first one on, `HASH_BYTES` each."""
        with self._transaction() as writer:
            said = self._columns.of_hashes(first_tick, hashes)
            writer.execute(f"INSERT OR REPLACE INTO hashes ({_HASHES}) VALUES (?,?,?,?)", said)

    def add_checkpoint(self, row: CheckpointRow, new: Mapping[bytes, bytes]) -> int:
        """Write a checkpoint and those of its parts (by hash) that are new; return its id."""
        with self._transaction() as writer:
            parts = [self._columns.of_part(key, body) for key, body in new.items()]
            writer.executemany(f"INSERT OR IGNORE INTO parts ({_PART}) VALUES (?,?,?)", parts)
            ((id,),) = writer.execute(
                f"INSERT INTO checkpoints ({_CHECKPOINT}) VALUES (NULL,?,?,?,?,?,?,?,?,?) RETURNING id",
                self._columns.of_checkpoint(row)[1:],
            ).fetchall()
            return id

    def remove_checkpoints(self, ids: Iterable[int]) -> None:
        """Take checkpoints out, and the parts that no other one has."""
        with self._transaction() as writer:
            run = writer.execute
            gone: set[bytes] = set()
            for id in ids:
                for (blob,) in run("SELECT parts FROM checkpoints WHERE id = ?", (id,)).fetchall():
                    gone.update(part_hashes(blob))
                run("DELETE FROM checkpoints WHERE id = ?", (id,))
            for (blob,) in run("SELECT parts FROM checkpoints").fetchall():
                gone.difference_update(part_hashes(blob))
            writer.executemany("DELETE FROM parts WHERE hash = ?", [(key,) for key in gone])

    def begin_with(self, checkpoint: CheckpointRow) -> list[CheckpointRow]:
        """Delete all entries before a checkpoint; return the checkpoints before it, after which nothing is kept."""
        while self.forget(checkpoint.seq, checkpoint.tick):
            pass
        return [one for one in self.checkpoints() if one.seq < checkpoint.seq]

    def forget(self, seq: int, tick: int, most: int = 2_000) -> bool:
        """Delete at most so many of the entries up to `seq`; return whether more may be left.

        When none is left, hashes of ticks before `tick` are deleted. A checkpoint with the entry `seq` in it must be
        there.
        """
        with self._transaction() as writer:
            run = writer.execute
            (first,) = run("SELECT min(seq) FROM entries").fetchone()
            more = first is not None and first <= seq
            if first is not None and more:
                last = min(seq, first + most - 1)
                run("DELETE FROM entries WHERE seq <= ?", (last,))
                run(NOTE, ("forgotten", last))
            else:
                run(_FORGET_STEPS, (seq, MOST_OLD_EDITS))
                run("DELETE FROM touched WHERE number NOT IN (SELECT number FROM steps)")
                begun = "SELECT max(first_tick) FROM hashes WHERE first_tick <= ?"
                run(f"DELETE FROM hashes WHERE first_tick < ({begun})", (tick,))
            run("PRAGMA incremental_vacuum(512)").fetchall()
        return more

    # What is read, by any thread.

    @property
    def last_seq(self) -> int:
        """Return the number of the last entry; 0 when there was none yet."""
        found = self._all(
            "SELECT max(seq) FROM entries UNION ALL SELECT max(seq) FROM checkpoints "
            "UNION ALL SELECT value FROM about WHERE key = 'forgotten'"
        )
        return max(seq or 0 for (seq,) in found)

    @property
    def forgotten(self) -> int:
        """Return the number of the last entry that was thinned out; 0 when none was."""
        return self._noted("forgotten")

    def rows(self, since: int = 0, until: int | None = None) -> Iterator[Row]:
        """Yield the rows after the entry `since`, up to and with the entry `until` (None: the last), in their order.

        Raises KernelError (MALFORMED_FILE), which names the row, when one is damaged or missing.
        """
        since = max(since, self.forgotten)
        until = self.last_seq if until is None else until
        while since < until:
            found = self._all(
                f"SELECT {_ENTRY} FROM entries WHERE seq > ? AND seq <= ? ORDER BY seq LIMIT {ROWS_AT_ONCE}",
                since,
                until,
            )
            for one in found:
                if one[0] != since + 1:
                    break
                yield self._columns.entry(one)
                since += 1
            else:
                if found:
                    continue
            raise self.damaged(f"the entry {since + 1} is missing")

    def step(self, number: int) -> StepRow | None:
        """Return the step that begins or ends with an entry, None when it isn't kept; raise KernelError for damage."""
        found = self._all(f"SELECT {_STEP} FROM steps WHERE number = ? OR first = ?", number, number)
        return self._columns.step(found[0]) if found else None

    def steps(self, where: str = "1", values: Sequence[object] = (), before: int | None = None) -> Iterator[StepRow]:
        """Yield the steps for which a condition of SQL on the columns of `steps` holds, newest first.

        Those with smaller numbers than `before`. `where` is the kernel's own text; what clients say is in `values`.
        Raises KernelError when one is damaged.
        """
        sql = f"SELECT {_STEP} FROM steps WHERE number < ? AND {where} ORDER BY number DESC LIMIT ?"
        at = before if before is not None else 2**62
        most = 4  # whoever undoes wants the newest one
        while found := self._all(sql, at, *values, most):
            yield from map(self._columns.step, found)
            at = found[-1][0]
            most = min(4 * most, ROWS_AT_ONCE)

    def checkpoints(self) -> list[CheckpointRow]:
        """Return all checkpoints without their bodies, oldest first."""
        return [CheckpointRow(*one) for one in self._all(f"SELECT {_HEAD} FROM checkpoints ORDER BY seq, id")]

    def checkpoint(self, id: int) -> CheckpointRow | None:
        """Return a checkpoint, or None when there is none; raise KernelError (MALFORMED_FILE) when it is damaged."""
        found = self._all(f"SELECT {_CHECKPOINT} FROM checkpoints WHERE id = ?", id)
        return self._columns.checkpoint(found[0]) if found else None

    def parts(self, keys: Sequence[bytes]) -> list[bytes]:
        """Return the bodies of parts by their hashes; raise KernelError when one is missing or damaged."""
        found = []
        for key in keys:
            columns = self._all(f"SELECT {_PART} FROM parts WHERE hash = ?", key)
            if not columns:
                raise self.damaged(f"the part {key.hex()} is missing")
            found.append(self._columns.part(columns[0]))
        return found

    def hashes(self, since: int = 0) -> Iterator[tuple[int, bytes]]:
        """Yield (first tick, hashes of it and those after it) that reach the tick `since` or come after it.

        Raises KernelError (MALFORMED_FILE) when one is damaged.
        """
        at = since
        begun = self._all("SELECT max(first_tick) FROM hashes WHERE first_tick <= ?", since)[0][0]
        at = since if begun is None else begun
        while found := self._all(
            f"SELECT {_HASHES} FROM hashes WHERE first_tick >= ? ORDER BY first_tick LIMIT 100", at
        ):
            yield from ((one[0], self._columns.hashes(one)) for one in found)
            at = found[-1][0] + 1

    def entry_bytes(self, since: int) -> int:
        """Return about how many bytes the entries after one have."""
        return self._all("SELECT sum(length(commands)) FROM entries WHERE seq > ?", since)[0][0] or 0

    @property
    def last_tick(self) -> int:
        """Return the last tick of which anything was written."""
        ticks = self._all(
            "SELECT max(tick) FROM (SELECT tick FROM checkpoints UNION ALL SELECT * FROM "
            "(SELECT tick FROM entries ORDER BY seq DESC LIMIT 1))"
        )[0][0]
        last = self._all("SELECT last_tick FROM hashes ORDER BY first_tick DESC LIMIT 1")
        return max(ticks or 0, last[0][0] if last else 0)

    def check(self) -> int:
        """Look at every row; return how many entries there are. Raises KernelError, which names what is damaged."""
        self._check_pages()
        for checkpoint in self.checkpoints():
            found = self.checkpoint(checkpoint.id)
            self.parts(found.parts if found else ())
        for _ in self.hashes():
            pass
        for _ in self.steps():
            pass
        return sum(1 for _ in self.rows())

    def _noted(self, key: str) -> int:
        """Return the number that was noted under a key; 0 when none was."""
        found = self._all("SELECT value FROM about WHERE key = ?", key)
        return found[0][0] if found else 0
