"""Database of the history, as SQLite keeps it: how it is opened and looked at, its tables, transactions, and upkeep."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from virtualrobot_kernel.errors import KernelError, MalformedFileError, Reason
from virtualrobot_kernel.history.pages import FRAME_BYTES, HEAD, PAGE_BYTES, wal_frames

FORMAT = 1
"""Number of the tables' form, the database's `user_version`."""

QUICK_CHECK_BYTES = 256 * 1024 * 1024
"""Greatest size of a database that is looked through as a whole when it is opened."""

USER_VERSION = 60
"""Place of the number of its form in a database's head."""

MOST_FRAMES = 4096
"""Number of pages beside the database from which the writer waits until they are brought into it."""

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

Connection = Any
"""Connection of `sqlite3`, or of anything else with its `execute`, `executemany` and `close`."""


def connect(path: str) -> Connection:
    """Return a connection to a database that commits by itself, for any thread."""
    made = sqlite3.connect(path, isolation_level=None, check_same_thread=False, timeout=10.0, cached_statements=256)
    made.text_factory = lambda text: text.decode("utf-8", "surrogateescape")  # checksums find what is damaged
    return made


class Database:
    """Database in a file or in memory, which one thread at a time writes, and any thread reads.

    Attributes:
        path: the file; None for one in memory.
        warnings: in words, what a crash has left of it that can't be read.
    """

    def __init__(
        self,
        path: Path | None = None,
        seed: int = 0,
        power: bool = False,
        connect: Callable[[str], Connection] = connect,
        told_as: Path | None = None,
    ) -> None:
        """Open the database at `path`, or make it; None: one in memory.

        Args:
            path: the file. Beside it SQLite keeps two more while it is open, `-wal` and `-shm`.
            seed: the number with which checksums begin, the folder's own.
            power: whether each transaction is safe from a loss of power, too, not only from the end of the process.
            connect: makes connections.
            told_as: the file that errors name, that of which this one is a copy; None: itself.

        Raises:
            KernelError: MALFORMED_FILE when the database is damaged or another folder's, WRONG_STATE when a newer
                version wrote it.
        """
        self.path = path
        self.told_as = told_as or path
        self.warnings: list[str] = []
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
            self._prepare(seed, power, last_commit)
            self._reader, self._reading = self._writer, self._writing
            self._tidier, self._tidying = None, threading.Lock()
            if path is not None:
                self._reader, self._reading = connect(name), threading.RLock()
                self._tidier = connect(name)
                self._tidier.execute("PRAGMA synchronous=NORMAL")
        except sqlite3.DatabaseError as error:
            raise self.damaged(str(error)) from error

    def close(self) -> None:
        """Close it; what SQLite keeps beside it is put in, so that one file is left."""
        with self._writing, self._reading:
            if self._closed:
                return
            self._closed = True
            if self._reader is not self._writer:
                self._reader.close()
            if self._tidier is not None:
                self._tidier.close()
            self._writer.close()

    def damaged(self, what: str) -> MalformedFileError:
        """Return the error that says what is wrong with it."""
        return MalformedFileError(
            f"{self.told_as or 'the journal'} is damaged: {what}; put a copy of the folder back, or have what can be "
            f"read kept: virtualrobot repair {self.told_as.parent if self.told_as else 'FOLDER'}",
            file=self.told_as or "",
        )

    @contextmanager
    def _transaction(self) -> Iterator[Connection]:
        """Give what writes; all of it is kept, or nothing when anything is raised meanwhile."""
        with self._writing:
            self._writer.execute("BEGIN IMMEDIATE")
            try:
                yield self._writer
                self._writer.execute("COMMIT")
            except BaseException:
                if self._writer.in_transaction:  # SQLite rolls back by itself after some errors
                    self._writer.execute("ROLLBACK")
                raise

    def _all(self, sql: str, *values: object) -> list[tuple[Any, ...]]:
        """Return the rows that a query finds; raise KernelError (MALFORMED_FILE) when they can't be read."""
        with self._reading:
            try:
                return self._reader.execute(sql, values).fetchall()
            except sqlite3.DatabaseError as error:
                raise self.damaged(str(error)) from error

    def _check_pages(self) -> None:
        """Look at every page; raise KernelError, which says what is damaged."""
        self._check_said(self._all("PRAGMA integrity_check(3)"))

    def copy(self, path: Path) -> None:
        """Write all as it is at this moment into a new database."""
        target = sqlite3.connect(path)
        try:
            with self._reading:
                self._reader.backup(target)
        finally:
            target.close()

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
        """Size without free pages."""
        ((pages,),), ((free,),) = self._all("PRAGMA page_count"), self._all("PRAGMA freelist_count")
        return (pages - free) * PAGE_BYTES

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

    def _prepare(self, seed: int, power: bool, last_commit: int) -> None:
        """Set how SQLite works, and make the tables, or look at those that are there."""
        run, is_file = self._writer.execute, self.path is not None
        (found,) = run("PRAGMA user_version").fetchone()
        if found > FORMAT:
            raise KernelError(
                f"{self.told_as} was written by a newer version, in form {found}; this one knows {FORMAT}",
                reason=Reason.WRONG_STATE,
                file=self.told_as,
            )
        if found == 0:
            run(f"PRAGMA page_size={PAGE_BYTES}")
            run("PRAGMA auto_vacuum=INCREMENTAL")
        if is_file:
            run("PRAGMA journal_mode=WAL").fetchall()
            run("PRAGMA wal_autocheckpoint=0").fetchall()
        run(f"PRAGMA synchronous={'FULL' if power else 'NORMAL'}")
        if found == 0:
            with self._transaction():
                for table in _TABLES:
                    run(table)
                run("INSERT INTO about VALUES ('seed', ?)", (seed,))
                run(f"PRAGMA user_version={FORMAT}")
            return
        if run("SELECT value FROM about WHERE key = 'seed'").fetchone() != (seed,):
            raise self.damaged("it belongs to another folder")
        if is_file:
            self._check(last_commit)

    def _check(self, last_commit: int) -> None:
        """Look at what a crash or damage may have left; warn of what was written last and can't be read."""
        _, frames, _ = self._writer.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()
        if last_commit > max(frames, 0):
            self.warnings.append(
                f"{self.told_as}-wal: pages {max(frames, 0) + 1} to {last_commit} were not written as a whole or are "
                "damaged, and are left out: what was changed last may be missing"
            )
        (pages,) = self._writer.execute("PRAGMA page_count").fetchone()
        if pages * PAGE_BYTES <= QUICK_CHECK_BYTES:
            self._check_said(self._writer.execute("PRAGMA quick_check(3)").fetchall())

    def _check_said(self, lines: list[tuple[Any, ...]]) -> None:
        """Raise KernelError unless SQLite has found nothing in a check."""
        if lines != [("ok",)]:
            raise self.damaged("; ".join(line for (line,) in lines).replace("\n", " "))


def _last_commit(wal: Path) -> int:
    """Return the number of the last page in a write-ahead log that ends a transaction of its present run; 0: none."""
    ends = (frame.place for frame in wal_frames(wal)[0] if frame.is_end)
    return max((1 + place // FRAME_BYTES for place in ends), default=0)
