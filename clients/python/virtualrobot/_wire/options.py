"""Options: keywords that several methods share, as typed dictionaries."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches


def check_options(options: Mapping[str, object], kind: type, what: str) -> None:
    """Raise TypeError for an option that is not of this kind; Python's own would name a function nobody has called."""
    known: frozenset[str] = kind.__optional_keys__  # pyright: ignore[reportAttributeAccessIssue] of a TypedDict
    for name in options:
        if name not in known:
            near = [one for one in sorted(known) if name in one or one in name] or get_close_matches(name, known, 1)
            meant = f"did you mean {near[0]!r}? " if near else ""
            raise TypeError(f"there is no option {name!r}; {meant}{what} takes {', '.join(sorted(known))}")
