"""Files written as a whole: others see the one before or the new one, whenever the process ends."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def write_whole(path: Path, data: bytes, sync: bool = False, mode: int = 0o666) -> None:
    """Replace a file, or make it; one writer at a time. What fails is raised as OSError, and leaves the one before.

    Args:
        path: the file.
        data: its bytes.
        sync: whether it survives a loss of power once this returns.
        mode: its permissions, less what the process leaves out.
    """
    new = path.with_name(f"{path.name}.new")
    try:
        new.unlink(missing_ok=True)
        with open(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), mode), "wb") as file:
            file.write(data)
            if sync:
                file.flush()
                os.fsync(file.fileno())
        os.replace(new, path)
    except OSError:
        new.unlink(missing_ok=True)
        raise
    if sync:
        sync_folder(path.parent)


def sync_folder(path: Path) -> None:
    """Return once the names of a folder's files survive a loss of power."""
    if sys.platform != "win32":
        folder = os.open(path, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
