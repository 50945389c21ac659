"""Symbols of a program: what its names stand for."""

from __future__ import annotations

from dataclasses import dataclass, field

from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.types import ATOMIC, SIGNALS, Type


@dataclass(slots=True, eq=False)
class Datum:
    """A variable, constant, persistent, parameter or loop variable, or a signal of the world.

    Attributes:
        name: as it is declared.
        type: its type.
        storage: var, pers, const, loop, in, inout or signal.
        python: the name that it has in the generated code.
        shared: whether it belongs to a module, and so outlives its routine.
        common: whether several tasks have it, as a global persistent of the same name.
        optional: whether it is a parameter that may be left out.
        referenced: whether somebody gets it as a variable.
        node: the declaration in a module that gives it its first value.
        source: where that is.
    """

    name: str
    type: Type
    storage: str
    python: str
    shared: bool = False
    common: bool = False
    optional: bool = False
    referenced: bool = False
    node: tree.Data | None = None
    source: Source | None = None

    @property
    def atomic(self) -> bool:
        """True where its value is one thing, and no list."""
        return self.type.dimensions == 0 and (self.type.name in ATOMIC or self.type.name in SIGNALS)

    @property
    def boxable(self) -> bool:
        """True where a routine has it in a list of one value, if somebody else may change it."""
        return self.atomic and self.storage not in ("inout", "pers")


@dataclass(slots=True, eq=False)
class RoutineSymbol:
    """A routine: its declaration, its parameters as data, and the name that it has in the generated code."""

    node: tree.Routine
    module: ModuleScope
    python: str
    result: Type | None = None
    parameters: list[tuple[tree.Parameter, Type]] = field(default_factory=list)
    data: list[Datum] = field(default_factory=list)


Symbol = Datum | RoutineSymbol


@dataclass(slots=True, eq=False)
class ModuleScope:
    """A module and the names that are its own."""

    module: tree.Module
    names: dict[str, Symbol] = field(default_factory=dict)
    routines: list[RoutineSymbol] = field(default_factory=list)


@dataclass(slots=True)
class Use:
    """Use of a signal: its name as first written, the types that it is used as, and the first place."""

    name: str
    types: set[str]
    source: Source
    at: int


def first_value(use: Use) -> bool | int | float:
    """Return the value that a new signal has which is used so: off, or 0 of groups and analog signals."""
    kinds = {SIGNALS[name] for name in use.types}
    return 0.0 if float in kinds else 0 if int in kinds else False
