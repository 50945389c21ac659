"""Project folder: who uses it, what it was written with, and where its files lie.

`project.json` has its form, id, length of a tick, scene, and the versions that wrote it last; `lock` the process that
uses it; `journal.db` the journal and the checkpoints (SQLite); `tail.0` and `tail.1`, while a kernel runs or was
killed, the entries that are not in there yet; `last_tick` how far time has come; `assets/` the files
of the world by the SHA-256 of their bytes; `tokens.json` the tokens that were made for it; `kernel.log` the newest
lines of the logs of its kernels.
"""

from __future__ import annotations

import json
import os
import platform
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from virtualrobot_kernel.errors import KernelError, MalformedFileError, MissingFileError, Reason
from virtualrobot_kernel.history.locking import try_lock
from virtualrobot_kernel.whole_files import write_whole

FORMAT = 1
"""Number of the form in which folders are written."""

PROJECT = "project.json"
LOCK = "lock"
JOURNAL = "journal.db"
LAST_TICK = "last_tick"
ASSETS = "assets"
TAIL = ("tail.0", "tail.1")
TOKENS = "tokens.json"
LOG = "kernel.log"

IN_MEMORY_SEED = 0
"""Number with which checksums begin where there is no folder."""

NANOSECONDS = 4_000_000
"""Length of a tick (ns) in a new folder, when nobody says another one."""


@dataclass(frozen=True, slots=True)
class Project:
    """Description of a folder: its random id, its ticks (ns), its scene's name, the versions that wrote it last."""

    id: str
    tick_nanoseconds: int
    scene: str = ""
    versions: Mapping[str, str] | None = None

    @property
    def seed(self) -> int:
        """Return the number with which checksums of this folder begin: zeros and rows of others never pass."""
        return int(self.id, 16)


class Folder:
    """Project folder that this process alone uses until `close`.

    Attributes:
        path: where it is.
        project: its description.
        is_new: whether it was empty.
        written_with: the versions that wrote it before, by name; those of now when it is new.
    """

    def __init__(self, path: Path, tick_nanoseconds: int | None = None) -> None:
        """Open a folder, or make it when it isn't there; its parent must be.

        Args:
            path: the folder.
            tick_nanoseconds: the length of a tick that is wanted; None: that of the folder, or the usual one.

        Raises:
            KernelError: when it cannot be written, another kernel uses it, it holds something else, or a newer version
                or another length of ticks was used to write it. Nothing has changed then.
        """
        self.path = path
        self._lock = -1
        self._make()
        self._lock = take_folder(path)
        try:
            self.is_new = not (path / PROJECT).exists()
            if self.is_new:
                self._check_empty()
                self.project = Project(secrets.token_hex(4), tick_nanoseconds or NANOSECONDS)
            else:
                self.project = read_project(path, tick_nanoseconds)
                check_journal(path)
            self.written_with: Mapping[str, str] = self.project.versions or versions()
            self._write(replace(self.project, versions=versions()))
        except BaseException:
            self.close()
            raise

    def name_scene(self, name: str) -> None:
        """Note which scene file the world began with."""
        self._write(replace(self.project, scene=name))

    def changed_versions(self) -> str:
        """Return in words what has another version than when the folder was written; "" when nothing has."""
        return changed_since(self.written_with)

    def close(self) -> None:
        """Let others use the folder."""
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1

    def _make(self) -> None:
        if self.path.exists() and not self.path.is_dir():
            raise KernelError(f"{self.path} is a file; a project needs a folder", path=self.path)
        try:
            self.path.mkdir(exist_ok=True)
        except FileNotFoundError as error:
            raise KernelError(
                f"cannot make the folder {self.path}: there is no {self.path.parent}", path=self.path
            ) from error
        except OSError as error:
            raise _unwritable(self.path, error) from error

    def _check_empty(self) -> None:
        others = sorted(one.name for one in self.path.iterdir() if one.name not in (LOCK, f"{PROJECT}.new"))
        if JOURNAL in others:
            raise MalformedFileError(
                f"{self.path} has a {JOURNAL} and no {PROJECT}, which says how to read it; put that back",
                path=self.path,
            )
        if others:
            raise KernelError(
                f"{self.path} is no project and not empty, it has {others[0]!r}; give a new or an empty folder",
                path=self.path,
            )

    def _write(self, project: Project) -> None:
        """Replace the description as a whole: a crash leaves the one before or this one."""
        self.project = project
        try:
            write_whole(self.path / PROJECT, project_text(project).encode(), sync=True)
        except OSError as error:
            raise _unwritable(self.path, error) from error


