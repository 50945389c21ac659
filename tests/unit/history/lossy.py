"""Power loss without a machine to switch off: a VFS of SQLite that notes each write, sync and deletion.

A disk after a loss of power has all that was synced before, and of what was written later any part of each file, torn
at sectors. That a file was deleted is kept: SQLite syncs the folder, and systems keep the order of what they do in it.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import apsw
import numpy as np

SECTOR = 512


@dataclass
class Disk:
    """Disk as its steps: (file, what, place, bytes)."""

    steps: list[tuple[str, str, int, bytes]] = field(default_factory=list)

    def after_loss(self, folder: Path, at: int, rng: np.random.Generator) -> None:
        """Write to a new folder what may be left when power is lost after the first `at` steps.

        What was written since the last sync of its file is there, not there, or zeros, sector by sector.
        """
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        synced = {name: i for i, (name, what, _, _) in enumerate(self.steps[:at]) if what == "sync"}
        share = rng.choice([0.0, 0.1, 0.5, 0.9, 1.0])  # of sectors that did get there
        files: dict[str, bytearray] = {}
        for i, (name, what, place, data) in enumerate(self.steps[:at]):
            file = files.setdefault(name, bytearray())
            safe = i < synced.get(name, -1)
            if what == "write":
                for start in range(0, len(data), SECTOR):
                    piece = data[start : start + SECTOR]
                    begin, end = place + start, place + start + len(piece)
                    arrived = safe or rng.random() < share
                    if arrived or rng.random() < 0.5:  # a file may have grown without its bytes
                        file.extend(bytes(max(0, end - len(file))))
                    if arrived:
                        file[begin:end] = piece
            elif what == "truncate" and (safe or rng.random() < share):
                del file[place:]
            elif what == "delete":
                del files[name]
                if synced.get(name, i) <= i:  # else it was synced when it had been made anew
                    synced.pop(name, None)
        for name, file in files.items():
            (folder / Path(name).name).write_bytes(file)


class LossyVFS(apsw.VFS):
    """File system of SQLite that notes what is done with the files of a disk."""

    def __init__(self, disk: Disk) -> None:
        """Register it under a name of its own."""
        self.disk = disk
        self.name = f"lossy-{id(disk)}"
        super().__init__(self.name, "")

    def xOpen(self, name: Any, flags: list[int]) -> _File:  # noqa: ANN401 apsw's
        """Open a file that is noted."""
        return _File(self.disk, self, name, flags)

    def xDelete(self, filename: str, syncdir: bool) -> None:
        """Delete a file and note it."""
        super().xDelete(filename, syncdir)
        self.disk.steps.append((filename, "delete", 0, b""))

    def connect(self, path: str) -> Any:  # noqa: ANN401 a connection as the store's
        """Return a connection that writes through this."""
        return apsw.Connection(path, vfs=self.name)


class _File(apsw.VFSFile):
    def __init__(self, disk: Disk, vfs: LossyVFS, name: Any, flags: list[int]) -> None:  # noqa: ANN401 apsw's
        self.steps = disk.steps
        self.path = name.filename() if isinstance(name, apsw.URIFilename) else str(name)
        super().__init__("", name, flags)

    def xWrite(self, data: Any, offset: int) -> None:  # noqa: ANN401 apsw's
        super().xWrite(data, offset)
        self.steps.append((self.path, "write", offset, bytes(data)))

    def xSync(self, flags: int) -> None:
        super().xSync(flags)
        self.steps.append((self.path, "sync", 0, b""))

    def xTruncate(self, size: int) -> None:
        super().xTruncate(size)
        self.steps.append((self.path, "truncate", size, b""))


def promised(notes: Sequence[tuple[int, int]], at: int) -> int:
    """Return the last number of notes (steps before it, number) that had been made by a step."""
    return max((number for before, number in notes if before <= at), default=0)
