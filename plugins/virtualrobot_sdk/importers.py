"""Interface of an importer: it translates a file of its format into one of those that the kernel reads itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

NATIVE_FORMATS = (".glb", ".urdf", ".yaml")
"""Formats that an importer may translate to: triangles with colours, one robot, or a scene (docs/scene-file.md)."""


@dataclass(frozen=True, slots=True)
class Translation:
    """A file in one of NATIVE_FORMATS, in meters and radians; relative names in it count from the original file."""

    format: str
    """`.glb`, `.urdf` or `.yaml`."""
    data: bytes
    warnings: tuple[str, ...] = ()
    """Oddities of the original that did no harm, in words."""


class Importer(Protocol):
    """Reads files of one or several formats, told by their endings.

    It gets all that it reads as arguments: no file of the disk and no network is touched. Equal calls give equal bytes.
    """

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return the file `uri` with the content `data` in a format that the kernel reads.

        `files` holds the files that it names, by name as written; None for one that was looked for and is nowhere.
        A name in a file that is named itself counts from the original too.

        Raises:
            FilesNeeded: names files that are not in `files` yet; the call is repeated with them.
            ArgumentError: the file is broken; the message says where (line, element, entity) and why. When a file that
                is None in `files` is the cause, its name is told as `missing`: ArgumentError(message, missing=name).
        """
        ...
