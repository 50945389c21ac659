"""Store of the history: one SQLite database, in a file or in memory, whose rows carry checksums.

Bytes in, bytes out: what they say is the codec's. One thread writes; any thread may read.
"""

from __future__ import annotations

import sqlite3
import struct
import threading
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from virtualrobot_kernel.errors import KernelError, MalformedFileError, Reason
from virtualrobot_kernel.history.pages import FRAME_BYTES, HEAD, PAGE_BYTES, wal_frames

FORMAT = 1
"""Number of the tables' form, the database's `user_version`."""

ROWS_AT_ONCE = 500
"""Number of rows that are read at once: between them the writer may tidy up."""

QUICK_CHECK_BYTES = 256 * 1024 * 1024
"""Greatest size of a database that is looked through as a whole when it is opened."""

LEAST_PACKED = 500
"""Number of bytes from which they are made smaller."""

MOST_OLD_EDITS = 10_000
"""Number of edits that are kept, so that they can be undone, when their entries are thinned out."""

_FORGET_STEPS = (
    "DELETE FROM steps WHERE number <= ? AND (kind NOT IN ('edit', 'undo', 'redo') OR number < ifnull((SELECT number "
    "FROM steps WHERE kind IN ('edit', 'undo', 'redo') ORDER BY number DESC LIMIT 1 OFFSET ?), 0))"
)

USER_VERSION = 60
"""Place of the number of its form in a database's head."""

MOST_FRAMES = 4096
"""Number of pages beside the database from which the writer waits until they are brought into it."""

UNSOUND = (TypeError, AttributeError, ValueError, OverflowError, struct.error, zlib.error)
"""Errors that the check of a damaged row may come to, before its checksum is compared."""

RARE_STEPS = "kind NOT IN ('signal', 'motion', 'other')"
"""Condition of the steps that have an index, which a query has to repeat: of others there are as many as calls."""

_TABLES = (
    "CREATE TABLE about (key TEXT PRIMARY KEY, value) WITHOUT ROWID",
    "CREATE TABLE entries (seq INTEGER PRIMARY KEY, tick INTEGER, time REAL, author TEXT, commands BLOB, crc INTEGER)",
    "CREATE TABLE steps (number INTEGER PRIMARY KEY, first INTEGER, tick INTEGER, time REAL, author TEXT, kind TEXT, "
    "label TEXT, names TEXT, undoes INTEGER, difference BLOB, touched BLOB, crc INTEGER)",
    f"CREATE INDEX rare_steps ON steps (kind, number) WHERE {RARE_STEPS}",
    "CREATE INDEX steps_by_first ON steps (first)",
    "CREATE TABLE touched (uid INTEGER, number INTEGER, PRIMARY KEY (uid, number)) WITHOUT ROWID",
    "CREATE TABLE checkpoints (id INTEGER PRIMARY KEY AUTOINCREMENT, seq INTEGER, tick INTEGER, name TEXT, "
    "author TEXT, time REAL, nodes INTEGER, body BLOB, parts BLOB, crc INTEGER)",
    "CREATE TABLE parts (hash BLOB PRIMARY KEY, body BLOB, crc INTEGER)",
    "CREATE TABLE hashes (first_tick INTEGER PRIMARY KEY, last_tick INTEGER, hashes BLOB, crc INTEGER)",
)
_ENTRY = "seq, tick, time, author, commands, crc"
_STEP = "number, first, tick, time, author, kind, label, names, undoes, difference, touched, crc"
_WRITE_ENTRY = f"INSERT INTO entries ({_ENTRY}) VALUES (?,?,?,?,?,?)"
_WRITE_STEP = f"INSERT OR REPLACE INTO steps ({_STEP}) VALUES (?,?,?,?,?,?,?,?,?,?,?,?)"
_HASHES = "first_tick, last_tick, hashes, crc"
_HEAD = "id, seq, tick, name, author, time, nodes"
_CHECKPOINT = f"{_HEAD}, body, parts, crc"

