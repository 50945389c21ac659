"""XML read safely: no entities, no network, and every error with file and line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from posixpath import basename
from typing import Any, TypeAlias

from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]  compiled, and has no types

from virtualrobot_kernel.errors import KernelError, MalformedFileError

Element: TypeAlias = Any
"""Element of lxml, which has neither types nor a public name for it."""

_DECLARATION = re.compile(rb"^(?:\xef\xbb\xbf)?(\s*<\?xml\b[^>]*\?>)")
_UNDECLARED = re.compile(r"Namespace prefix (drake|sensor|controller|interface|body|geom|joint|model|rendering) ")
_ENCODING = re.compile(rb"""encoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")


def parse_xml(data: bytes, uri: str, *, huge: bool = False) -> Element:
    """Return the root element of a document; `huge` lifts lxml's limit of 10 MB a text.

    A declaration that the standard refuses but that real models carry (`version="0.0"`, blank lines before it) is
    passed over, and so is that nobody has declared a prefix of Drake's or of Gazebo's before 1.0 (`sensor:ray`). Raises
    MalformedFileError when the bytes are no XML, or declare entities.
    """
    text = _utf8(data, uri)
    declared = text.find(b"<!ENTITY")
    if declared >= 0:
        line = text[:declared].count(b"\n") + 1
        raise malformed(uri, line, "the document declares entities (<!ENTITY ...>); write their text out instead")
    parser = _parser(huge)
    try:
        return etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        if all(_UNDECLARED.match(entry.message) for entry in parser.error_log):
            return etree.fromstring(text, _parser(huge, recover=True))
        raise malformed(uri, error.lineno or 1, f"not XML: {error.msg}") from error


def _parser(huge: bool, recover: bool = False) -> etree.XMLParser:
    safe = {"resolve_entities": False, "no_network": True, "load_dtd": False, "huge_tree": huge}
    return etree.XMLParser(recover=recover, encoding="utf-8", **safe)


def _utf8(data: bytes, uri: str) -> bytes:
    """Return the document as UTF-8 with its declaration blanked out, so that line numbers stay."""
    declaration = _DECLARATION.match(data)
    encoding = "utf-8"
    if declaration:
        named = _ENCODING.search(declaration[1])
        encoding = named[1].decode("ascii") if named else encoding
        data = b"\n" * declaration[1].count(b"\n") + data[declaration.end() :]
    elif data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        encoding = "utf-16"
    try:
        return data.decode(encoding).removeprefix("\ufeff").encode()
    except LookupError as error:
        raise malformed(uri, 1, f"unknown encoding {encoding!r}") from error
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise malformed(uri, line, f"not text in {encoding}: {error.reason}") from error


def malformed(uri: str, line: int | None, message: str, path: str = "") -> MalformedFileError:
    """Return the error `file:line: path: message`; metadata has the whole URI."""
    where = place_in(uri, line, path)
    return MalformedFileError(f"{where}: {message}", file=uri, line=line or "", path=path)


class FileWarning(str):
    """Oddity of a file that does no harm to the motion of what it describes, as a text for people.

    Attributes:
        file: the whole name of the file.
        line: from 1; 0 where none is known.
    """

    __slots__ = ("file", "line")
    file: str
    line: int

    def __new__(cls, text: str, file: str = "", line: int = 0) -> FileWarning:
        """Return the warning about a line of a file; `text` names both, since errors do so too."""
        warning = super().__new__(cls, text)
        warning.file, warning.line = file, line
        return warning

    @classmethod
    def of(cls, error: KernelError, more: str = "") -> FileWarning:
        """Return an error's message as a warning, `more` behind it."""
        return cls(f"{error}{more}", error.metadata.get("file", ""), int(error.metadata.get("line") or 0))

    @classmethod
    def told(cls, text: str, uri: str) -> FileWarning:
        """Return the text of an importer of the file `uri`, which begins with `name: ` or `name:line: `."""
        line = re.match(r"[^:]+:(\d+): ", text)
        return cls(text, uri, int(line[1]) if line else 0)


def refuse_warnings(warnings: Sequence[FileWarning]) -> None:
    """Raise MalformedFileError for the first warning: what is loaded strictly has none."""
    if warnings:
        more = f" (and {len(warnings) - 1} more warnings)" if len(warnings) > 1 else ""
        first = warnings[0]
        raise MalformedFileError(f"{first}{more}", file=first.file, line=first.line or "")


def place_in(uri: str, line: int | None, path: str = "") -> str:
    """Return `file:line: path` for people; the file by its name without folders."""
    file = basename(uri.replace("\\", "/")) or uri or "the text"
    file += f":{line}" if line is not None else ""
    return f"{file}: {path}" if path else file


def line_of(element: Element) -> int:
    """Return the line on which the element begins, from 1."""
    return element.sourceline or 1


def local_name(element: Element) -> str:
    """Return the tag without its namespace."""
    return etree.QName(element).localname


def children(element: Element, tag: str) -> Iterator[Element]:
    """Yield the child elements with this tag, in the order of the file."""
    return element.iterchildren(tag)


def xacro_in(root: Element) -> tuple[Element, str] | None:
    """Return the first element of a URDF document that is xacro or has xacro in an attribute, and what; None for none.

    What simulators are told (`<gazebo>`, `<transmission>`) does not count: there `$(...)` is somebody else's.
    """
    stack = [root]
    while stack:
        element = stack.pop()
        if not isinstance(element.tag, str):
            continue
        if element.prefix == "xacro" or (element.prefix and "xacro" in etree.QName(element).namespace):
            return element, f"<xacro:{local_name(element)}>"
        for name, value in element.attrib.items():
            if "$(" in value or "${" in value:
                return element, f"{name}={value!r}"
        stack.extend(child for child in reversed(element) if child.tag not in ("gazebo", "transmission"))
    return None
