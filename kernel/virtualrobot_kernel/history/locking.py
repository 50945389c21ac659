"""Lock of a file by the operating system: it ends with the process that holds it, so none is ever stale."""

from __future__ import annotations

import os
import sys

BEYOND = 1 << 20
"""Byte of the file that is locked on Windows: one that nobody writes, so that the pid before it can be read."""


def try_lock(descriptor: int) -> bool:
    """Lock an open file for this process, and return whether that went; False when another process has locked it."""
    try:
        if sys.platform == "win32":
            import msvcrt

            os.lseek(descriptor, BEYOND, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    return True
