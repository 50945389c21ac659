"""Lines that objects show of themselves at a prompt: one to five."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from virtualrobot.errors import VirtualRobotError

MOST_NAMED = 8
"""Largest number of names in a line."""


def told(title: str, say: Callable[[], str]) -> str:
    """Return a line of what is said; where the kernel cannot be asked, why: a prompt or debugger must get a line."""
    try:
        words = say()
    except VirtualRobotError as error:
        words = str(error)
    return f"<{title}: {words}>"


def listed(words: Iterable[str], none: str = "none") -> str:
    """Return the first words with commas between them, and how many there are besides; `none` where there is none."""
    every = list(words)
    more = f" and {len(every) - MOST_NAMED} more" if len(every) > MOST_NAMED else ""
    return (", ".join(every[:MOST_NAMED]) + more) if every else none
