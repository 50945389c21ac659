"""Memory of a process through which large messages go: what it has freed it keeps for the next one.

The C library gives memory of a picture's size back to the system and asks for it anew each time, and each new page is a
fault: for a picture of 0.9 MB those take six times as long as copying it.
"""

from __future__ import annotations

import ctypes
import sys

_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8
"""Numbers of options; source: malloc.h of glibc."""

KEPT_BYTES, LARGEST_BYTES, ARENAS = 64 << 20, 32 << 20, 2
"""Free memory that is kept at most, the largest pieces (glibc takes no more), and how many arenas all threads share."""


def keep_memory() -> None:
    """Let this process keep what it frees, where its C library is glibc; elsewhere nothing happens."""
    if sys.platform != "linux":
        return
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:  # musl has none
        mallopt(_ARENA_MAX, ARENAS)
        mallopt(_MMAP_THRESHOLD, LARGEST_BYTES)
        mallopt(_TRIM_THRESHOLD, KEPT_BYTES)