PART_HASH_BYTES = 16
"""Length of a part's hash."""

HASH_BYTES = 8
"""Length of the hash of a tick."""


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """Row of the journal: a batch that was applied.

    Attributes:
        seq: its number, from 1, without gaps: the order of truth.
        tick: the number of ticks before it.
        time: of the wall clock, for people: seconds since 1970.
        author: who gave it.
        commands: the encoded commands.
    """

    seq: int
    tick: int
    time: float
    author: str
    commands: bytes


@dataclass(frozen=True, slots=True, eq=False)
class StepRow:
    """Row of a step: what was done, as people see it.

    Attributes:
        number: of its last entry.
        first: number of its first entry.
        tick: the number of ticks before it.
        time: of the wall clock, seconds since 1970.
        author: who did it.
        kind: what it is.
        label: what was done, in words.
        names: names of nodes that it was about, each with its uid.
        undoes: number of the step that it took back; 0 for none.
        difference: the encoded difference that it made.
        touched: the nodes (uids) that it was about.
    """

    number: int
    first: int
    tick: int
    time: float
    author: str
    kind: str
    label: str
    names: tuple[tuple[int, str], ...]
    undoes: int
    difference: bytes
    touched: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class CheckpointRow:
    """World at a moment.

    Attributes:
        id: its number; 0 until it has one.
        seq: number of the last entry that it has in it.
        tick: its tick.
        name: as people know it; "" for those that only replays begin from.
        author: who made it.
        time: when, in seconds since 1970.
        nodes: how many it has.
        body: the encoded world, without its parts.
        parts: their hashes.
    """

    id: int
    seq: int
    tick: int
    name: str
    author: str
    time: float
    nodes: int
    body: bytes = b""
    parts: tuple[bytes, ...] = ()


Connection = Any
"""Connection of `sqlite3`, or of anything else with its `execute`, `executemany` and `close`."""


def connect(path: str) -> Connection:
    """Return a connection to a database that commits by itself, for any thread."""
    made = sqlite3.connect(path, isolation_level=None, check_same_thread=False, timeout=10.0, cached_statements=256)
    made.text_factory = lambda text: text.decode("utf-8", "surrogateescape")  # checksums find what is damaged
    return made