def take_folder(path: Path) -> int:
    """Lock a folder, and write down by whom; return the descriptor that holds the lock until it is closed.

    Raises KernelError when another process has it, or it can't be written.
    """
    lock = -1
    try:
        lock = os.open(path / LOCK, os.O_RDWR | os.O_CREAT, 0o600)
        if not try_lock(lock):
            os.lseek(lock, 0, os.SEEK_SET)
            holder = os.read(lock, 32).decode("ascii", "replace").strip() or "unknown"
            raise KernelError(
                f"another kernel uses the folder {path}, the process {holder}; end it, or take another folder",
                reason=Reason.WRONG_STATE,
                path=path,
                pid=holder,
            )
        os.ftruncate(lock, 0)
        os.lseek(lock, 0, os.SEEK_SET)
        os.write(lock, f"{os.getpid()}\n".encode())
        return lock
    except BaseException as error:
        if lock >= 0:
            os.close(lock)
        if isinstance(error, OSError):
            raise _unwritable(path, error) from error
        raise


def _unwritable(path: Path, error: OSError) -> KernelError:
    return KernelError(f"cannot write in the folder {path}: {error.strerror or error}", path=path)


def project_text(project: Project) -> str:
    """Return a description as a folder has it."""
    said = {
        "format": FORMAT,
        "id": project.id,
        "tick_nanoseconds": project.tick_nanoseconds,
        "scene": project.scene,
        "versions": dict(project.versions or {}),
    }
    return json.dumps(said, indent=2) + "\n"


def read_project(path: Path, tick_nanoseconds: int | None = None) -> Project:
    """Return the description of a folder.

    Raises KernelError when it is damaged, when a newer version wrote it, and when it has ticks of another length than
    `tick_nanoseconds` (None: any).
    """
    place = path / PROJECT
    try:
        said: Any = json.loads(place.read_text("utf-8"))
        form = said["format"]
        if isinstance(form, int) and form > FORMAT:
            raise KernelError(
                f"{path} was written by a newer version, in form {form}; this one knows {FORMAT}. Use that "
                "version, or another folder",
                reason=Reason.WRONG_STATE,
                path=path,
                format=form,
                known_format=FORMAT,
            )
        project = Project(said["id"], said["tick_nanoseconds"], said["scene"], dict(said["versions"]))
        sound = form == FORMAT and len(bytes.fromhex(project.id)) == 4 and project.tick_nanoseconds > 0
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise MalformedFileError(f"{place} is damaged, {_damage(error)}; put back a copy of it", file=place) from error
    if not sound:
        raise MalformedFileError(f"{place} is damaged, it says what no kernel writes; put back a copy", file=place)
    if tick_nanoseconds not in (None, project.tick_nanoseconds):
        raise KernelError(
            f"{path} was written with ticks of {project.tick_nanoseconds * 1e-6:g} ms, not of "
            f"{(tick_nanoseconds or 0) * 1e-6:g} ms; leave the length out, or take another folder",
            path=path,
            tick_nanoseconds=project.tick_nanoseconds,
        )
    return project


def _damage(error: Exception) -> str:
    """Return in words what is wrong with a description that can't be read."""
    match error:
        case json.JSONDecodeError():
            return f"it ends or breaks off at line {error.lineno}, column {error.colno}"
        case KeyError():
            return f"it has no {error.args[0]!r}"
        case OSError():
            return f"it cannot be read: {error.strerror}"
        case UnicodeError():
            return "it is no text"
    return "it says what no kernel writes"


def check_journal(path: Path) -> None:
    """Raise KernelError when a folder has no journal any more: its world would be an empty one.

    A kernel that was killed before it had made one leaves nothing else of these, and its folder is as good as new.
    """
    if (path / JOURNAL).exists():
        return
    traces = (path / LAST_TICK, path / f"{JOURNAL}-wal", *(path / name for name in TAIL))
    if any(one.exists() for one in traces) or any((path / ASSETS).glob("*")):
        raise MissingFileError(
            f"{JOURNAL} of this project is missing, which has its world and history: put {path / JOURNAL} back, or "
            "take another folder",
            file=path / JOURNAL,
        )


def versions() -> dict[str, str]:
    """Return the versions of what decides the bits of a tick, the processor among them, by name."""
    found = {"python": platform.python_version()}
    for name in ("virtualrobot", "numpy", "numba"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return {**found, "processor": processor(), "system": f"{platform.system()} {platform.machine()}"}


def changed_since(before: Mapping[str, str]) -> str:
    """Return in words what has another version now than `before`; "" when nothing has."""
    now = versions()
    return ", ".join(
        f"{name} {before.get(name, 'unknown')}, now {now[name]}" for name in now if before.get(name) != now[name]
    )


def processor() -> str:
    """Return the model of the processor as its system calls it."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
