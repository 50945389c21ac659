"""Meaning of RAPID's expressions: what their names stand for, and their types."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, did_you_mean
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.predefined import CONSTANTS, VARIABLES
from virtualrobot_apps.languages.rapid.support import not_normalized
from virtualrobot_apps.languages.rapid.symbols import Datum, RoutineSymbol, Symbol, Use
from virtualrobot_apps.languages.rapid.table import BUILTINS, Builtin, lacking_names
from virtualrobot_apps.languages.rapid.types import ANY, BOOL, NUM, SIGNALS, STRING, Type, Types, fits

LACKING = lacking_names()

_POS, _ORIENT, _DNUM = Type("pos"), Type("orient"), Type("dnum")
_ARITHMETIC: dict[str, dict[tuple[Type, Type], Type]] = {
    "+": {(NUM, NUM): NUM, (_DNUM, _DNUM): _DNUM, (STRING, STRING): STRING, (_POS, _POS): _POS},
    "-": {(NUM, NUM): NUM, (_DNUM, _DNUM): _DNUM, (_POS, _POS): _POS},
    "*": {
        **{(NUM, NUM): NUM, (_DNUM, _DNUM): _DNUM, (_POS, NUM): _POS, (NUM, _POS): _POS},
        **{(_POS, _POS): _POS, (_ORIENT, _ORIENT): _ORIENT},
    },
    "/": {(NUM, NUM): NUM, (_DNUM, _DNUM): _DNUM, (_POS, NUM): _POS},
    "div": {(NUM, NUM): NUM, (_DNUM, _DNUM): _DNUM},
    "mod": {(NUM, NUM): NUM, (_DNUM, _DNUM): _DNUM},
}
"""Result of each operator by the types of its two values."""
NEARLY = 0.8
"""Likeness from which on a name of any type is hinted at."""


def predefined() -> dict[str, Symbol]:
    """Return the data that come with the language, by name in small letters."""
    data: dict[str, Symbol] = {}
    for name, (type_name, _) in CONSTANTS.items():
        data[name.lower()] = Datum(name, Type(type_name), "const", f"s_{name.lower()}", shared=True)
    for name, (storage, type_name, _) in VARIABLES.items():
        data[name.lower()] = Datum(name, Type(type_name), storage, f"s_{name.lower()}", shared=True)
    return data


@dataclass(frozen=True, slots=True)
class Taken:
    """Parameters of a routine, as calls are matched with them.

    Attributes:
        name: the routine's.
        parameters: its parameters with their types.
        by_name: their numbers, by name in small letters.
        required: the numbers of those that must be given.
        choices: for each parameter the numbers of those of which one may be given.
        lacking: arguments that are refused by name, in small letters.
    """

    name: str
    parameters: list[tuple[tree.Parameter, Type]]
    by_name: dict[str, int]
    required: list[int]
    choices: list[list[int]]
    lacking: frozenset[str]


class Meaning:
    """Meaning of expressions, in the scopes that are open."""

    def __init__(self, diagnostics: Diagnostics, signals: Iterable[str] = ()) -> None:
        """Begin without a program; `signals` are names that the world has."""
        self.diagnostics, self.types = diagnostics, Types()
        self.may_change = False
        self.predefined = predefined()
        self.globals: dict[str, Symbol] = {}
        self.scopes: list[dict[str, Symbol]] = []
        self.source = Source("")
        self.known_signals = {name.lower(): name for name in signals}
        self.uses: dict[str, Use] = {}
        self._taken: dict[int, Taken] = {}
        self._unresolved: list[tuple[Source, tree.Name, str]] = []
        self._needed: dict[int, str] = {}

    def error(self, at: int, message: str) -> Type:
        """Tell a fault; return the type that fits everything, so that nothing follows from it."""
        self.diagnostics.add(self.source, at, message)
        return ANY

    # Names.

    def symbol(self, name: str) -> Symbol | None:
        """Return what a name stands for here."""
        lower = name.lower()
        for scope in reversed(self.scopes):
            if lower in scope:
                return scope[lower]
        return self.globals.get(lower) or self.predefined.get(lower)

    def signal(self, name: tree.Name, type_name: str) -> None:
        """Take a name as that of a signal of the world."""
        lower = name.name.lower()
        use = self.uses.setdefault(lower, Use(name.name, set(), self.source, name.at))
        use.types.add(type_name)
        name.symbol = Datum(use.name, Type(type_name), "signal", f"signal_{lower}", shared=True)

    def resolve_signals(self) -> None:
        """Take names that nothing has as signals where they are used as such elsewhere; tell of the others."""
        for source, name, hint in self._unresolved:
            self.source = source
            if name.name.lower() in self.uses or name.name.lower() in self.known_signals:
                self.signal(name, "signaldi")
                if id(name) in self._needed:
                    self.error(name.at, f"{self._needed[id(name)]} must be a variable, not a value")
            else:
                self.error(name.at, f"{name.name!r} is not declared{hint}")

    def _near(self, name: str, wanted: Type | None) -> str:
        """Return a hint to a datum of the type that is wanted, or else to one that is called nearly so."""
        scopes = [self.predefined, self.globals, *self.scopes]
        here = [one for scope in scopes for one in scope.values() if isinstance(one, Datum)]
        fitting = did_you_mean(name, [one.name for one in here if one.type == wanted])
        return fitting or did_you_mean(name, [one.name for one in here], NEARLY)

    # Types.

    def type_named(self, name: str, at: int, dimensions: int = 0) -> Type:
        """Return the type of a name."""
        resolved = self.types.resolved(name)
        if resolved is None:
            return self.error(at, f"there is no type {name!r} here{did_you_mean(name, self.types.names())}")
        return Type(resolved, dimensions)

    def expect(self, expression: tree.Expression, wanted: Type, what: str) -> None:
        """Tell where an expression is of another type than is wanted; `what` begins the sentence."""
        found = self.type_of(expression, wanted)
        if not fits(found, wanted):
            self.error(expression.at, f"{what} must be {_article(wanted)}, not {_article(found)}")

    def type_of(self, node: tree.Expression, wanted: Type | None = None) -> Type:
        """Return the type of an expression, and leave in it what its names stand for.

        `wanted` says what values in brackets are of.
        """
        match node:
            case tree.Name():  # more often than all others
                return self._name(node, wanted)
            case tree.Number():
                return _DNUM if wanted == _DNUM else NUM
            case tree.Text():
                return STRING
            case tree.Truth():
                return BOOL
            case tree.Component():
                return self._component(node)
            case tree.Element():
                return self._element(node)
            case tree.Aggregate():
                return self._aggregate(node, wanted)
            case tree.Call():
                return self._function(node)
            case tree.Unary():
                return self._unary(node, wanted)
            case tree.Binary():
                return self._binary(node, wanted)

    def _name(self, node: tree.Name, wanted: Type | None) -> Type:
        found = self.symbol(node.name)
        if isinstance(found, Datum):
            node.symbol = found
            return found.type
        known = node.name.lower() in self.known_signals or node.name.lower() in self.uses
        if isinstance(found, RoutineSymbol) or (node.name.lower() in BUILTINS and not known):
            return self.error(node.at, f"{node.name!r} is a routine; a function is called with parentheses")
        if known:
            self.signal(node, "signaldi")
        else:
            self._unresolved.append((self.source, node, self._near(node.name, wanted)))
        return ANY

    def _component(self, node: tree.Component) -> Type:
        of = self.type_of(node.of)
        if of == ANY:
            return ANY
        parts = self.types.components(of.name) if not of.dimensions else []
        for index, (type_name, name) in enumerate(parts):
            if name.lower() == node.name.lower():
                node.index = index
                return Type(self.types.resolved(type_name) or "any")
        if not parts:
            return self.error(node.at, f"{_article(of)} has no components")
        names = [name for _, name in parts]
        return self.error(node.at, f"{_article(of)} has no component {node.name!r}; it has {', '.join(names)}")

    def _element(self, node: tree.Element) -> Type:
        of = self.type_of(node.of)
        for index in node.indices:
            self.expect(index, NUM, "an index")
        if of == ANY:
            return ANY
        if of.dimensions != len(node.indices):
            have = f"{of.dimensions} dimension{'s' * (of.dimensions != 1)}" if of.dimensions else "no array"
            return self.error(node.at, f"this has {len(node.indices)} indices, and what it is taken of is {have}")
        return Type(of.name)

    def _aggregate(self, node: tree.Aggregate, wanted: Type | None) -> Type:
        if wanted is None:
            return self.error(node.at, "what these values are of is not clear here; give them to a variable first")
        if wanted == ANY:
            return ANY
        if wanted.dimensions:
            inner = Type(wanted.name, wanted.dimensions - 1)
            for item in node.items:
                self.expect(item, inner, "an element here")
            return wanted
        parts = self.types.components(wanted.name)
        if not parts:
            return self.error(node.at, f"{_article(wanted)} is wanted here, and no values in brackets")
        if len(parts) != len(node.items):
            said = f"{_article(wanted)} has {len(parts)} components ({', '.join(name for _, name in parts)})"
            return self.error(node.at, f"{said}, and {len(node.items)} are given")
        for item, (type_name, name) in zip(node.items, parts, strict=True):
            self.expect(item, Type(self.types.resolved(type_name) or "any"), f"{name} of {_article(wanted)}")
            if type_name == "orient" and not self.may_change:
                self._normalized(item)
        return wanted

    def _normalized(self, node: tree.Expression) -> None:
        """Refuse an orientation of numbers that is nearly one and none; four zeros stand for one that is not known."""
        signed = [_number_of(one) for one in node.items] if isinstance(node, tree.Aggregate) else []
        numbers = [one for one in signed if one is not None]
        if len(numbers) == 4 and any(numbers) and (said := not_normalized(numbers)):
            self.error(node.at, said)

    def _unary(self, node: tree.Unary, wanted: Type | None) -> Type:
        of = self.type_of(node.operand, wanted)
        node.type = of.name
        if node.operator == "not":
            if not fits(of, BOOL):
                return self.error(node.at, f"NOT takes a bool, not {_article(of)}")
            return BOOL
        if of.dimensions or of.name not in ("num", "dnum", "pos", "any"):
            return self.error(node.at, f"{node.operator!r} takes a num, dnum or pos, not {_article(of)}")
        return of

    def _binary(self, node: tree.Binary, wanted: Type | None) -> Type:
        # Values in brackets are of the other side's type, or of the result's.
        if isinstance(node.left, tree.Aggregate):
            right = self.type_of(node.right, wanted)
            left = self.type_of(node.left, wanted if right == NUM else right)
        else:
            left = self.type_of(node.left)
            right = self.type_of(node.right, wanted if left == NUM else left)
        # A number is written alike for both types.
        if left == _DNUM and isinstance(node.right, tree.Number):
            right = _DNUM
        elif right == _DNUM and isinstance(node.left, tree.Number):
            left = _DNUM
        left, right = (NUM if one.name in SIGNALS else one for one in (left, right))
        node.types = (left.name, right.name)
        if ANY in (left, right):
            return ANY if node.operator in _ARITHMETIC else BOOL
        operator = node.operator.upper()
        if node.operator in ("and", "or", "xor"):
            return BOOL if left == right == BOOL else self._refused(node, operator, left, right)
        if node.operator in ("=", "<>"):
            return BOOL if left == right else self._refused(node, operator, left, right)
        if node.operator in _ARITHMETIC:
            found = _ARITHMETIC[node.operator].get((left, right))
            return found if found is not None else self._refused(node, operator, left, right)
        return BOOL if left == right and left in (NUM, _DNUM) else self._refused(node, operator, left, right)

    def _refused(self, node: tree.Binary, operator: str, left: Type, right: Type) -> Type:
        return self.error(node.at, f"{operator} can't take {_article(left)} and {_article(right)}")

    # Calls.

    def _function(self, node: tree.Call) -> Type:
        target = self.callee(node, "function")
        if target is None:
            for argument in node.arguments:
                if argument.value is not None and argument.condition is None:
                    self.type_of(argument.value)
            return ANY
        result = Type(self.types.resolved(target.result) or "any") if isinstance(target, Builtin) else target.result
        if not result:
            return self.error(node.at, f"{node.name!r} is no function: it has no value")
        if isinstance(target, Builtin) and not target.result:
            return self.error(node.at, f"{target.name} is an instruction, and has no value")
        self.match(node, target)
        return result

    def callee(self, node: tree.Call, kind: str) -> RoutineSymbol | Builtin | None:
        """Return the routine that is called; tell where there is none."""
        found = self.symbol(node.name)
        lower = node.name.lower()
        if isinstance(found, RoutineSymbol):
            node.target = found
        elif lower in BUILTINS and found is None:
            node.target = BUILTINS[lower]
        elif found is not None:
            self.error(node.at, f"{node.name!r} is no {kind} but data")
        elif lower in LACKING:
            self.error(node.at, f"{LACKING[lower]} can't be used here yet; see the table of what works")
        else:
            routines = [one.name for one in BUILTINS.values()]
            routines += [one.node.name for one in self.globals.values() if isinstance(one, RoutineSymbol)]
            routines += [
                one.node.name for scope in self.scopes for one in scope.values() if isinstance(one, RoutineSymbol)
            ]
            self.error(node.at, f"there is no {kind} {node.name!r}{did_you_mean(node.name, routines)}")
        return node.target

    def match(self, node: tree.Call, target: RoutineSymbol | Builtin) -> None:
        """Give the arguments of a call to the parameters of the routine, and tell what doesn't fit."""
        taken = self._taken.get(id(target))
        if taken is None:
            taken = self._taken[id(target)] = self._what_is_taken(target)
        name, parameters, by_name, required = taken.name, taken.parameters, taken.by_name, taken.required
        given: list[tree.Argument | None] = [None] * len(parameters)
        for argument in node.arguments:
            if argument.name is None:
                number = next((one for one in required if given[one] is None), None)
                if number is None:
                    self.error(argument.at, f"{name} takes {len(required)} arguments and no more; {_told(parameters)}")
                    continue
            else:
                number = by_name.get(argument.name.lower())
                if number is None:
                    if argument.name.lower() in taken.lacking:
                        self.error(argument.at, f"\\{argument.name} of {name} can't be used here yet")
                    else:
                        near = did_you_mean(argument.name, [one.name for one, _ in parameters])
                        self.error(argument.at, f"{name} has no argument {argument.name!r}{near}; {_told(parameters)}")
                    continue
            parameter, wanted = parameters[number]
            if given[number] is not None or any(given[one] is not None for one in taken.choices[number]):
                self.error(argument.at, f"{name} gets {parameter.name!r}, or what stands for it, twice")
                continue
            given[number] = argument
            self._argument(name, argument, parameter, wanted)
        missing = [parameters[number][0].name for number in required if given[number] is None]
        if missing:
            self.error(node.at, f"{name} lacks {', '.join(map(repr, missing))}; {_told(parameters)}")
        node.given = given

    def _what_is_taken(self, target: RoutineSymbol | Builtin) -> Taken:
        """Return what a routine takes."""
        if isinstance(target, Builtin):
            parameters = [
                (one, Type(self.types.resolved(one.type) or "any", one.dimensions)) for one in target.parameters
            ]
            name, lacking = target.name, target.lacking
        else:
            parameters, name, lacking = target.parameters, target.node.name, frozenset()
        numbers = range(len(parameters))
        return Taken(
            name,
            parameters,
            {one.name.lower(): number for number, (one, _) in enumerate(parameters)},
            [number for number in numbers if not parameters[number][0].optional],
            [
                [two for two in numbers if two != one and parameters[one][0].choice == parameters[two][0].choice]
                for one in numbers
            ],
            lacking,
        )

    def _argument(self, name: str, argument: tree.Argument, parameter: tree.Parameter, wanted: Type) -> None:
        what = f"{parameter.name} of {name}"
        if argument.condition is not None:
            found = self.symbol(argument.condition.name)
            if not isinstance(found, Datum) or not found.optional:
                self.error(argument.condition.at, f"{argument.condition.name!r} is no optional parameter here")
            elif not fits(found.type, wanted):
                self.error(argument.condition.at, f"{what} must be {_article(wanted)}, not {_article(found.type)}")
            else:
                argument.condition.symbol = found
                found.referenced = found.referenced or parameter.mode != "in"
            return
        if argument.value is None:
            if wanted.name != "switch":
                self.error(argument.at, f"{what} needs a value, as \\{parameter.name}:={wanted}")
            return
        if wanted.name == "switch":
            self.error(argument.at, f"{what} is a switch, and takes no value")
            return
        value = argument.value
        if wanted.name in SIGNALS and isinstance(value, tree.Name):
            found = self.symbol(value.name)
            if found is None or (isinstance(found, Datum) and found.storage == "signal"):
                self.signal(value, wanted.name)
                return
            if isinstance(found, Datum) and found.type.name in SIGNALS:
                value.symbol = found
                return
        self.expect(value, wanted, what)
        if parameter.mode != "in":
            self.reference(value, parameter.mode, what)

    def reference(self, value: tree.Expression, mode: str, what: str) -> None:
        """Look whether a value is a variable that somebody may get as one."""
        found = self.root(value)
        if found is None and isinstance(value, tree.Name) and self.symbol(value.name) is None:
            self._needed[id(value)] = what  # what it is nobody knows yet
        elif found is None:
            self.error(value.at, f"{what} must be a variable, not a value")
        elif found.storage in ("const", "loop") and mode != "pers":
            self.error(value.at, f"{what} must be a variable, and {found.name!r} can't be changed")
        elif mode == "pers" and found.storage not in ("pers", "inout"):
            self.error(value.at, f"{what} must be a persistent (PERS), and {found.name!r} is none")
        else:
            found.referenced = True

    def root(self, value: tree.Expression) -> Datum | None:
        """Return the datum that a variable, a component or an element is of; None where it is something else."""
        while isinstance(value, tree.Component | tree.Element):
            value = value.of
        return value.symbol if isinstance(value, tree.Name) and isinstance(value.symbol, Datum) else None


def _told(parameters: list[tuple[tree.Parameter, Type]]) -> str:
    """Return parameters in words."""
    if not parameters:
        return "it takes none"
    return "it takes " + ", ".join(("\\" if one.optional else "") + one.name for one, _ in parameters)


def _number_of(node: tree.Expression) -> float | None:
    """Return the number that is written, with its sign; None for anything else."""
    if isinstance(node, tree.Unary) and node.operator in ("-", "+"):
        number = _number_of(node.operand)
        return None if number is None else -number if node.operator == "-" else number
    return node.value if isinstance(node, tree.Number) else None


def _article(of: Type) -> str:
    return f"{'an' if of.name[0] in 'aeiou' else 'a'} {of}"
