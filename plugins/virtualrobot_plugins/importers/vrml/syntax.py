"""The grammar of VRML97: text to a tree of nodes.

ISO/IEC 14772-1:1997, annex A. Fields are read by the look of their values, not by a table of node types, so that nodes
of any type are read; what a value means is decided where it is used.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from virtualrobot_plugins.importers.refusal import refusal

MAX_DEPTH = 100
"""Nodes and prototypes inside each other; deeper ones are refused."""

_TOKEN = re.compile(
    r"""(?P<skip>(?:[\s,]+|\#[^\r\n]*)+)
    |(?P<string>"(?:[^"\\]|\\.)*")
    |(?P<mark>[{}\[\]])
    |(?P<number>[-+]?(?:0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?))(?=[\s,{}\[\]\#"]|$)
    |(?P<word>[^\s,{}\[\]"'\#]+)""",
    re.VERBOSE | re.DOTALL,
)
# A list of numbers only is by far most of any file, and is read in one step.
_NUMBERS = re.compile(r"[\s,\d.eE+-]*\]")
_INTERFACE = ("field", "exposedField", "eventIn", "eventOut")


@dataclass(frozen=True, slots=True)
class Is:
    """The value of a field that a prototype's user gives: `size IS boxSize`."""

    name: str


@dataclass(slots=True, eq=False)
class Node:
    """A node: its type, its fields by name, and where it stands."""

    kind: str
    line: int
    fields: dict[str, Value] = field(default_factory=dict)
    prototype: Prototype | None = None


@dataclass(slots=True, eq=False)
class Prototype:
    """PROTO or EXTERNPROTO: defaults of its fields, and the nodes that it stands for (none for EXTERNPROTO)."""

    name: str
    defaults: dict[str, Value] = field(default_factory=dict)
    body: list[Node] = field(default_factory=list)
    external: bool = False


Value: TypeAlias = "NDArray[np.float64] | list[Node | str | bool] | Node | str | bool | Is | None"
"""Numbers of one value or of many as an array (n,); strings, nodes and truths alone or in a list."""


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    start: int


@dataclass(slots=True)
class _Names:
    """Names that hold in the file or in the body of a prototype."""

    nodes: dict[str, Node] = field(default_factory=dict)
    prototypes: dict[str, Prototype] = field(default_factory=dict)


def parse(text: str, uri: str) -> list[Node]:
    """Return the root nodes of a VRML97 file; `uri` names it in errors.

    Raises:
        ArgumentError: `file:line: ...` for what is not VRML97.
    """
    return _Parser(text, uri).file()


class _Parser:
    """Reads one file, one token ahead."""

    def __init__(self, text: str, uri: str) -> None:
        self._text, self._uri = text, uri
        self._place = 0
        self._line_place, self._line = 0, 1
        self._depth = 0
        self._next: _Token | None = self._read()

    def file(self) -> list[Node]:
        names = _Names()
        nodes: list[Node] = []
        while self._next is not None:
            nodes.extend(self._statement(names))
        return nodes

    def _statement(self, names: _Names) -> Iterator[Node]:
        """Read a statement of a file or of a prototype's body; yield the node that it makes, if any."""
        word = self._peek()
        if word == "PROTO":
            self._prototype(names)
        elif word == "EXTERNPROTO":
            self._external_prototype(names)
        elif word == "ROUTE":
            self._route()
        else:
            node = self._node(names)
            if node is not None:
                yield node

    def _node(self, names: _Names) -> Node | None:
        token = self._take("word", "a node")
        if token.text == "NULL":
            return None
        if token.text == "USE":
            name = self._take("word", "a name after USE")
            if name.text not in names.nodes:
                raise self._error(name, f"USE {name.text}: no node before has this name (DEF {name.text})")
            return names.nodes[name.text]
        if token.text != "DEF":
            return self._body(token, names)
        name = self._take("word", "a name after DEF")
        node = self._body(self._take("word", "the type of a node"), names)
        names.nodes[name.text] = node
        return node

    def _body(self, kind: _Token, names: _Names) -> Node:
        self._deeper(kind)
        if self._peek() != "{":
            raise self._error(kind, f"{kind.text!r} is no node: expected '{{' behind it, got {self._found()}")
        self._skip()
        node = Node(kind.text, self._line_at(kind.start), prototype=names.prototypes.get(kind.text))
        while self._peek() != "}":
            word = self._take("word", f"a field of {kind.text} or '}}'")
            if word.text == "ROUTE":
                self._route_rest()
            elif word.text in ("PROTO", "EXTERNPROTO"):
                raise self._error(word, f"{word.text} cannot stand inside of a node")
            elif word.text in _INTERFACE:
                self._script_field(word.text, node, names)
            elif self._peek() == "IS":
                self._skip()
                node.fields[word.text] = Is(self._take("word", "a name after IS").text)
            else:
                node.fields[word.text] = self._value(names, f"{kind.text}.{word.text}")
        self._skip()
        self._depth -= 1
        return node

    def _value(self, names: _Names, what: str) -> Value:
        token = self._next
        if token is None:
            raise self._error(None, f"{what} has no value: the file ends here")
        if token.text == "[" and token.kind == "mark":
            return self._list(names, what)
        if token.kind == "number":
            numbers = []
            while self._next is not None and self._next.kind == "number":
                numbers.append(self._number(self._advance()))
            return np.array(numbers)
        if token.kind == "string":
            return _unquoted(self._advance().text)
        if token.text in ("TRUE", "FALSE"):
            return self._advance().text == "TRUE"
        if token.kind == "word":
            return self._node(names)
        raise self._error(token, f"{what} has no value: got {self._found()}")

    def _list(self, names: _Names, what: str) -> Value:
        opening = self._next
        assert opening is not None
        run = _NUMBERS.match(self._text, opening.start + 1)
        if run:
            words = self._text[opening.start + 1 : run.end() - 1].replace(",", " ").split()
            self._place = run.end()
            self._next = self._read()
            try:
                return np.array(words, np.float64)
            except ValueError as error:
                raise self._error(opening, f"{what}: {error}") from error
        self._skip()
        items: list[Node | str | bool] = []
        numbers: list[float] = []
        while self._peek() != "]":
            token = self._next
            if self._peek() == "[":
                raise self._error(token, f"{what}: a list cannot hold a list")
            value = self._value(names, what)
            if isinstance(value, np.ndarray):
                numbers.extend(value)
            elif isinstance(value, Node | str | bool):
                items.append(value)
            if numbers and items:
                raise self._error(token, f"{what}: numbers, words and nodes are mixed in one list")
        self._skip()
        return np.array(numbers) if numbers else items

    def _prototype(self, names: _Names) -> None:
        self._deeper(self._advance())
        prototype = Prototype(self._take("word", "the name of the prototype").text)
        self._expect("[")
        while self._peek() != "]":
            access = self._access()
            self._take("word", "a type")
            name = self._take("word", "a name").text
            if access in ("field", "exposedField"):
                prototype.defaults[name] = self._value(names, f"{prototype.name}.{name}")
        self._skip()
        self._expect("{")
        # A body sees the prototypes around it, but not the nodes.
        inside = _Names(prototypes=dict(names.prototypes))
        while self._peek() != "}":
            prototype.body.extend(self._statement(inside))
        self._skip()
        self._depth -= 1
        names.prototypes[prototype.name] = prototype

    def _external_prototype(self, names: _Names) -> None:
        self._skip()
        prototype = Prototype(self._take("word", "the name of the prototype").text, external=True)
        self._expect("[")
        while self._peek() != "]":
            self._access()
            self._take("word", "a type")
            self._take("word", "a name")
        self._skip()
        self._value(names, f"the place of {prototype.name}")
        names.prototypes[prototype.name] = prototype

    def _script_field(self, access: str, node: Node, names: _Names) -> None:
        self._take("word", "a type")
        name = self._take("word", "a name").text
        if self._peek() == "IS":
            self._skip()
            node.fields[name] = Is(self._take("word", "a name after IS").text)
        elif access in ("field", "exposedField"):
            node.fields[name] = self._value(names, f"{node.kind}.{name}")

    def _access(self) -> str:
        token = self._take("word", f"one of {', '.join(_INTERFACE)}, or ']'")
        if token.text not in _INTERFACE:
            raise self._error(token, f"{token.text!r}: expected one of {', '.join(_INTERFACE)}, or ']'")
        return token.text

    def _route(self) -> None:
        self._skip()
        self._route_rest()

    def _route_rest(self) -> None:
        self._take("word", "a route's start")
        token = self._take("word", "TO")
        if token.text != "TO":
            raise self._error(token, f"ROUTE: expected TO, got {token.text!r}")
        self._take("word", "a route's end")

    def _number(self, token: _Token) -> float:
        try:
            return float(token.text)
        except ValueError:
            return float(int(token.text, 16))

    def _deeper(self, token: _Token) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._error(token, f"nodes are nested more than {MAX_DEPTH} deep")

    # Tokens

    def _peek(self) -> str:
        """Return the text of the next token; an ArgumentError says that the file ends instead."""
        if self._next is None:
            raise self._error(None, "the file ends in the middle of a node; is it cut off?")
        return '"' if self._next.kind == "string" else self._next.text

    def _advance(self) -> _Token:
        token = self._next
        if token is None:
            raise self._error(None, "the file ends in the middle of a node; is it cut off?")
        self._next = self._read()
        return token

    def _skip(self) -> None:
        self._advance()

    def _take(self, kind: str, expected: str) -> _Token:
        if self._next is None or self._next.kind != kind:
            raise self._error(self._next, f"expected {expected}, got {self._found()}")
        return self._advance()

    def _expect(self, mark: str) -> None:
        if self._peek() != mark:
            raise self._error(self._next, f"expected {mark!r}, got {self._found()}")
        self._skip()

    def _found(self) -> str:
        if self._next is None:
            return "the end of the file"
        text = self._next.text
        return repr(text if len(text) <= 40 else text[:37] + "...")

    def _read(self) -> _Token | None:
        while self._place < len(self._text):
            match = _TOKEN.match(self._text, self._place)
            if match is None:
                start = self._place
                raise self._error(_Token("", "", start), f"{self._text[start]!r} has no meaning here")
            self._place = match.end()
            kind = match.lastgroup or ""
            if kind != "skip":
                return _Token(kind, match[0], match.start())
        return None

    def _line_at(self, place: int) -> int:
        """Return the line of a place, from 1; places mostly grow, so that only what is new is counted."""
        if place < self._line_place:
            self._line_place, self._line = 0, 1
        self._line += self._text.count("\n", self._line_place, place)
        self._line_place = place
        return self._line

    def _error(self, token: _Token | None, message: str) -> Exception:
        place = len(self._text) if token is None else token.start
        return refusal(self._uri, message, self._line_at(place))


def _unquoted(text: str) -> str:
    return re.sub(r"\\(.)", r"\1", text[1:-1], flags=re.DOTALL)
