"""Names that every program takes: letters, digits and `_ - .`, no two alike."""

from __future__ import annotations

import re
from collections.abc import Container

_FOREIGN = re.compile(r"[^A-Za-z0-9_.-]+")


def legal(name: str) -> str:
    """Return the name with an underscore for whatever is no ASCII letter, digit, `_`, `-` or `.`; never empty."""
    return _FOREIGN.sub("_", name).lstrip(".") or "_"


def unique(name: str, taken: Container[str]) -> str:
    """Return the name, with `_2`, `_3` and so on behind it while it is among the names `taken`."""
    chosen, number = name, 2
    while chosen in taken:
        chosen, number = f"{name}_{number}", number + 1
    return chosen


def listed(names: list[str], most: int = 5) -> str:
    """Return the first names for people, in quotes, and how many there are besides."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(repr(name) for name in names[:most]) + more
