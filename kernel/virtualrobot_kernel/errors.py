"""Errors of the kernel: a reason from one list, a sentence for people, and values for programs.

Every room of the kernel raises these; `api` turns each into one gRPC status with a `google.rpc.ErrorInfo`.
The message names the bad value and what would be right; `metadata` carries both as strings.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable
from difflib import get_close_matches
from enum import Enum
from typing import Self

NEIGHBOURS = 200
"""Number of names before and after a bad one that are searched for a similar one."""

LONGEST_NAME = 100
"""Number of a bad name's characters that are compared."""


class Reason(Enum):
    """Reason for a call's refusal; the names equal those of `ErrorReason` in the contract."""

    INVALID_ARGUMENT = "INVALID_ARGUMENT"
    UNKNOWN_NAME = "UNKNOWN_NAME"
    NAME_TAKEN = "NAME_TAKEN"
    STALE_REVISION = "STALE_REVISION"
    LIMIT_EXCEEDED = "LIMIT_EXCEEDED"
    UNREACHABLE = "UNREACHABLE"
    SINGULARITY = "SINGULARITY"
    ROBOT_BUSY = "ROBOT_BUSY"
    WRONG_STATE = "WRONG_STATE"
    MALFORMED_FILE = "MALFORMED_FILE"
    MISSING_FILE = "MISSING_FILE"
    MALFORMED_ASSET = "MALFORMED_ASSET"
    UNKNOWN_ASSET = "UNKNOWN_ASSET"
    TOO_LARGE = "TOO_LARGE"
    UNAUTHENTICATED = "UNAUTHENTICATED"
    SHUTTING_DOWN = "SHUTTING_DOWN"
    INTERNAL = "INTERNAL"
    PLUGIN_FAILED = "PLUGIN_FAILED"
    LEASED = "LEASED"
    LEASE_ENDED = "LEASE_ENDED"
    COLLISION = "COLLISION"
    PLAN_OUTDATED = "PLAN_OUTDATED"
    CONFLICT = "CONFLICT"
    ROLE_TOO_LOW = "ROLE_TOO_LOW"
    TOO_MANY_CALLS = "TOO_MANY_CALLS"
    DRIVER_FAULT = "DRIVER_FAULT"


class KernelError(Exception):
    """Refusal of a call: nothing has changed."""

    reason = Reason.INVALID_ARGUMENT

    def __init__(self, message: str, *, reason: Reason | None = None, **metadata: object) -> None:
        """Keep `message` for people and `metadata` (made strings) for programs."""
        super().__init__(message)
        if reason is not None:
            self.reason = reason
        self.metadata = {key: str(value) for key, value in metadata.items()}

    def at(self, place: str) -> Self:
        """Put `place` (file, line, element) before the message and return the error itself."""
        self.args = (f"{place}: {self}",)
        return self


class UnknownNameError(KernelError):
    """Refusal of a name that nothing has; the message lists the nearest right ones."""

    reason = Reason.UNKNOWN_NAME

    def __init__(self, kind: str, name: str, valid: Iterable[str]) -> None:
        """Name the `kind` of thing that was looked for, the bad `name` and the `valid` ones."""
        names = sorted(valid)
        # Of many names only the neighbours in the alphabet: comparing with all of them would hold up the world.
        place = bisect_left(names, name)
        neighbours = names[max(0, place - NEIGHBOURS) : place + NEIGHBOURS]
        begun = [one for one in neighbours if name and one.startswith(name)]
        close = list(dict.fromkeys((*begun, *get_close_matches(name[:LONGEST_NAME], neighbours, n=3))))[:3]
        near = close or names[:8]
        said = ", ".join(map(repr, near))
        if close:
            hint = f"did you mean {said}?"
        elif names:
            more = len(names) - len(near)
            hint = f"there {'is' if len(names) == 1 else 'are'} {said}{f' and {more} more' if more else ''}"
        else:
            hint = "there is none yet"
        super().__init__(
            f"there is no {kind} named {name!r}; {hint}",
            kind=kind,
            name=name,
            nearest=near[0] if near else "",
            valid="\n".join(names[:50]),
        )


class LimitError(KernelError):
    """Refusal of a value outside its limits; the message names the joint, the value and the limits."""

    reason = Reason.LIMIT_EXCEEDED


class MalformedFileError(KernelError):
    """Refusal of a file that says something impossible; the message starts with file and line where known."""

    reason = Reason.MALFORMED_FILE


class MissingFileError(KernelError):
    """Refusal of a file that another one names and that is nowhere; the message lists every place that was tried."""

    reason = Reason.MISSING_FILE
