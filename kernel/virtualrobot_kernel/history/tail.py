"""Tail of the journal: entries that are not in its database yet, in two files by turns, mapped into memory.

What is written into them survives the end of the process, and takes no call of the system. While the entries of one
file are brought into the database, new ones go to the other; then the first one is free again.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import struct
import sys
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

from virtualrobot_kernel.history.folder import TAIL
from virtualrobot_kernel.history.rows import Row
from virtualrobot_kernel.whole_files import sync_folder

BYTES = 1024 * 1024
"""Size of a file at first; it doubles where that is too little."""

MOST_BYTES = 8 * BYTES
"""Greatest size of a file that is free."""

MAGIC = b"VRtl"
END = bytes(8)
"""Bytes after the last entry: what follows them was written in an earlier turn."""

_HEAD = struct.Struct("<4sI")
_ENTRY = struct.Struct("<IIqqd")


class MappedFile:
    """File that is mapped into memory, without holes: they would end the process where a disk is full."""

    def __init__(self, path: Path, size: int) -> None:
        """Open or make the file, and give it a size; raise OSError."""
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o600)
        try:
            self._map = self._mapped(size)
        except BaseException:
            os.close(self._descriptor)
            raise
        self.size = size

    def resize(self, size: int) -> None:
        """Change the size; raise OSError, and leave it, when there is no room."""
        larger = self._mapped(size) if size > self.size else None
        self._map.close()
        if larger is None:
            os.ftruncate(self._descriptor, size)
            larger = self._mapped(size)
        self._map, self.size = larger, size

    def write(self, place: int, data: bytes) -> None:
        """Write bytes, all of them within the size."""
        self._map[place : place + len(data)] = data

    def sync(self) -> None:
        """Return once all that was written survives a loss of power; raise OSError."""
        if sys.platform != "linux":  # there the file has what its map has
            self._map.flush()
        getattr(os, "fdatasync", os.fsync)(self._descriptor)

    def close(self) -> None:
        """Close the file."""
        self._map.close()
        os.close(self._descriptor)

    def _mapped(self, size: int) -> mmap.mmap:
        has = os.lseek(self._descriptor, 0, os.SEEK_END)
        while has < size:
            has += os.write(self._descriptor, bytes(size - has))
        return mmap.mmap(self._descriptor, size)


class Tail:
    """Tail that is written: by one thread at a time, and `sync` by any."""

    def __init__(
        self, folder: Path, seed: int, power: bool = False, opened: Callable[[Path, int], MappedFile] = MappedFile
    ) -> None:
        """Prepare for the files in a folder; nothing is written, or overwritten, before `begin`.

        Args:
            folder: where the files lie.
            seed: the folder's number, with which checksums begin.
            power: whether what is synced survives a loss of power from the first entry on.
            opened: opens a file.
        """
        self._folder, self._folder_seed, self._power, self._opened = folder, seed, power, opened
        self._seed = 0
        self._files: tuple[MappedFile, ...] = ()
        self._unsynced: set[MappedFile] = set()
        self._active = self._place = 0
        self._other_is_free = False

    @property
    def is_begun(self) -> bool:
        """Return whether entries can be appended."""
        return bool(self._files)

    def begin(self, new_life: Callable[[], int]) -> None:
        """Open the files, whose entries are all in the database by now; raise OSError.

        `new_life` notes and returns a number that no kernel on this folder had before: entries with another one are
        none, since their numbers may be given once more where power was lost.
        """
        files: list[MappedFile] = []
        try:
            for name in TAIL:
                files.append(self._opened(self._folder / name, BYTES))
                files[-1].write(0, END)
                if self._power:
                    files[-1].sync()
            if self._power:
                sync_folder(self._folder)
            self._seed = _seed_of(self._folder_seed, new_life())
        except BaseException:
            for file in files:
                file.close()
            raise
        self._active, self._place, self._other_is_free = 0, 0, True
        self._files = tuple(files)

    def append(self, row: Row) -> None:
        """Write an entry after all others; raise OSError, and leave all as it is, when there is no room."""
        if not self._files:
            raise OSError("its last entries are not in the database yet")
        data = _frame(row, self._seed)
        file, end = self._files[self._active], self._place + len(data)
        if end + len(END) > file.size:
            file.resize(max(2 * file.size, end + len(END)))
        file.write(self._place, data + END)
        self._place = end
        self._unsynced.add(file)

    def turn(self) -> None:
        """Append to the other file from now on, if it is free."""
        if self._other_is_free:
            self._active, self._place, self._other_is_free = 1 - self._active, 0, False

    def free(self) -> None:
        """Have the other file free: all that it has is in the database."""
        if self._files and not self._other_is_free:
            other = self._files[1 - self._active]
            other.write(0, END)
            if other.size > MOST_BYTES:
                with contextlib.suppress(OSError):
                    other.resize(BYTES)
            self._other_is_free = True

    def sync(self) -> None:
        """Return once all that was appended before survives a loss of power; raise OSError."""
        for file in tuple(self._unsynced):
            self._unsynced.discard(file)
            try:
                file.sync()
            except BaseException:
                self._unsynced.add(file)
                raise

    def close(self, remove: bool) -> None:
        """Close the files; remove them where all that they have is in the database."""
        for file in self._files:
            file.close()
        for name in TAIL if self._files and remove else ():
            (self._folder / name).unlink(missing_ok=True)
        self._files = ()


def tail_rows(
    folder: Path, seed: int, life: int, after: int, told_as: Path | None = None
) -> tuple[list[Row], list[str]]:
    """Return the entries of a folder's tail that come after the number `after`, without a gap; and what is wrong there.

    Args:
        folder: where the files lie.
        seed: the folder's number.
        life: that of the kernel that wrote them; 0: it had ended, and left nothing.
        after: the number of the last entry in the database.
        told_as: the folder that warnings name, that of which this one is a copy; None: itself.

    Raises OSError when a file can't be read.
    """
    paths = [folder / name for name in TAIL]
    if not life:
        return [], []
    if not any(path.exists() for path in paths):
        return [], [f"{(told_as or folder) / TAIL[0]} is missing: what was changed last may be missing"]
    found: dict[int, Row] = {}
    warnings: list[str] = []
    for path in paths:
        name = (told_as or folder) / path.name
        data = path.read_bytes() if path.exists() else b""
        entries = list(_rows(data, _seed_of(seed, life)))
        found.update((row.seq, row) for row, _ in entries)
        place = entries[-1][1] if entries else 0
        if data[place : place + len(MAGIC)] not in (b"", END[: len(MAGIC)]):
            warnings.append(
                f"{name}: what begins at byte {place} was not written as a whole or is damaged, and is left out with "
                "what follows: what was changed last may be missing"
            )
    rows: list[Row] = []
    while (row := found.get(after + 1)) is not None:
        rows.append(row)
        after += 1
    return rows, warnings


def _seed_of(folder_seed: int, life: int) -> int:
    return zlib.crc32(life.to_bytes(8, "little"), folder_seed)


def _frame(row: Row, seed: int) -> bytes:
    author = row.author.encode()
    body = _ENTRY.pack(len(author), len(row.commands), row.seq, row.tick, row.time) + author + row.commands
    return _HEAD.pack(MAGIC, zlib.crc32(body, seed)) + body


def _rows(data: bytes, seed: int) -> Iterator[tuple[Row, int]]:
    """Yield entries, each with the place where the next one begins, up to one that isn't whole."""
    place = 0
    while data[place : place + len(MAGIC)] == MAGIC and len(data) - place >= _HEAD.size + _ENTRY.size:
        _, crc = _HEAD.unpack_from(data, place)
        begin = place + _HEAD.size
        author_bytes, command_bytes, seq, tick, time = _ENTRY.unpack_from(data, begin)
        author = begin + _ENTRY.size
        commands = author + author_bytes
        place = commands + command_bytes
        if place > len(data) or zlib.crc32(data[begin:place], seed) != crc:
            return
        yield Row(seq, tick, time, data[author:commands].decode(), data[commands:place]), place
