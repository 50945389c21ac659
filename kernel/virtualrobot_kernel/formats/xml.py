"""XML files of the kernel: elements, and errors and warnings with file and line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from posixpath import basename

from virtualrobot_sdk import xml
from virtualrobot_sdk.xml import Element, local_name

from virtualrobot_kernel.errors import KernelError, MalformedFileError


def parse_xml(data: bytes, uri: str, *, huge: bool = False) -> Element:
    """Return the root element of a document, read as `virtualrobot_sdk.xml` does.

    Raises MalformedFileError when the bytes are no XML, or declare entities.
    """
    try:
        return xml.parse_xml(data, huge=huge)
    except xml.XmlError as error:
        raise malformed(uri, error.line, str(error)) from error


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
        if element.prefix == "xacro" or (element.prefix and "xacro" in str(element.tag).partition("}")[0]):
            return element, f"<xacro:{local_name(element)}>"
        for name, value in element.attrib.items():
            if "$(" in value or "${" in value:
                return element, f"{name}={value!r}"
        stack.extend(child for child in reversed(element) if child.tag not in ("gazebo", "transmission"))
    return None
