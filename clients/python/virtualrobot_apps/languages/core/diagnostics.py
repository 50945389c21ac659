"""Diagnostics of programs: what is wrong, with file, line and column, and what would be right."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches

from virtualrobot.errors import MalformedFileError

from virtualrobot_apps.languages.core.source import Source


@dataclass(frozen=True, slots=True, order=True)
class Diagnostic:
    """A fault of a program at its place; line and column count from 1."""

    file: str
    line: int
    column: int
    message: str

    def __str__(self) -> str:
        """Return it as compilers do: `file:line:column: message`."""
        return f"{self.file}:{self.line}:{self.column}: {self.message}"


class Diagnostics:
    """Diagnostics of several sources, as they are found; of one place only the first is kept."""

    def __init__(self) -> None:
        """Begin without any."""
        self._found: dict[tuple[str, int], Diagnostic] = {}

    def add(self, source: Source, at: int, message: str) -> None:
        """Add a fault at a place of a source."""
        line, column = source.line(at), source.column(at)
        self._found.setdefault((source.file, at), Diagnostic(source.file, line, column, message))

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._found)

    def sorted(self) -> list[Diagnostic]:
        """Return all, by file, line and column."""
        return sorted(self._found.values())


class ProgramError(MalformedFileError):
    """A program that can't be run as it is; `diagnostics` has all that was found, and the message the first of it."""

    def __init__(self, diagnostics: list[Diagnostic]) -> None:
        """Tell of diagnostics, of which there is one at least."""
        first = diagnostics[0]
        more = f" (and {len(diagnostics) - 1} more)" if len(diagnostics) > 1 else ""
        super().__init__(f"{first}{more}", metadata={"file": first.file, "line": str(first.line)})
        self.diagnostics = diagnostics


def did_you_mean(name: str, known: Iterable[str], alike: float = 0.7) -> str:
    """Return `; did you mean 'x'?` where a known name is so much `alike` whatever the case, and else nothing."""
    by_lower = {one.lower(): one for one in known}
    near = get_close_matches(name.lower(), by_lower, n=1, cutoff=alike)
    return f"; did you mean {by_lower[near[0]]!r}?" if near else ""