class Store:
    """Journal, checkpoints and hashes of ticks in one database.

    Whatever fails in SQLite while it is written is raised as its own error; nothing of that transaction is kept then.
    """

    def __init__(
        self,
        path: Path | None = None,
        seed: int = 0,
        power: bool = False,
        connect: Callable[[str], Connection] = connect,
    ) -> None:
        """Open the database at `path`, or make it; None: one in memory.

        Args:
            path: the file. Beside it SQLite keeps two more while it is open, `-wal` and `-shm`.
            seed: the number with which checksums begin, the folder's own.
            power: whether each transaction is safe from a loss of power, too, not only from the end of the process.
            connect: makes connections.

        Raises:
            KernelError: MALFORMED_FILE when the database is damaged or another folder's, WRONG_STATE when a newer
                version wrote it.
        """
        self.path = path
        self.warnings: list[str] = []
        self.catch_up: Callable[[], None] = lambda: None
        """Has all entries written that are not yet: who reads them calls it first."""
        self._seed = seed
        self._power = power
        self._closed = False
        name = ":memory:" if path is None else str(path)
        last_commit = _last_commit(Path(f"{path}-wal")) if path else 0
        if path is not None:
            self._check_head(path, last_commit)
        try:
            self._writer = connect(name)
            self._writing = threading.RLock()
            if path is not None and last_commit:
                self._check_beside(path)
            self._prepare(path is not None, last_commit)
            self._reader, self._reading = self._writer, self._writing
            self._tidier, self._tidying = None, threading.Lock()
            if path is not None:
                self._reader, self._reading = connect(name), threading.RLock()
                self._tidier = connect(name)
                self._tidier.execute("PRAGMA synchronous=NORMAL")
        except sqlite3.DatabaseError as error:
            raise self.damaged(str(error)) from error

    def _check_head(self, path: Path, last_commit: int) -> None:
        """Raise KernelError for a file that SQLite would not take for a database: it would delete what is beside it."""
        head = b""
        if path.exists():
            with open(path, "rb") as file:
                head = file.read(len(HEAD))
        if head != HEAD and (head or last_commit):
            raise self.damaged("it does not begin as a database does")

    def _check_beside(self, path: Path) -> None:
        """Raise KernelError when all is in the write-ahead log and that can't be read; SQLite would delete it."""
        wal = Path(f"{path}-wal")
        with open(path, "rb") as file:
            file.seek(USER_VERSION)
            is_bare = file.read(4) == bytes(4)
        kept = wal.read_bytes() if is_bare else b""
        if is_bare and self._writer.execute("PRAGMA user_version").fetchone() == (0,):
            self._writer.close()
            wal.write_bytes(kept)
            raise self.damaged(f"what {wal} holds can't be read")

    def _prepare(self, is_file: bool, last_commit: int) -> None:
        run = self._writer.execute
        (found,) = run("PRAGMA user_version").fetchone()
        if found > FORMAT:
            raise KernelError(
                f"{self.path} was written by a newer version, in form {found}; this one knows {FORMAT}",
                reason=Reason.WRONG_STATE,
                file=self.path,
            )
        if found == 0:
            run(f"PRAGMA page_size={PAGE_BYTES}")
            run("PRAGMA auto_vacuum=INCREMENTAL")
        if is_file:
            run("PRAGMA journal_mode=WAL").fetchall()
            run("PRAGMA wal_autocheckpoint=0").fetchall()
        run(f"PRAGMA synchronous={'FULL' if self._power else 'NORMAL'}")
        if found == 0:
            run("BEGIN IMMEDIATE")
            for table in _TABLES:
                run(table)
            run("INSERT INTO about VALUES ('seed', ?)", (self._seed,))
            run(f"PRAGMA user_version={FORMAT}")
            run("COMMIT")
            return
        if run("SELECT value FROM about WHERE key = 'seed'").fetchone() != (self._seed,):
            raise self.damaged("it belongs to another folder")
        if is_file:
            self._check(last_commit)

    def _check(self, last_commit: int) -> None:
        """Look at what a crash or damage may have left; warn of what was written last and can't be read."""
        _, frames, _ = self._writer.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()
        if last_commit > max(frames, 0):
            self.warnings.append(
                f"{self.path}-wal: pages {max(frames, 0) + 1} to {last_commit} were not written as a whole or are "
                "damaged, and are left out: what was changed last may be missing"
            )
        (pages,) = self._writer.execute("PRAGMA page_count").fetchone()
        if pages * PAGE_BYTES <= QUICK_CHECK_BYTES:
            said = [line for (line,) in self._writer.execute("PRAGMA quick_check(3)").fetchall()]
            if said != ["ok"]:
                raise self.damaged("; ".join(said).replace("\n", " "))

    def damaged(self, what: str) -> MalformedFileError:
        """Return the error that says what is wrong with the database."""
        return MalformedFileError(
            f"{self.path or 'the journal'} is damaged: {what}; put a copy of the folder back, or "
            "have what can be read kept: virtualrobot repair FOLDER",
            file=self.path or "",
        )

    def close(self) -> None:
        """Close the database; what SQLite keeps beside it is put in, so that one file is left."""
        with self._writing, self._reading:
            if self._closed:
                return
            self._closed = True
            if self._reader is not self._writer:
                self._reader.close()
            if self._tidier is not None:
                self._tidier.close()
            self._writer.close()

    # What is written, by one thread.

    def write(self, rows: Sequence[Row], steps: Sequence[tuple[StepRow, int]] = ()) -> None:
        """Write entries and steps as one transaction.

        With each step is the number of the one that it has drawn out, whose place it takes (0: of none). Writing one
        again changes nothing.
        """
        run = self._writer.execute
        many = self._writer.executemany
        with self._writing, self._transaction():
            many(_WRITE_ENTRY, [self._entry(row) for row in rows])
            for gone in (replaced for _, replaced in steps if replaced):
                run("DELETE FROM steps WHERE number = ?", (gone,))
                run("DELETE FROM touched WHERE number = ?", (gone,))
            many(_WRITE_STEP, [self._step(step) for step, _ in steps])
            if touched := [(uid, step.number) for step, _ in steps for uid in step.touched]:
                many("INSERT OR IGNORE INTO touched VALUES (?,?)", touched)

    def note_life(self, life: int) -> None:
        """Note the number of the kernel whose tail has what is not written here yet; 0: there is nothing."""
        with self._writing:
            self._writer.execute("INSERT OR REPLACE INTO about VALUES ('life', ?)", (life,))

    @property
    def life(self) -> int:
        """Return the number of the kernel whose tail has what is not written here yet; 0 when there is nothing."""
        found = self._all("SELECT value FROM about WHERE key = 'life'")
        return found[0][0] if found else 0

    def note_tick(self, nanoseconds: int) -> None:
        """Note the length of a tick, of which all numbers of ticks are; raise KernelError when it is another one."""
        with self._writing:
            try:
                self._writer.execute("INSERT OR IGNORE INTO about VALUES ('tick_nanoseconds', ?)", (nanoseconds,))
                ((noted,),) = self._writer.execute("SELECT value FROM about WHERE key = 'tick_nanoseconds'").fetchall()
            except sqlite3.DatabaseError as error:
                raise self.damaged(str(error)) from error
        if noted != nanoseconds:
            raise MalformedFileError(
                f"project.json says that a tick has {nanoseconds * 1e-6:g} ms, the journal {noted * 1e-6:g} ms; put "
                "back the project.json that the journal was written with",
                file=self.path or "",
                tick_nanoseconds=noted,
            )

    def add_hashes(self, first_tick: int, hashes: bytes) -> None:
        """Write the hashes of ticks from a first one on, `HASH_BYTES` each."""
        with self._writing:
            last = first_tick + len(hashes) // HASH_BYTES - 1
            said = first_tick, last, _packed(hashes), self._crc(first_tick, hashes)
            self._writer.execute("INSERT OR REPLACE INTO hashes VALUES (?,?,?,?)", said)

    def add_checkpoint(self, row: CheckpointRow, new: Mapping[bytes, bytes]) -> int:
        """Write a checkpoint and those of its parts (by hash) that are new; return its id."""
        with self._writing, self._transaction():
            self._writer.executemany(
                "INSERT OR IGNORE INTO parts VALUES (?,?,?)",
                [(key, _packed(data), self._crc(len(data), key, data)) for key, data in new.items()],
            )
            ((id,),) = self._writer.execute(
                f"INSERT INTO checkpoints ({_CHECKPOINT}) VALUES (NULL,?,?,?,?,?,?,?,?,?) RETURNING id",
                self._checkpoint(row)[1:],
            ).fetchall()
            return id

    def remove_checkpoints(self, ids: Iterable[int]) -> None:
        """Take checkpoints out, and the parts that no other one has."""
        with self._writing, self._transaction():
            run = self._writer.execute
            gone: set[bytes] = set()
            for id in ids:
                for (blob,) in run("SELECT parts FROM checkpoints WHERE id = ?", (id,)).fetchall():
                    gone.update(_split(blob))
                run("DELETE FROM checkpoints WHERE id = ?", (id,))
            for (blob,) in run("SELECT parts FROM checkpoints").fetchall():
                gone.difference_update(_split(blob))
            self._writer.executemany("DELETE FROM parts WHERE hash = ?", [(key,) for key in gone])

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
        with self._writing, self._transaction():
            run = self._writer.execute
            (first,) = run("SELECT min(seq) FROM entries").fetchone()
            more = first is not None and first <= seq
            if first is not None and more:
                last = min(seq, first + most - 1)
                run("DELETE FROM entries WHERE seq <= ?", (last,))
                run("INSERT OR REPLACE INTO about VALUES ('forgotten', ?)", (last,))
            else:
                run(_FORGET_STEPS, (seq, MOST_OLD_EDITS))
                run("DELETE FROM touched WHERE number NOT IN (SELECT number FROM steps)")
                begun = "SELECT max(first_tick) FROM hashes WHERE first_tick <= ?"
                run(f"DELETE FROM hashes WHERE first_tick < ({begun})", (tick,))
            run("PRAGMA incremental_vacuum(512)").fetchall()
        return more

    def tidy(self) -> None:
        """Bring what SQLite keeps beside the database into it; what was written before survives a loss of power then.

        Others write meanwhile: not in the way of the writer, unless it never pauses.
        """
        if self._tidier is None:
            return
        with self._tidying:
            _, frames, moved = self._tidier.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()
            if frames > moved and frames > MOST_FRAMES:
                with self._writing:
                    self._tidier.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchall()

    @property
    def size_bytes(self) -> int:
        """Return how large the database is without its free pages."""
        with self._reading:
            (pages,) = self._reader.execute("PRAGMA page_count").fetchone()
            (free,) = self._reader.execute("PRAGMA freelist_count").fetchone()
        return (pages - free) * PAGE_BYTES

    # What is saved from a damaged one.

    def adopt(self, found: Iterable[tuple[Any, ...]]) -> None:
        """Take rows of another store, whichever table they are of, that have the right checksum; leave out all else.

        Of two that have one place the later one counts.
        """
        tables = {
            6: ("entries", self._checked),
            12: ("steps", self._checked_step),
            10: ("checkpoints", self._checked_checkpoint),
            4: ("hashes", self._checked_hashes),
            3: ("parts", self._checked_part),
        }
        found = iter(found)
        while some := list(islice(found, ROWS_AT_ONCE)):
            with self._writing, self._transaction():
                for one in some:
                    if len(one) in tables:
                        table, check = tables[len(one)]
                        with suppress(KernelError, *UNSOUND):
                            check(one)
                            marks = ",".join("?" * len(one))
                            self._writer.execute(f"INSERT OR REPLACE INTO {table} VALUES ({marks})", one)

    def runs(self) -> list[tuple[int, int]]:
        """Return (number of the first, of the last) entry of each row of entries without a gap, in their order."""
        sql = "SELECT seq FROM entries AS here WHERE NOT EXISTS (SELECT 1 FROM entries WHERE seq = here.seq {} 1)"
        first, last = (self._all(f"{sql.format(side)} ORDER BY seq") for side in "-+")
        return [(a, b) for (a,), (b,) in zip(first, last, strict=True)]

    def keep_only(self, after: int, last: int, last_tick: int) -> None:
        """Delete entries but those after a number, up to and with a last one, and what came after that one.

        Steps and named checkpoints from before stay; hashes stay that go no further than to `last_tick`.
        """
        with self._writing, self._transaction():
            run = self._writer.execute
            run("DELETE FROM entries WHERE seq <= ? OR seq > ?", (after, last))
            run("INSERT OR REPLACE INTO about VALUES ('forgotten', ?)", (after,))
            run("DELETE FROM steps WHERE number > ?", (last,))
            # A step that was drawn out later has the same first entry, and its row has been deleted.
            later = "SELECT 1 FROM steps AS later WHERE later.first = steps.first AND later.number > steps.number"
            run(f"DELETE FROM steps WHERE EXISTS ({later})")
            run("DELETE FROM hashes WHERE last_tick > ?", (last_tick,))
            run("DELETE FROM checkpoints WHERE seq < ? AND name = ''", (after,))
            unused = {key for (key,) in run("SELECT hash FROM parts").fetchall()}
            for (blob,) in run("SELECT parts FROM checkpoints").fetchall():
                unused.difference_update(_split(blob))
            self._writer.executemany("DELETE FROM parts WHERE hash = ?", [(key,) for key in unused])
            for number, touched in run("SELECT number, touched FROM steps").fetchall():
                rows = [(uid, number) for uid in _uids(touched)]
                self._writer.executemany("INSERT OR IGNORE INTO touched VALUES (?,?)", rows)

    # What is read, by any thread.

    @property
    def last_seq(self) -> int:
        """Return the number of the last entry; 0 when there was none yet."""
        self.catch_up()
        with self._reading:
            run = self._reader.execute
            ((last,), (forgotten,)) = run(
                "SELECT max(seq) FROM entries UNION ALL SELECT max(value) FROM about WHERE key = 'forgotten'"
            ).fetchall()
            (noted,) = run("SELECT max(seq) FROM checkpoints").fetchone()
        return max(last or 0, forgotten or 0, noted or 0)

    @property
    def forgotten(self) -> int:
        """Return the number of the last entry that was thinned out; 0 when none was."""
        with self._reading:
            row = self._reader.execute("SELECT value FROM about WHERE key = 'forgotten'").fetchone()
        return row[0] if row else 0

    def rows(self, since: int = 0, until: int | None = None) -> Iterator[Row]:
        """Yield the rows after the entry `since`, up to and with the entry `until` (None: the last), in their order.

        Raises KernelError (MALFORMED_FILE), which names the row, when one is damaged or missing.
        """
        self.catch_up()
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
                yield self._checked(one)
                since += 1
            else:
                if found:
                    continue
            raise self.damaged(f"the entry {since + 1} is missing")

    def step(self, number: int) -> StepRow | None:
        """Return the step that begins or ends with an entry, None when it isn't kept; raise KernelError for damage."""
        self.catch_up()
        found = self._all(f"SELECT {_STEP} FROM steps WHERE number = ? OR first = ?", number, number)
        return self._checked_step(found[0]) if found else None

    def steps(self, where: str = "1", values: Sequence[object] = (), before: int | None = None) -> Iterator[StepRow]:
        """Yield the steps for which a condition of SQL on the columns of `steps` holds, newest first.

        Those with smaller numbers than `before`. `where` is the kernel's own text; what clients say is in `values`.
        Raises KernelError when one is damaged.
        """
        self.catch_up()
        sql = f"SELECT {_STEP} FROM steps WHERE number < ? AND {where} ORDER BY number DESC LIMIT ?"
        at = before if before is not None else 2**62
        most = 4  # whoever undoes wants the newest one
        while found := self._all(sql, at, *values, most):
            yield from map(self._checked_step, found)
            at = found[-1][0]
            most = min(4 * most, ROWS_AT_ONCE)

    def checkpoints(self) -> list[CheckpointRow]:
        """Return all checkpoints without their bodies, oldest first."""
        return [CheckpointRow(*one) for one in self._all(f"SELECT {_HEAD} FROM checkpoints ORDER BY seq, id")]

    def checkpoint(self, id: int) -> CheckpointRow | None:
        """Return a checkpoint, or None when there is none; raise KernelError (MALFORMED_FILE) when it is damaged."""
        found = self._all(f"SELECT {_CHECKPOINT} FROM checkpoints WHERE id = ?", id)
        if not found:
            return None
        return self._checked_checkpoint(found[0])

    def parts(self, keys: Sequence[bytes]) -> list[bytes]:
        """Return the bodies of parts by their hashes; raise KernelError when one is missing or damaged."""
        found = []
        for key in keys:
            row = self._all("SELECT body, crc FROM parts WHERE hash = ?", key)
            if not row:
                raise self.damaged(f"the part {key.hex()} is missing")
            found.append(self._checked_part((key, *row[0])))
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
            yield from ((one[0], self._checked_hashes(one)) for one in found)
            at = found[-1][0] + 1

    def entry_bytes(self, since: int) -> int:
        """Return about how many bytes the entries after one have."""
        self.catch_up()
        return self._all("SELECT sum(length(commands)) FROM entries WHERE seq > ?", since)[0][0] or 0

    def copy(self, path: Path) -> None:
        """Write all as it is at this moment into a new database."""
        self.catch_up()
        target = sqlite3.connect(path)
        try:
            with self._reading:
                self._reader.backup(target)
        finally:
            target.close()

    @property
    def last_tick(self) -> int:
        """Return the last tick of which anything was written."""
        self.catch_up()
        ticks = self._all(
            "SELECT max(tick) FROM (SELECT tick FROM checkpoints UNION ALL SELECT * FROM "
            "(SELECT tick FROM entries ORDER BY seq DESC LIMIT 1))"
        )[0][0]
        last = self._all("SELECT last_tick FROM hashes ORDER BY first_tick DESC LIMIT 1")
        return max(ticks or 0, last[0][0] if last else 0)

    def check(self) -> int:
        """Look at every row; return how many entries there are. Raises KernelError, which names what is damaged."""
        self.catch_up()
        said = [line for (line,) in self._all("PRAGMA integrity_check(3)")]
        if said != ["ok"]:
            raise self.damaged("; ".join(said).replace("\n", " "))
        for checkpoint in self.checkpoints():
            found = self.checkpoint(checkpoint.id)
            self.parts(found.parts if found else ())
        for _ in self.hashes():
            pass
        for _ in self.steps():
            pass
        return sum(1 for _ in self.rows())

    def _all(self, sql: str, *values: object) -> list[tuple[Any, ...]]:
        with self._reading:
            try:
                return self._reader.execute(sql, values).fetchall()
            except sqlite3.DatabaseError as error:
                raise self.damaged(str(error)) from error

    def _transaction(self) -> _Transaction:
        return _Transaction(self._writer)

    def _checked(self, one: Sequence[Any]) -> Row:
        seq, tick, time, author, commands, crc = one
        try:
            row = Row(seq, tick, time, author, _unpacked(commands))
            sound = crc == self._entry_crc(row)
        except UNSOUND:
            sound = False
        if not sound:
            raise self.damaged(f"the entry {one[0]} has a wrong checksum")
        return row

    def _checked_step(self, one: Sequence[Any]) -> StepRow:
        number, first, tick, time, author, kind, label, names, undoes, difference, touched, crc = one
        try:
            named = tuple((int(uid), name) for uid, _, name in (one.partition(" ") for one in names.splitlines()))
            uids = _uids(touched)
            changed = _unpacked(difference)
            row = StepRow(number, first, tick, time, author, kind, label, named, undoes, changed, uids)
            sound = crc == self._step(row, pack=False)[-1]
        except UNSOUND:
            sound = False
        if not sound:
            raise self.damaged(f"the step {one[0]} has a wrong checksum")
        return row

    def _checked_checkpoint(self, one: Sequence[Any]) -> CheckpointRow:
        number, seq, tick, name, author, time, nodes, body, parts, crc = one
        try:
            split = tuple(_split(parts))
            row = CheckpointRow(number, seq, tick, name, author, time, nodes, _unpacked(body), split)
            sound = crc == self._checkpoint(row, pack=False)[-1]
        except UNSOUND:
            sound = False
        if not sound:
            raise self.damaged(f"the checkpoint {one[0]} has a wrong checksum")
        return row

    def _checked_part(self, one: Sequence[Any]) -> bytes:
        key, stored, crc = one
        try:
            body = _unpacked(stored)
            sound = crc == self._crc(len(body), key, body)
        except UNSOUND:
            sound = False
        if not sound:
            raise self.damaged(f"the part {bytes(key).hex()} has a wrong checksum")
        return body

    def _checked_hashes(self, one: Sequence[Any]) -> bytes:
        first, _, stored, crc = one
        try:
            data = _unpacked(stored)
            sound = crc == self._crc(first, data)
        except UNSOUND:
            sound = False
        if not sound:
            raise self.damaged(f"the hashes from tick {first} on have a wrong checksum")
        return data

    def _entry(self, row: Row) -> tuple[Any, ...]:
        return row.seq, row.tick, row.time, row.author, _packed(row.commands), self._entry_crc(row)

    def _entry_crc(self, row: Row) -> int:
        author = row.author.encode()
        head = struct.pack("<qdI", row.tick, row.time, len(author))
        return self._crc(row.seq, head, author, row.commands)

    def _step(self, row: StepRow, pack: bool = True) -> tuple[Any, ...]:
        names = "".join(f"{uid} {name}\n" for uid, name in row.names)  # names of nodes have no line breaks
        touched = struct.pack(f"<{len(row.touched)}q", *row.touched)
        texts = [text.encode() for text in (row.author, row.kind, row.label, names)]
        head = struct.pack("<qqdqIIIII", row.first, row.tick, row.time, row.undoes, *map(len, texts), len(touched))
        crc = self._crc(row.number, head, *texts, touched, row.difference)
        said = row.number, row.first, row.tick, row.time, row.author, row.kind, row.label, names, row.undoes
        return *said, _packed(row.difference) if pack else b"", touched, crc

    def _checkpoint(self, row: CheckpointRow, pack: bool = True) -> tuple[Any, ...]:
        texts, parts = (row.name.encode(), row.author.encode()), b"".join(row.parts)
        head = struct.pack("<qdqIII", row.tick, row.time, row.nodes, *map(len, texts), len(row.body))
        crc = self._crc(row.seq, head, *texts, row.body, parts)
        said = row.id, row.seq, row.tick, row.name, row.author, row.time, row.nodes
        return *said, _packed(row.body) if pack else b"", parts, crc

    def _crc(self, number: int, *pieces: bytes) -> int:
        """Return the checksum of a number and bytes, which begins with the folder's seed."""
        crc = zlib.crc32(number.to_bytes(8, "little"), self._seed)
        for piece in pieces:
            crc = zlib.crc32(piece, crc)
        return crc


