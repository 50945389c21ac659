"""Names that nothing has: refusals of the client's own, as the kernel words them."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from virtualrobot.errors import UnknownNameError


def did_you_mean(name: str, valid: Iterable[str]) -> str:
    """Return `; did you mean 'home'?` for the valid name that is nearest, or nothing where none is near."""
    close = get_close_matches(name, list(valid), n=1)
    return f"; did you mean {close[0]!r}?" if close else ""


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return what `name` may stand for: `did you mean 'home'?`, or some of the valid names."""
    names = sorted(valid)
    close = get_close_matches(name[:100], names, n=3)
    said = ", ".join(map(repr, close or names[:8]))
    if close:
        return f"did you mean {said}?"
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return f"there {'is' if len(names) == 1 else 'are'} {said}{more}" if names else "there is none yet"


def unknown_name(what: str, name: str, valid: Iterable[str]) -> UnknownNameError:
    """Return the error for a name; `what` says what was looked for, as in `no target`."""
    names = sorted(valid)
    close = get_close_matches(name[:100], names, n=1)
    metadata = {"name": name, "nearest": next(iter(close or names), ""), "valid": "\n".join(names[:50])}
    return UnknownNameError(f"there is {what} named {name!r}; {nearest(name, names)}", metadata=metadata)
