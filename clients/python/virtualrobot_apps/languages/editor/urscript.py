"""URScript as an editor sees it: names in their functions, whether or not the script is whole."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.editor.language import Item, ItemKind, Language, Spot, Symbol, SymbolKind
from virtualrobot_apps.languages.editor.text import code, comment_above
from virtualrobot_apps.languages.urscript import tree
from virtualrobot_apps.languages.urscript.check import check, statements_of
from virtualrobot_apps.languages.urscript.layout import formatted
from virtualrobot_apps.languages.urscript.lexer import KEYWORDS, words_of
from virtualrobot_apps.languages.urscript.parser import parse
from virtualrobot_apps.languages.urscript.table import BUILTINS, Builtin, lacking_names

_OPENING = frozenset("def thread sec if while".split())
_FUNCTIONS = frozenset("def thread sec".split())


@dataclass(frozen=True, slots=True)
class _Scope:
    """A function, and where it ends."""

    function: tree.Function
    end: int


class UrscriptAnalysis:
    """Meaning of a script."""

    def __init__(self, source: Source, beside: Sequence[Source] = ()) -> None:
        """Check the script; a script is one source."""
        diagnostics = Diagnostics()
        self._source, self._words = source, words_of(source, diagnostics)
        script = parse(source, diagnostics, self._words)
        self._checked = check(script, diagnostics)
        self.diagnostics = diagnostics.sorted()
        self._main = script.main
        ends = dict(self._ends())
        named = script.main.at in ends  # lines without a program are one without a name
        functions = [*([script.main] if named else []), *_functions_in(script.main.body)]
        self._scopes = [_Scope(one, ends.get(one.at, len(source.text))) for one in functions]

    def hover(self, at: int) -> str:
        """Return what is known of the word at a place, in Markdown, or nothing."""
        number = self._words.name_at(at)
        if number is None:
            return ""
        name = self._words.values[number]
        scope = self._scope(at)
        if scope is not None and name in self._checked.own.get(scope.function.name, ()):
            return self._variable(name, f"Variable of {scope.function.name}.", scope)
        if name in self._checked.globals:
            return self._variable(name, "Global variable.", None)
        function = self._function(name)
        if function is not None:
            told = comment_above(self._source, self._source.line(function.at), "#")
            return code("urscript", _header(self._source, function), told)
        if name in BUILTINS:
            return code("urscript", _signature(BUILTINS[name]), BUILTINS[name].text)
        return f"{name} can't be used here yet." if name in lacking_names() else ""

    def definition(self, at: int) -> Spot | None:
        """Return the name in the declaration of what the word at a place stands for."""
        number = self._words.name_at(at)
        if number is None:
            return None
        name, scope = self._words.values[number], self._scope(at)
        begin: int | None = None
        if scope is not None and name in self._checked.own.get(scope.function.name, ()):
            begin = _first(name, scope.function)
        elif name in self._checked.globals:
            begin = self._global(name)
        elif (function := self._function(name)) is not None:
            begin = self._after(function.at)
        return None if begin is None else Spot(self._source, begin, begin + len(name))

    def completion(self, at: int) -> list[Item]:
        """Return the words that can stand at a place."""
        line = self._source.text[self._source.at(self._source.line(at)) : at]
        if "#" in line or line.count('"') % 2:
            return []
        scope = self._scope(at)
        own = sorted(self._checked.own.get(scope.function.name, ())) if scope is not None else []
        found = {name: Item(name, ItemKind.VARIABLE) for name in (*own, *sorted(self._checked.globals))}
        for name, function in self._checked.functions.items():
            header = _header(self._source, function)
            found.setdefault(name, Item(name, ItemKind.FUNCTION, header))
        for name, row in BUILTINS.items():
            found.setdefault(name, Item(name, ItemKind.FUNCTION, _signature(row), row.text))
        for word in sorted(KEYWORDS):
            found.setdefault(word, Item(word, ItemKind.KEYWORD))
        return list(found.values())

    def symbols(self) -> list[Symbol]:
        """Return the functions of the script, each in the one that it stands in, and the global variables."""
        top: list[Symbol] = []
        around: list[Symbol] = []
        for scope in self._scopes:
            function = scope.function
            begin = self._after(function.at)
            kind = SymbolKind.EVENT if function.kind == "thread" else SymbolKind.FUNCTION
            one = Symbol(function.name, kind, function.at, scope.end, begin, function.kind)
            while around and around[-1].end <= one.begin:
                around.pop()
            (around[-1].within if around else top).append(one)
            around.append(one)
        for name in sorted(self._checked.globals):
            at = self._global(name)
            if at is None:
                continue
            one = Symbol(name, SymbolKind.VARIABLE, at, at + len(name), at)
            outer = next((each for each in top if each.begin <= at < each.end), None)
            (outer.within if outer is not None else top).append(one)
        return top

    def _ends(self) -> Iterator[tuple[int, int]]:
        """Yield where functions begin and end."""
        words, open_at = self._words, []
        for number, kind in enumerate(words.kinds):
            if kind in _OPENING:
                open_at.append((kind, words.starts[number]))
            elif kind == "end" and open_at:
                begun, at = open_at.pop()
                if begun in _FUNCTIONS:
                    yield at, words.ends[number]

    def _after(self, at: int) -> int:
        """Return the place of the word after the one at a place."""
        return self._words.starts[min(bisect_right(self._words.starts, at), len(self._words.starts) - 1)]

    def _scope(self, at: int) -> _Scope | None:
        """Return the innermost function that a place is in."""
        return next((one for one in reversed(self._scopes) if one.function.at <= at < one.end), None)

    def _function(self, name: str) -> tree.Function | None:
        """Return the function, thread or program of a name."""
        return next((one.function for one in self._scopes if one.function.name == name), None)

    def _global(self, name: str) -> int | None:
        """Return the place at which a global variable gets its first value."""
        first = _first(name, self._main)
        if first is not None:
            return first
        return next(
            (
                one.target.at
                for scope in self._scopes
                for one in statements_of(scope.function.body)
                if isinstance(one, tree.Assign) and one.scope == "global" and _is(one.target, name)
            ),
            None,
        )

    def _variable(self, name: str, told: str, scope: _Scope | None) -> str:
        """Return what is known of a variable: the line where it gets its first value."""
        at = self._global(name) if scope is None else _first(name, scope.function)
        if at is None:
            return ""
        line = self._source.text[self._source.at(self._source.line(at)) :].partition("\n")[0].strip()
        return code("urscript", line, told)


def _functions_in(body: Sequence[tree.Statement]) -> Iterator[tree.Function]:
    """Yield functions in statements, those within them too, in the order of the text."""
    for one in statements_of(body):
        if isinstance(one, tree.Function):
            yield one
            yield from _functions_in(one.body)


def _is(target: tree.Expression, name: str) -> bool:
    return isinstance(target, tree.Name) and target.name == name


def _first(name: str, function: tree.Function) -> int | None:
    """Return the place at which a variable of a function gets its first value, or of its parameter."""
    for parameter in function.parameters:
        if parameter.name == name:
            return parameter.at
    for one in statements_of(function.body):
        if isinstance(one, tree.Assign) and _is(one.target, name):
            return one.target.at
    return None


def _signature(row: Builtin) -> str:
    return f"{row.name}({row.signature})"


def _header(source: Source, function: tree.Function) -> str:
    """Return the first line of a function, without its colon."""
    return source.text[function.at :].partition("\n")[0].partition("#")[0].strip().removesuffix(":").rstrip()


URSCRIPT = Language("urscript", (".script", ".urscript"), UrscriptAnalysis, formatted)
"""URScript; a script is one file."""
