"""Languages as an editor sees them: what a text means at its places."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Protocol

from virtualrobot_apps.languages.core.diagnostics import Diagnostic
from virtualrobot_apps.languages.core.source import Source


class SymbolKind(IntEnum):
    """Kinds of symbols that are used here, by the numbers of the Language Server Protocol 3.17."""

    MODULE = 2
    FUNCTION = 12
    VARIABLE = 13
    CONSTANT = 14
    EVENT = 24
    STRUCT = 23
    TYPE = 26


class ItemKind(IntEnum):
    """Kinds of suggestions that are used here, by the numbers of the Language Server Protocol 3.17."""

    FUNCTION = 3
    FIELD = 5
    VARIABLE = 6
    PROPERTY = 10
    KEYWORD = 14
    CONSTANT = 21
    STRUCT = 22


@dataclass(frozen=True, slots=True)
class Spot:
    """A piece of a source."""

    source: Source
    begin: int
    end: int


@dataclass(frozen=True, slots=True)
class Item:
    """A suggestion of a word that can stand somewhere."""

    label: str
    kind: ItemKind
    detail: str = ""
    told: str = ""


@dataclass(slots=True)
class Symbol:
    """A declaration in a source: begin and end of it and of its name, and the declarations within."""

    name: str
    kind: SymbolKind
    begin: int
    end: int
    name_begin: int
    detail: str = ""
    within: list[Symbol] = field(default_factory=list)


class Analysis(Protocol):
    """Meaning of one text, alone or with others."""

    diagnostics: list[Diagnostic]

    def hover(self, at: int) -> str:
        """Return what is known of the word at a place, in Markdown, or nothing."""
        ...

    def definition(self, at: int) -> Spot | None:
        """Return the name in the declaration of what the word at a place stands for."""
        ...

    def completion(self, at: int) -> list[Item]:
        """Return the words that can stand at a place."""
        ...

    def symbols(self) -> list[Symbol]:
        """Return the declarations of the text."""
        ...


@dataclass(frozen=True, slots=True)
class Language:
    """A language.

    Attributes:
        name: as editors call it.
        endings: how its files end, in small letters.
        analyze: returns what a source means; it is given the sources of its language beside it.
        formatted: lays a source out, or raises ProgramError.
        beside: whether sources of one folder can be one program.
    """

    name: str
    endings: tuple[str, ...]
    analyze: Callable[[Source, Sequence[Source]], Analysis]
    formatted: Callable[[Source], str]
    beside: bool = False
