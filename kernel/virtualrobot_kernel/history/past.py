"""Past of a project folder, to be looked at: a copy, so that the folder stays as it is, whoever uses it meanwhile."""

from __future__ import annotations

import contextlib
import logging
import shutil
import sqlite3
from pathlib import Path
from tempfile import TemporaryDirectory

from virtualrobot_kernel.errors import KernelError, MissingFileError
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.folder import (
    ASSETS,
    JOURNAL,
    LAST_TICK,
    PROJECT,
    TAIL,
    changed_since,
    check_journal,
    read_project,
)
from virtualrobot_kernel.history.last_tick import LastTick
from virtualrobot_kernel.history.replay import Replay
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.tail import tail_rows
from virtualrobot_kernel.world.change import Forward

log = logging.getLogger(__name__)


class PastFolder:
    """Copy of what a project folder has written so far.

    Attributes:
        path: the folder itself.
        copy: the folder with the copy, which `close` removes.
        project: its description.
        store: its journal and checkpoints.
        last_tick: how far its time had come.
    """

    def __init__(self, path: Path) -> None:
        """Copy what a folder has.

        Raises KernelError when there is no project, it is damaged, or a newer version wrote it.
        """
        self.path = path
        if not (path / PROJECT).is_file():
            raise MissingFileError(
                f"{path} is no project folder, it has no {PROJECT}; `virtualrobot serve --data DIR` writes one",
                path=path,
            )
        self.project = read_project(path)
        self._copies = TemporaryDirectory(prefix="virtualrobot-past-")
        self.copy = Path(self._copies.name)
        try:
            check_journal(path)
            copy_past(path, self.copy)
            self.store = Store(self.copy / JOURNAL, self.project.seed, told_as=path / JOURNAL)
            self.store.note_tick(self.project.tick_nanoseconds)
            rows, damage = tail_rows(self.copy, self.project.seed, self.store.life, self.store.last_seq, told_as=path)
            self.store.write(rows)
            self.store.warnings += damage
        except BaseException:
            self._copies.cleanup()
            raise
        last_tick = LastTick(self.copy / LAST_TICK, self.project.seed)
        self.last_tick = last_tick.read()
        last_tick.close()

    @property
    def assets(self) -> Path:
        """Folder of the assets, which nobody writes into."""
        return self.path / ASSETS

    @property
    def tick_seconds(self) -> float:
        """Length of a tick in seconds of simulation time."""
        return self.project.tick_nanoseconds * 1e-9

    @property
    def changed_versions(self) -> str:
        """Packages that have another version than when it was written, in words; empty when none has."""
        return changed_since(self.project.versions or {})

    def replay(self, forward: Forward) -> Replay:
        """Return the past from the first moment that is kept; raise KernelError when there is none."""
        for warning in self.store.warnings:
            log.warning("%s", warning)
        if changed := self.changed_versions:
            log.warning("%s was written with %s: what is replayed may differ in the last bits", self.path, changed)
        return Replay(self.store, world_codec(), self.tick_seconds, forward, self.last_tick)

    def close(self) -> None:
        """Remove the copy."""
        self.store.close()
        self._copies.cleanup()


def copy_past(path: Path, to: Path) -> None:
    """Copy description, journal and last tick of a folder, as they are at one moment, though a kernel writes them.

    Raises KernelError when they can't be read.
    """
    try:
        shutil.copyfile(path / PROJECT, to / PROJECT)
        if (path / LAST_TICK).exists():
            shutil.copyfile(path / LAST_TICK, to / LAST_TICK)
        for name in TAIL:  # before the database, into which it may go at any moment
            with contextlib.suppress(FileNotFoundError):
                shutil.copyfile(path / name, to / name)
        if not (path / JOURNAL).exists():
            raise MissingFileError(f"{path} has no {JOURNAL}: nothing was written into it yet", path=path)
        try:
            _copy_database(path / JOURNAL, to / JOURNAL)
        except sqlite3.DatabaseError:
            # A folder that can't be written, which SQLite wants to do even to read, or damage, which is told later.
            for name in (JOURNAL, f"{JOURNAL}-wal"):
                if (path / name).exists():
                    shutil.copyfile(path / name, to / name)
    except OSError as error:
        raise KernelError(f"cannot copy what {path} has: {error.strerror or error}", path=path) from error


def _copy_database(source: Path, target: Path) -> None:
    read = sqlite3.connect(f"{source.absolute().as_uri()}?mode=ro", uri=True)
    written = sqlite3.connect(target)
    try:
        read.backup(written)
    finally:
        read.close()
        written.close()
