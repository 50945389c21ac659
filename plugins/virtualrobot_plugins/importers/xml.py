"""XML read safely: no entities, no network, and every error with file and line."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias

from virtualrobot_plugins.importers.refusal import library, refusal

Element: TypeAlias = Any
"""An lxml element; lxml is imported only when a document is read."""


def parse_xml(data: bytes, uri: str, ending: str, extra: str, *, huge: bool = False) -> Element:
    """Return the root element of a document.

    `ending` and `extra` say what reads it and how to install lxml; `huge` lifts lxml's limit of 10 MB a text.

    Raises:
        ArgumentError: when the bytes are no XML, or declare entities.
    """
    etree = library("lxml.etree", ending, extra)
    declared = data.find(b"<!ENTITY")
    if declared >= 0:
        line = data[:declared].count(b"\n") + 1
        raise refusal(uri, "the document declares entities (<!ENTITY ...>); write their text out instead", line)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=huge, remove_comments=True, remove_pis=True
    )
    try:
        return etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise refusal(uri, f"not XML: {error.msg}", error.lineno or 1) from error
    except ValueError as error:
        raise refusal(uri, f"not XML: {error}") from error


def children(element: Element, tag: str) -> Iterator[Element]:
    """Yield the child elements with this tag, whatever their namespace, in the order of the file."""
    return element.iterchildren(f"{{*}}{tag}")


def line_of(element: Element) -> int:
    """Return the line on which the element begins, from 1."""
    return element.sourceline or 1


def local_name(element: Element) -> str:
    """Return the tag without its namespace."""
    return str(element.tag).rpartition("}")[2]
