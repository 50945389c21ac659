"""XML files of importers: every error with file and line."""

from __future__ import annotations

from collections.abc import Iterator

from virtualrobot_sdk import xml
from virtualrobot_sdk.xml import Element

from virtualrobot_plugins.importers.refusal import library, refusal


def parse_xml(data: bytes, uri: str, ending: str, extra: str, *, huge: bool = False) -> Element:
    """Return the root element of a document, read as `virtualrobot_sdk.xml` does.

    `ending` and `extra` say what reads it and how to install lxml.

    Raises:
        ArgumentError: when the bytes are no XML, or declare entities.
    """
    library("lxml.etree", ending, extra)
    try:
        return xml.parse_xml(data, huge=huge)
    except xml.XmlError as error:
        raise refusal(uri, str(error), error.line) from error


def children(element: Element, tag: str) -> Iterator[Element]:
    """Yield the child elements with this tag, whatever their namespace, in the order of the file."""
    return element.iterchildren(f"{{*}}{tag}")
