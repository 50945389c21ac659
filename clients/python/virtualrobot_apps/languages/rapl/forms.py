"""Forms of commands: what stands after a command's name, in words such as `location number [S]`.

A small word is a kind of argument, with `...` one that may be repeated; a word in capitals stands there itself,
`UP|DOWN` is one of these, and what is between brackets may be left out. Commas may be left out, but for those of a
repeated one.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from virtualrobot_apps.languages.rapl.expressions import Evaluate, Expression, number
from virtualrobot_apps.languages.rapl.lexer import Word, WordError

RELATIONS = {
    "==": "EQ",
    "EQ": "EQ",
    "<>": "NE",
    "!=": "NE",
    "NE": "NE",
    "<": "LT",
    "LT": "LT",
    ">": "GT",
    "GT": "GT",
    "<=": "LE",
    "LE": "LE",
    ">=": "GE",
    "GE": "GE",
}
"""Relations of IF as they may be written, and their names."""

_SAID = {
    "number": "a number or a variable",
    "location": "the name of a location",
    "new_location": "the name of a location",
    "variable": "the name of a variable",
    "new_variable": "the name of a variable",
    "string": "a string, as &1",
    "said": "a text in quotes, or a string, as &1",
    "line": "the number of a line",
    "program": "the name of a program",
    "template": "the name that the locations of a path begin with",
    "signal": "the number of an input or output, with - where it is off",
    "parameter": "a number, a variable or the name of a location",
    "relation": "a relation, as == or LT",
}


@dataclass(frozen=True, slots=True)
class Element:
    """One element of a form: its kind, the words that may stand there, whether it is repeated or may be left out."""

    kind: str
    words: tuple[str, ...]
    many: bool
    optional: bool


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a statement: its kind, and its word, function or list of these; None where it was left out."""

    kind: str
    value: Any


@dataclass(slots=True)
class Uses:
    """Names in a program, as words: lines, programs, locations and variables, and those that it gives a value."""

    lines: list[Word] = field(default_factory=list)
    programs: list[Word] = field(default_factory=list)
    locations: list[Word] = field(default_factory=list)
    new_locations: list[Word] = field(default_factory=list)
    variables: list[Word] = field(default_factory=list)
    new_variables: list[Word] = field(default_factory=list)
    templates: list[Word] = field(default_factory=list)
    signals: list[tuple[str, Word]] = field(default_factory=list)


def elements_of(form: str) -> list[Element]:
    """Return the elements of a form."""
    elements, optional = [], False
    for word in form.replace("[", "[ ").replace("]", " ]").split():
        if word in "[]":
            optional = word == "["
            continue
        many = word.endswith("...")
        name = word.removesuffix("...")
        words = () if name.islower() else tuple(name.split("|"))
        elements.append(Element("word" if words else name, words, many, optional))
    return elements


