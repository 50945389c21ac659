"""Progress of calls that take long, as planning and loading: a line on the terminal, or what a program makes of it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Progress:
    """Progress of a call that has taken more than half a second; told again four times a second.

    Attributes:
        what: what is waited for, in words: `planning`, `loading the model`.
        elapsed: time since the call began (s).
        detail: how far it is, in words, where the kernel tells; else empty.
        ended: whether this is the last one: the call has returned or failed.
    """

    what: str
    elapsed: float
    detail: str = ""
    ended: bool = False


OnProgress = Callable[[Progress], None]
"""Function that is called with each progress, in the thread that waits; what it raises ends the call."""


def show_progress(progress: Progress) -> None:
    """Show progress as a line of stderr that goes when the call has ended; do nothing where that is no terminal."""
    if sys.stderr is None or not sys.stderr.isatty():
        return
    told = "" if progress.ended else f"{progress.what}: {progress.elapsed:.1f} s {progress.detail}"
    sys.stderr.write(f"\r\x1b[K{told}")
    sys.stderr.flush()
