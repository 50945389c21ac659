"""The errors that components raise, and those that are raised about them."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum


class ArgumentError(ValueError):
    """A component refuses what it was asked for; it is well and ready for the next call.

    The message names the bad value and what would be right. It reaches the client that asked.
    """

    def __init__(self, message: str, **metadata: object) -> None:
        """Keep `message` for people and `metadata` (made strings) for programs."""
        super().__init__(message)
        self.message = message
        self.metadata = {key: str(value) for key, value in metadata.items()}

    def __reduce__(self) -> tuple:
        """Travel between processes with the metadata."""
        return _argument_error, (type(self), self.message, self.metadata)


def _argument_error(kind: type[ArgumentError], message: str, metadata: dict[str, str]) -> ArgumentError:
    return kind(message, **metadata)


class FilesNeeded(Exception):
    """An importer cannot go on without these files; it is called again with them among its `files`."""

    def __init__(self, names: Sequence[str]) -> None:
        """Name the files as the file that is translated names them."""
        super().__init__(tuple(names))
        self.names = tuple(names)


class PluginError(Exception):
    """A plugin cannot be used; the message says why and what would be right."""


class FaultKind(Enum):
    """Kind of a component's fault."""

    RAISED = "RAISED"
    """It raised something else than an `ArgumentError`."""
    HUNG = "HUNG"
    """It did not answer within its deadline."""
    DIED = "DIED"
    """Its process ended in the middle of a call."""
    NONSENSE = "NONSENSE"
    """Its answer has a wrong type or shape, is not finite, or is untrue."""
    GREW = "GREW"
    """Its process took more memory than it may."""


class ComponentFault(Exception):
    """A component did what no component may; it is not asked again until it is made anew."""

    def __init__(self, kind: FaultKind, reason: str, details: str = "") -> None:
        """Keep what it did (`kind`), one sentence with the numbers (`reason`), and a traceback (`details`) if any."""
        super().__init__(kind, reason, details)
        self.kind, self.reason, self.details = kind, reason, details

    def __str__(self) -> str:
        """Return the sentence."""
        return self.reason