class Reader:
    """Reader of one statement's arguments; what they name is added to `uses`."""

    def __init__(self, words: list[Word], end: int, uses: Uses, signals: str = "") -> None:
        """Read words; `end` is the place after the last of them, `signals` says whose numbers those of signals are."""
        self.words, self.at, self.end, self.uses, self.signals = words, 0, end, uses, signals

    def arguments(self, elements: list[Element]) -> list[Argument]:
        """Return the arguments that elements ask for; raises WordError where something else stands there."""
        found = [self._element(element) for element in elements]
        if self.at < len(self.words):
            raise WordError(self.words[self.at].at, f"{self.words[self.at].text!r} is too much here")
        return [one for one in found if one is not None]

    def _element(self, element: Element) -> Argument | None:
        if element.kind == "word":
            return self._word(element)
        if element.kind == "assignment":
            return self._assignment()
        if element.optional and self.at >= len(self.words):
            return Argument(element.kind, [] if element.many else None)
        if not element.many:
            return Argument(element.kind, self._one(element.kind))
        listed = [self._one(element.kind)]
        while self.at < len(self.words) and self.words[self.at].text == ",":
            listed.append(self._one(element.kind))
        return Argument(element.kind, listed)

    def _word(self, element: Element) -> Argument | None:
        """Take a word that stands there itself; None for one that has no choice, empty for one that was left out."""
        self._comma()
        if self.at < len(self.words) and self.words[self.at].text in element.words:
            text = self._taken().text
            return Argument("word", text) if element.optional or len(element.words) > 1 else None
        if element.optional and (self.at >= len(self.words) or not element.words[0].isalpha()):
            return Argument("word", "")
        raise self._expected(" or ".join(element.words))

    def _one(self, kind: str) -> Any:  # noqa: ANN401 each kind has its own
        self._comma()
        if self.at >= len(self.words):
            raise self._expected(_SAID[kind])
        word = self.words[self.at]
        read = getattr(self, f"_read_{kind}", None)
        if read is not None:
            return read(word)
        if word.kind == "parameter" and kind not in ("line", "program", "string"):
            return self._taken()
        wanted = {"line": "number", "string": "string"}.get(kind, "name")
        if word.kind != wanted or (kind.endswith("variable") and word.text.startswith("#")):
            raise self._expected(_SAID[kind])
        if kind in ("line", "program", "location", "new_location", "variable", "new_variable", "template"):
            getattr(self.uses, f"{kind}s").append(word)
        return self._taken()

    def _read_number(self, word: Word) -> Evaluate:
        minus = False
        if word.kind == "sign" and word.text in "+-":
            minus = self._taken().text == "-"
            if self.at >= len(self.words):
                raise self._expected(_SAID["number"])
            word = self.words[self.at]
        if word.kind not in ("number", "name", "parameter") or word.text.startswith("#"):
            raise self._expected(_SAID["number"])
        if word.kind == "name":
            self.uses.variables.append(word)
        value = number(self._taken())
        return (lambda value_of: -value(value_of)) if minus else value

    def _read_signal(self, word: Word) -> tuple[Evaluate, bool]:
        on = not (word.kind == "sign" and word.text == "-")
        if word.kind == "sign" and word.text in "+-":
            self._taken()
        if self.at < len(self.words) and self.words[self.at].text.startswith("#"):
            raise self._expected(_SAID["signal"])
        value = self._one_of("number", "name", "parameter", kind="signal")
        if value.kind == "number":
            self.uses.signals.append((self.signals, value))
        elif value.kind == "name":
            self.uses.variables.append(value)
        return number(value), on

    def _read_parameter(self, word: Word) -> Word:
        minus = word.kind == "sign" and word.text == "-"
        if minus:
            self._taken()
        value = self._one_of("number", "name", "parameter", kind="parameter")
        return Word("number", f"-{value.text}", value.at) if minus and value.kind == "number" else value

    def _read_said(self, word: Word) -> Word:
        return self._one_of("text", "string", kind="said")

    def _read_relation(self, word: Word) -> str:
        if word.text not in RELATIONS:
            raise self._expected(_SAID["relation"])
        return RELATIONS[self._taken().text]

    def _one_of(self, *kinds: str, kind: str) -> Word:
        if self.at >= len(self.words) or self.words[self.at].kind not in kinds:
            raise self._expected(_SAID[kind])
        return self._taken()

    def _assignment(self) -> Argument:
        """Return a string or a variable, and the text or the function that it gets."""
        target = self._one_of("name", "string", kind="variable")
        if target.text.startswith("#"):
            raise WordError(target.at, "a location gets its value by SET or HERE, not by !")
        if self.at >= len(self.words) or self.words[self.at].text != "=":
            raise self._expected("'='")
        self._taken()
        if target.kind == "string":
            return Argument("assignment", (target, self._one("said")))
        expression = Expression(self.words, self.at, self.end)
        value = expression.sum()
        self.at = expression.at
        self.uses.new_variables.append(target)
        self.uses.variables += expression.used
        return Argument("assignment", (target, value))

    def _comma(self) -> None:
        if self.at and self.at < len(self.words) and self.words[self.at].text == ",":
            self._taken()

    def _taken(self) -> Word:
        self.at += 1
        return self.words[self.at - 1]

    def _expected(self, what: str) -> WordError:
        if self.at >= len(self.words):
            return WordError(self.end, f"{what} is expected here, and the line ends")
        word = self.words[self.at]
        return WordError(word.at, f"{what} is expected here, not {word.text!r}")
