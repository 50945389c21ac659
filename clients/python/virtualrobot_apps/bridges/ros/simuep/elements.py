"""Elements of an XML file that know their line: whatever is wrong is told with file, line and what would be right."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from virtualrobot._wire.names import did_you_mean
from virtualrobot.errors import MalformedFileError, MissingFileError

MOST_BYTES = 16 * 2**20
_DEEPEST = 64


@dataclass(eq=False)
class Element:
    """An element of a file.

    Attributes:
        file: name of the file.
        line: from 1.
        tag: its name.
        attributes: texts by name.
        children: elements in it, in their order.
    """

    file: str
    line: int
    tag: str
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)

    def error(self, text: str) -> MalformedFileError:
        """Return the error that says what is wrong here."""
        metadata = {"file": self.file, "line": str(self.line), "path": self.tag}
        return MalformedFileError(f"{self.file}:{self.line}: <{self.tag}>: {text}", metadata=metadata)

    def check(self, attributes: Collection[str] = (), children: Collection[str] = ()) -> None:
        """Refuse attributes and elements that have no place here."""
        for what, given, known in (
            ("attribute", self.attributes, attributes),
            ("element", {one.tag: one for one in self.children}, children),
        ):
            for name in given:
                if name not in known:
                    there = f"known: {', '.join(known)}" if known else "none has a place here"
                    raise self.error(f"there is no {what} {name!r}{did_you_mean(name, known) or ';'} {there}")

    def all(self, tag: str) -> Iterator[Element]:
        """Yield the elements of a name."""
        return (one for one in self.children if one.tag == tag)

    def child(self, tag: str) -> Element | None:
        """Return the element of a name, None where there is none; two are refused."""
        found = list(self.all(tag))
        if len(found) > 1:
            raise found[1].error(f"it stands here twice, first in line {found[0].line}")
        return found[0] if found else None

    def text(self, name: str) -> str:
        """Return an attribute that has to be there, and is not empty."""
        if not (found := self.attributes.get(name, "").strip()):
            raise self.error(f"the attribute {name!r} is missing or empty")
        return found

    def one_of(self, name: str, known: Collection[str], default: str) -> str:
        """Return an attribute that is one of some words."""
        found = self.attributes.get(name, default)
        if found not in known:
            raise self.error(f"{name!r} is {', '.join(known)}, not {found[:40]!r}")
        return found

    def number(self, name: str, default: float, least: float = -math.inf) -> float:
        """Return an attribute that is a number, from `least` on."""
        if name not in self.attributes:
            return default
        (found,) = self._numbers(name, 1)
        if found < least:
            raise self.error(f"{name!r} is {least:g} at least, not {found:g}")
        return found

    def vector(self, name: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """Return an attribute that has as many numbers as `default`, with spaces between them."""
        return self._numbers(name, len(default)) if name in self.attributes else default

    def _numbers(self, name: str, count: int) -> tuple[float, ...]:
        text = self.attributes[name]
        try:
            found = tuple(map(float, text.replace(",", " ").split()))
        except ValueError:
            found = ()
        if len(found) != count or not all(map(math.isfinite, found)):
            wanted = "a number" if count == 1 else f"{count} numbers"
            raise self.error(f"{name!r} is {wanted}, not {text[:60]!r}")
        return found


def read_elements(file: Path) -> Element:
    """Return the root of an XML file.

    Raises:
        MissingFileError: when the file can't be read.
        MalformedFileError: for what is no XML, declares entities, or is too large or too deep, with its line.
    """
    try:
        data = file.read_bytes()
    except OSError as error:
        raise MissingFileError(f"{file} cannot be read: {error.strerror or error}") from error
    return parse_elements(data, file.name)


def parse_elements(data: bytes, name: str) -> Element:
    """Return the root of a document; raises as `read_elements` does."""

    def broken(line: int, text: str) -> MalformedFileError:
        return MalformedFileError(f"{name}:{line}: {text}", metadata={"file": name, "line": str(line), "path": ""})

    if len(data) > MOST_BYTES:
        raise broken(1, f"the file has more than {MOST_BYTES >> 20} MiB")
    parser = expat.ParserCreate()
    top = Element(name, 1, "", {})
    stack = [top]

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(stack) > _DEEPEST:
            raise broken(parser.CurrentLineNumber, f"elements are nested more than {_DEEPEST} deep")
        one = Element(name, parser.CurrentLineNumber, tag, attributes)
        stack[-1].children.append(one)
        stack.append(one)

    def refuse(*_: object) -> None:
        raise broken(parser.CurrentLineNumber, "a scene declares no entities")

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: stack.pop()
    parser.EntityDeclHandler = refuse
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise broken(error.lineno, f"no XML: {expat.ErrorString(error.code)}") from error
    return top.children[0]
