"""Options: keywords that several methods share, as typed dictionaries."""

from __future__ import annotations

from collections.abc import Mapping


def check_options(options: Mapping[str, object], kind: type, what: str) -> None:
    """Raise TypeError for an option that is not of this kind; Python's own would name a function nobody has called."""
    known: frozenset[str] = kind.__optional_keys__  # pyright: ignore[reportAttributeAccessIssue] of a TypedDict
    if unknown := [name for name in options if name not in known]:
        raise TypeError(f"there is no option {unknown[0]!r}; {what} takes {', '.join(sorted(known))}")
