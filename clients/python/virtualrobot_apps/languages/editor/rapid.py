"""RAPID as an editor sees it: names in their scopes, whether or not the program is whole.

A program is a module with those beside it that declare names which it uses, and so on; a module that would declare a
name anew is another program's.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Sequence
from functools import cached_property
from weakref import WeakKeyDictionary

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.words import Words
from virtualrobot_apps.languages.editor.language import Item, ItemKind, Language, Spot, Symbol, SymbolKind
from virtualrobot_apps.languages.editor.text import code, comment_above
from virtualrobot_apps.languages.editor.units import UNITS, units_of
from virtualrobot_apps.languages.rapid import builtin, tree
from virtualrobot_apps.languages.rapid.check import check
from virtualrobot_apps.languages.rapid.layout import formatted
from virtualrobot_apps.languages.rapid.lexer import KEYWORDS, pieces_of, words_of
from virtualrobot_apps.languages.rapid.meaning import LACKING, predefined
from virtualrobot_apps.languages.rapid.parser import Parser
from virtualrobot_apps.languages.rapid.predefined import CONSTANTS
from virtualrobot_apps.languages.rapid.symbols import Datum, ModuleScope, RoutineSymbol
from virtualrobot_apps.languages.rapid.table import BUILTINS, Builtin
from virtualrobot_apps.languages.rapid.tree import statements_within
from virtualrobot_apps.languages.rapid.types import Type
from virtualrobot_apps.languages.rapid.values import value_text

builtin.load()

_STORAGES = ("var", "pers", "const")
_BEFORE_TYPES = frozenset((*_STORAGES, "func", "record", "alias"))
_NAMED_AFTER = {**dict.fromkeys((*_STORAGES, "func", "alias"), 2), **dict.fromkeys(("proc", "trap", "record"), 1)}
"""Number of words after which the name comes that a declaration declares."""
_OPENING, _CLOSING = frozenset("([{"), frozenset(")]}")
_LONGEST = 400
"""Count of letters of the longest declaration that is shown whole."""

Meant = Datum | RoutineSymbol | Builtin | tree.Record | tree.Alias | tree.Parameter


class _Text:
    """Words of a source, the names in it, and those that it declares for all modules, in small letters."""

    def __init__(self, words: Words) -> None:
        """Keep the words; names are looked for when they are asked for."""
        self.words = words

    @cached_property
    def names(self) -> frozenset[str]:
        """All names in it."""
        words = self.words
        return frozenset(value for kind, value in zip(words.kinds, words.values, strict=True) if kind == "name")

    @cached_property
    def lower(self) -> frozenset[str]:
        """All names in it, in small letters."""
        return frozenset(map(str.lower, self.names))

    @cached_property
    def declared(self) -> frozenset[str]:
        """Names that its modules declare, but for local ones."""
        found, within = set(), ""
        kinds, values = self.words.kinds, self.words.values
        for number, kind in enumerate(kinds):
            if within:
                within = "" if kind in (within, "endmodule") else within
            elif kind in _NAMED_AFTER:
                name = number + _NAMED_AFTER[kind]
                if kinds[number - 1] != "local" and name < len(kinds):
                    found.add(values[name].lower())
                within = "" if kind in (*_STORAGES, "alias") else f"end{kind}"
        return frozenset(found)


_TEXTS: WeakKeyDictionary[Source, _Text] = WeakKeyDictionary()
"""Texts of sources that were read, as long as somebody has these."""


def _text(source: Source) -> _Text:
    if source not in _TEXTS:
        _TEXTS[source] = _Text(words_of(source, Diagnostics()))
    return _TEXTS[source]


def _parsed(source: Source, diagnostics: Diagnostics) -> list[tree.Module]:
    """Return the modules of a source, whose words are kept."""
    parser = Parser(source, diagnostics)
    _TEXTS[source] = _Text(Words(parser.kinds, parser.values, parser.starts, parser.ends))
    return parser.file()


def together(source: Source, beside: Sequence[Source]) -> list[Source]:
    """Return a source and those of the others that are one program with it."""
    chosen, own = [source], _text(source)
    if not beside:
        return chosen
    names, declared = set(own.lower), set(own.declared)
    more = True
    while more:
        more = False
        for other in beside:
            text = _text(other)
            if other not in chosen and text.declared & (names - declared) and not text.declared & declared:
                chosen.append(other)
                names |= text.lower
                declared |= text.declared
                more = True
    return chosen


class RapidAnalysis:
    """Meaning of a source, with those that are one program with it."""

    def __init__(self, source: Source, beside: Sequence[Source]) -> None:
        """Check the program."""
        diagnostics = Diagnostics()
        modules = _parsed(source, diagnostics)
        for other in together(source, beside)[1:]:
            modules += _parsed(other, diagnostics)
        self._checked = check(modules, diagnostics)
        self.diagnostics = [one for one in diagnostics.sorted() if one.file == source.file]
        self._source, self._words = source, _text(source).words
        self._predefined = predefined()

    # What is asked for.

    def hover(self, at: int) -> str:
        """Return what is known of the word at a place, in Markdown, or nothing."""
        number = self._words.name_at(at)
        if number is None:
            return ""
        part = self._component(number)
        if part is not None:
            of, (type_name, name) = part
            unit = UNITS.get(str(of).lower(), {}).get(name.lower())
            return code("rapid", f"{type_name} {name}", f"Component of {of}{f', in {unit}' if unit else ''}.")
        name = self._words.values[number].lower()
        meant = self._meant(number)
        if meant is None:
            if name in LACKING:
                return f"{LACKING[name]} can't be used here yet."
            known = self._checked.types.components(name)
            return code("rapid", f"{name}: {', '.join(' '.join(one) for one in known)}") if known else ""
        return self._told(meant)

    def definition(self, at: int) -> Spot | None:
        """Return the name in the declaration of what the word at a place stands for."""
        number = self._words.name_at(at)
        if number is None or self._component(number) is not None:
            return None
        label = self._label(number)
        if label is not None:
            return Spot(self._source, label.at, label.at + len(label.name))
        meant = self._meant(number)
        declared = None if meant is None or isinstance(meant, Builtin) else self._declaration(meant)
        if declared is None or meant is None:
            return None
        source, node = declared
        begin = _name_at(_text(source).words, node)
        return Spot(source, begin, begin + len(node.name))

    def completion(self, at: int) -> list[Item]:
        """Return the words that can stand at a place."""
        if self._said(at):
            return []
        words = self._words
        before = bisect_right(words.starts, at - 1) - 1
        if before >= 0 and words.ends[before] >= at and words.kinds[before].isalpha():
            before -= 1  # the word that is being written
        kind = words.kinds[before] if before >= 0 else ""
        if kind == ".":
            of = self._type_ending(before - 1)
            parts = self._checked.types.components(of.name) if of is not None and not of.dimensions else []
            return [Item(name, ItemKind.FIELD, type_name) for type_name, name in parts]
        if kind == "\\":
            parameters = self._parameters(self._called(before))
            return [Item(one.name, ItemKind.PROPERTY, one.type) for one in parameters if one.optional]
        if kind in _BEFORE_TYPES:
            return [Item(one, ItemKind.STRUCT) for one in sorted(set(self._checked.types.names()))]
        return self._all(at)

    def symbols(self) -> list[Symbol]:
        """Return the modules of the text and what they declare."""
        found: list[Symbol] = []
        modules = [scope.module for scope in self._checked.modules if scope.module.source is self._source]
        for number, module in enumerate(modules):
            end = modules[number + 1].at if number + 1 < len(modules) else len(self._source.text)
            one = self._symbol(module, SymbolKind.MODULE, self._end(module.at, "endmodule", end))
            found.append(one)
            nodes = module.declarations
            for place, node in enumerate(nodes):
                limit = nodes[place + 1].at if place + 1 < len(nodes) else one.end
                if not node.name:
                    continue
                match node:
                    case tree.Data():
                        kind = SymbolKind.CONSTANT if node.storage == "const" else SymbolKind.VARIABLE
                        inner = self._symbol(node, kind, self._end(node.at, ";", limit), node.type)
                    case tree.Routine():
                        kind = SymbolKind.EVENT if node.kind == "trap" else SymbolKind.FUNCTION
                        end = self._end(node.at, f"end{node.kind}", limit)
                        inner = self._symbol(node, kind, end, f"{node.kind.upper()} {node.result}".rstrip())
                    case tree.Record():
                        inner = self._symbol(node, SymbolKind.STRUCT, self._end(node.at, "endrecord", limit))
                    case tree.Alias():
                        inner = self._symbol(node, SymbolKind.TYPE, self._end(node.at, ";", limit), node.type)
                one.within.append(inner)
        return found

    def _symbol(self, node: tree.Module | tree.Declaration, kind: SymbolKind, end: int, detail: str = "") -> Symbol:
        return Symbol(node.name, kind, node.at, end, _name_at(self._words, node), detail)

    def _end(self, at: int, kind: str, limit: int) -> int:
        """Return the end of the first word of a kind after a place, before a limit, which it is otherwise."""
        for number in range(bisect_right(self._words.starts, at), len(self._words.starts)):
            if self._words.starts[number] >= limit:
                break
            if self._words.kinds[number] == kind:
                return self._words.ends[number]
        return limit

    # Words.

    def _said(self, at: int) -> bool:
        """Return whether a place is within a comment or a text."""
        for kind, text, begin in pieces_of(self._source):
            if begin >= at:
                return False
            if kind in ("comment", "head", "preset", "unclosed") and at <= begin + len(text):
                return True
            if kind == "text" and at < begin + len(text):
                return True
        return False

    def _back(self, number: int) -> int:
        """Return the number of the bracket that the one of a number closes; -1 where none does."""
        depth = 0
        for one in range(number, -1, -1):
            kind = self._words.kinds[one]
            depth += (kind in _CLOSING) - (kind in _OPENING)
            if depth == 0:
                return one
        return -1

    # What words mean.

    def _meant(self, number: int) -> Meant | None:
        """Return what a name stands for at its place."""
        words = self._words
        if number and words.kinds[number - 1] == "\\":
            wanted = words.values[number].lower()
            for one in self._parameters(self._called(number - 1)):
                if one.name.lower() == wanted:
                    return one
        return self._named(words.values[number], words.starts[number])

    def _named(self, name: str, at: int) -> Meant | None:
        """Return what a name stands for at a place."""
        lower = name.lower()
        scope, routine = self._scopes(at)
        if routine is not None:
            for loop in self._loops(routine, at):
                if loop.name.lower() == lower and loop.symbol is not None:
                    return loop.symbol
            for datum in reversed(routine.data):
                if datum.name.lower() == lower:
                    return datum
        for names in (scope.names if scope is not None else {}, self._checked.globals, self._predefined):
            if lower in names:
                return names[lower]
        for module in self._checked.modules:
            for one in module.module.declarations:
                if isinstance(one, tree.Record | tree.Alias) and one.name.lower() == lower:
                    return one
        return BUILTINS.get(lower)

    def _scopes(self, at: int) -> tuple[ModuleScope | None, RoutineSymbol | None]:
        """Return the module and the routine that a place is in."""
        own = [one for one in self._checked.modules if one.module.source is self._source and one.module.at <= at]
        if not own:
            return None, None
        node = next((one for one in reversed(own[-1].module.declarations) if one.at <= at), None)
        return own[-1], next((one for one in own[-1].routines if one.node is node), None)

    def _loops(self, routine: RoutineSymbol, at: int) -> list[tree.For]:
        """Return the loops that a place is in, the innermost first."""
        loops = [one for one in statements_within(routine.node) if isinstance(one, tree.For) and one.at <= at]
        return [one for one in reversed(loops) if at <= self._loop_end(one)]

    def _loop_end(self, loop: tree.For) -> int:
        depth = 0
        for number in range(bisect_right(self._words.starts, loop.at) - 1, len(self._words.starts)):
            kind = self._words.kinds[number]
            depth += (kind == "for") - (kind == "endfor")
            if depth == 0:
                return self._words.ends[number]
        return len(self._source.text)

    def _label(self, number: int) -> tree.Label | None:
        """Return the label that GOTO leads to, where a name is that of one."""
        if not number or self._words.kinds[number - 1] != "goto":
            return None
        _, routine = self._scopes(self._words.starts[number])
        wanted = self._words.values[number].lower()
        labels = [] if routine is None else statements_within(routine.node)
        return next((one for one in labels if isinstance(one, tree.Label) and one.name.lower() == wanted), None)

    def _component(self, number: int) -> tuple[Type, tuple[str, str]] | None:
        """Return the type of a record, and type and name of the component that a name is of it."""
        if number < 2 or self._words.kinds[number - 1] != ".":
            return None
        of = self._type_ending(number - 2)
        if of is None or of.dimensions:
            return None
        wanted = self._words.values[number].lower()
        parts = self._checked.types.components(of.name)
        return next(((of, one) for one in parts if one[1].lower() == wanted), None)

    def _type_ending(self, number: int) -> Type | None:
        """Return the type of the variable or call whose last word has a number."""
        words, types = self._words, self._checked.types
        if number < 0:
            return None
        if words.kinds[number] == "}":
            of = self._type_ending(self._back(number) - 1)
            return None if of is None else Type(of.name)
        if words.kinds[number] == ")":
            meant = self._meant(self._back(number) - 1)
            if isinstance(meant, RoutineSymbol):
                return meant.result
            return Type(types.resolved(meant.result) or "any") if isinstance(meant, Builtin) and meant.result else None
        if words.kinds[number] != "name":
            return None
        if number > 1 and words.kinds[number - 1] == ".":
            part = self._component(number)
            return None if part is None else Type(types.resolved(part[1][0]) or "any")
        meant = self._meant(number)
        return meant.type if isinstance(meant, Datum) else None

    def _called(self, number: int) -> Meant | None:
        """Return the routine in whose arguments a word is."""
        words = self._words
        while number > 0:
            number -= 1
            kind = words.kinds[number]
            if kind in _CLOSING:
                number = self._back(number)
            elif kind == "(":
                return self._meant(number - 1) if number and words.kinds[number - 1] == "name" else None
            elif kind == ":=" and (number < 2 or words.kinds[number - 2] != "\\"):
                return None
            elif kind == ";" or kind in _STATEMENTS:
                return None
            elif kind == "name" and (number == 0 or words.kinds[number - 1] in _BEGINNERS):
                return self._named(words.values[number], words.starts[number])
        return None

    def _parameters(self, of: Meant | None) -> list[tree.Parameter]:
        if isinstance(of, RoutineSymbol):
            return [one for one, _ in of.parameters]
        return of.parameters if isinstance(of, Builtin) else []

    # Declarations.

    def _declaration(self, meant: Meant) -> tuple[Source, tree.Declaration | tree.Parameter | tree.For] | None:
        """Return the declaration of something, with the source that it is in."""
        for scope in self._checked.modules:
            source = scope.module.source
            for node in scope.module.declarations:
                if node is meant or (isinstance(node, tree.Data) and node.symbol is meant):
                    return source, node
            for routine in scope.routines:
                if routine is meant:
                    return source, routine.node
                for (parameter, _), datum in zip(routine.parameters, routine.data, strict=False):
                    if meant is parameter or meant is datum:
                        return source, parameter
        for scope in self._checked.modules:
            for routine in scope.routines:
                for one in statements_within(routine.node):
                    if isinstance(one, tree.Data | tree.For) and one.symbol is meant:
                        return scope.module.source, one
        return None

    def _told(self, meant: Meant) -> str:
        """Return what is known of something, in Markdown."""
        match meant:
            case Builtin():
                return code("rapid", _signature(meant), meant.text)
            case Datum(storage="loop"):
                return code("rapid", f"num {meant.name}", "Variable of the loop.")
            case Datum() if meant.name in CONSTANTS and self._declaration(meant) is None:
                value = CONSTANTS[meant.name][1]
                units = units_of(meant.type.name, value if isinstance(value, list) else None)
                shown = f"CONST {meant.type} {meant.name} := {value_text(value)}"
                return code("rapid", shown, ", ".join(units), "Comes with the language.")
        found = self._declaration(meant)
        if found is None:
            storage = f"{meant.storage.upper()} " if isinstance(meant, Datum) else ""
            kind = meant.type if isinstance(meant, Datum | tree.Parameter) else ""
            return code("rapid", f"{storage}{kind} {meant.name}" if not isinstance(meant, RoutineSymbol) else "")
        source, node = found
        if isinstance(node, tree.Parameter):
            mode = "" if node.mode == "in" else f"{node.mode.upper()} "
            sign = "\\" if node.optional else ""
            stars = f"{{{','.join('*' * node.dimensions)}}}" if node.dimensions else ""
            return code("rapid", f"{sign}{mode}{node.type} {node.name}{stars}", "Parameter.")
        module = next(one.module.name for one in self._checked.modules if one.module.source is source)
        units = ", ".join(units_of(meant.type.name)) if isinstance(meant, Datum) else ""
        comment = comment_above(source, source.line(node.at), "!")
        return code("rapid", _shown(source, node), comment, units, f"Module {module}.")

    def _all(self, at: int) -> list[Item]:
        """Return all names that can be written at a place, those that are nearer first."""
        found: dict[str, Item] = {}
        scope, routine = self._scopes(at)
        data: list[Datum] = []
        if routine is not None:
            data = [one.symbol for one in self._loops(routine, at) if one.symbol is not None] + routine.data
        scopes = [scope.names if scope is not None else {}, self._checked.globals, self._predefined]
        for one in (*data, *(symbol for names in scopes for symbol in names.values())):
            if isinstance(one, RoutineSymbol):
                item = Item(one.node.name, ItemKind.FUNCTION, one.node.kind.upper())
            else:
                kind = ItemKind.CONSTANT if one.storage == "const" else ItemKind.VARIABLE
                item = Item(one.name, kind, str(one.type))
            found.setdefault(item.label.lower(), item)
        for lower, row in BUILTINS.items():
            found.setdefault(lower, Item(row.name, ItemKind.FUNCTION, _signature(row), row.text))
        for word in sorted(KEYWORDS):
            found.setdefault(word, Item(word.upper(), ItemKind.KEYWORD))
        return list(found.values())


_STATEMENTS = KEYWORDS - frozenset("true false and or xor not div mod".split())
"""Reserved words that stand in no expression."""
_BEGINNERS = frozenset((";", ":", *_STATEMENTS))
"""Words after which a statement begins."""


def _signature(row: Builtin) -> str:
    """Return an instruction or function as a routine would be declared."""
    return f"FUNC {row.result} {row.name}({row.signature})" if row.result else f"{row.name} {row.signature}".rstrip()


def _name_at(words: Words, node: tree.Module | tree.Declaration | tree.Parameter | tree.For) -> int:
    """Return the place of the name in a declaration: the last of the words that begin it."""
    number = bisect_right(words.starts, node.at) - 1
    match node:
        case tree.Data() | tree.Alias() | tree.Routine(kind="func"):
            number += 2
        case tree.Parameter():
            number += 1 if node.mode == "in" else 2
        case _:
            number += 1
    return words.starts[min(number, len(words.starts) - 1)]


def _shown(source: Source, node: tree.Declaration | tree.For) -> str:
    """Return a declaration as it is written, of a routine the header."""
    words = _text(source).words
    last = "endrecord" if isinstance(node, tree.Record) else ";"
    number = bisect_right(words.starts, node.at) - 1
    if isinstance(node, tree.Routine):
        last = ")" if node.kind != "trap" else "name"
    while number + 1 < len(words.kinds) and words.kinds[number] != last:
        number += 1
    text = re.sub(r"\s+", " ", source.text[node.at : words.ends[number]])
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


RAPID = Language("rapid", (".mod", ".modx", ".sys", ".sysx", ".prg"), RapidAnalysis, formatted, beside=True)
"""RAPID, with the endings of ABB's files; those with x are in UTF-8."""
