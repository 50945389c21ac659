"""XML read safely: no entities, no network, every fault with its line. The kernel's readers and importers share it."""

from __future__ import annotations

import re
from typing import Any, TypeAlias

Element: TypeAlias = Any
"""Element of lxml, which has neither types nor a public name for it."""

_DECLARATION = re.compile(rb"^(?:\xef\xbb\xbf)?(\s*<\?xml\b[^>]*\?>)")
_UNDECLARED = re.compile(r"Namespace prefix (drake|sensor|controller|interface|body|geom|joint|model|rendering) ")
_ENCODING = re.compile(rb"""encoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")


class XmlError(ValueError):
    """Fault of a document: no XML, or one that declares entities.

    Attributes:
        line: from 1.
    """

    def __init__(self, message: str, line: int) -> None:
        """Keep `message` for people and the line."""
        super().__init__(message)
        self.line = line


def parse_xml(data: bytes, *, huge: bool = False) -> Element:
    """Return the root element of a document, without comments; `huge` lifts lxml's limit of 10 MB a text.

    A declaration that the standard refuses but that real models carry (`version="0.0"`, blank lines before it) is
    passed over, and so is that nobody has declared a prefix of Drake's or of Gazebo's before 1.0 (`sensor:ray`).

    Raises:
        XmlError: when the bytes are no XML, or declare entities.
        ImportError: when lxml is not installed.
    """
    from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]  compiled, and has no types

    text = _utf8(data)
    declared = text.find(b"<!ENTITY")
    if declared >= 0:
        line = text[:declared].count(b"\n") + 1
        raise XmlError("the document declares entities (<!ENTITY ...>); write their text out instead", line)
    safe = {"resolve_entities": False, "no_network": True, "load_dtd": False, "huge_tree": huge, "encoding": "utf-8"}
    safe |= {"remove_comments": True, "remove_pis": True}
    parser = etree.XMLParser(**safe)
    try:
        return etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        if all(_UNDECLARED.match(entry.message) for entry in parser.error_log):
            return etree.fromstring(text, etree.XMLParser(recover=True, **safe))
        raise XmlError(f"not XML: {error.msg}", error.lineno or 1) from error


def _utf8(data: bytes) -> bytes:
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
        raise XmlError(f"unknown encoding {encoding!r}", 1) from error
    except UnicodeDecodeError as error:
        raise XmlError(f"not text in {encoding}: {error.reason}", data[: error.start].count(b"\n") + 1) from error


def line_of(element: Element) -> int:
    """Return the line on which the element begins, from 1."""
    return element.sourceline or 1


def local_name(element: Element) -> str:
    """Return the tag without its namespace."""
    return str(element.tag).rpartition("}")[2]