class _Transaction:
    """Transaction that is kept as a whole, or not at all when anything is raised in it."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __enter__(self) -> None:
        self._connection.execute("BEGIN IMMEDIATE")

    def __exit__(self, kind: object, *_: object) -> None:
        if kind is None:
            try:
                self._connection.execute("COMMIT")
                return
            except BaseException:
                self._roll_back()
                raise
        self._roll_back()

    def _roll_back(self) -> None:
        if self._connection.in_transaction:  # SQLite does it by itself after some errors
            self._connection.execute("ROLLBACK")


def _packed(data: bytes) -> bytes:
    """Return bytes as they are stored: as they are, or made smaller where that is worth it."""
    if len(data) < LEAST_PACKED:
        return b"\0" + data
    packed = zlib.compress(data, 1)
    return b"\1" + packed if len(packed) < 0.9 * len(data) else b"\0" + data


def _unpacked(stored: bytes) -> bytes:
    """Return what was packed; damaged bytes raise one of `UNSOUND`."""
    how = stored[:1]
    if how not in (b"\0", b"\1"):
        raise ValueError("neither packed nor not")
    return zlib.decompress(stored[1:]) if how == b"\1" else stored[1:]


def _uids(blob: bytes) -> tuple[int, ...]:
    return struct.unpack(f"<{len(blob) // 8}q", blob)


def _split(parts: bytes) -> Iterator[bytes]:
    return (parts[at : at + PART_HASH_BYTES] for at in range(0, len(parts), PART_HASH_BYTES))


def _last_commit(wal: Path) -> int:
    """Return the number of the last page in a write-ahead log that ends a transaction of its present run; 0: none."""
    ends = (frame.place for frame in wal_frames(wal)[0] if frame.is_end)
    return max((1 + place // FRAME_BYTES for place in ends), default=0)
