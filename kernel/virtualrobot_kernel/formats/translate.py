"""Files of formats that the kernel does not read itself: importers translate them to one that it does.

Importers are components of plugins and may run in processes of their own; they get bytes and give bytes. What a file
names they ask for, and the kernel looks for it as for everything else.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn, Protocol

from virtualrobot_sdk.errors import ArgumentError, FilesNeeded
from virtualrobot_sdk.importers import Translation
from virtualrobot_sdk.models import Model

from virtualrobot_kernel.errors import KernelError, MalformedFileError, MissingFileError, Reason
from virtualrobot_kernel.formats.assets import MEBIBYTE
from virtualrobot_kernel.formats.files import File, Files
from virtualrobot_kernel.formats.xml import FileWarning, place_in

ROUNDS = 100
"""Greatest number of times that an importer may ask for files: each round may name many."""

MOST_BYTES = {".urdf": 64 * MEBIBYTE, ".yaml": 32 * MEBIBYTE, ".glb": 1024 * MEBIBYTE}
"""Greatest size of a translation (bytes), by its ending: the kernel parses it itself. Readers have their own bounds."""

Settings = Mapping[str, Any]
"""Importer's settings, plain values as JSON has them."""


class Importers(Protocol):
    """Protocol of the importers of all plugins, and of the models that these know by name; any thread may call."""

    @property
    def models(self) -> Mapping[str, Model]:
        """Models by name, whether their files are installed or not."""
        ...

    @property
    def endings(self) -> tuple[str, ...]:
        """Endings of the files that are read, in small letters with their dot; `.urdf` is for xacro in URDF."""
        ...

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], settings: Settings) -> Translation:
        """Return the file in a native format, by the importer that reads the ending of `uri`.

        Raises:
            FilesNeeded: for files that are not in `files`, by name; the call is made again with them.
            ArgumentError: for a file or settings that it refuses; KernelError for a fault of the importer.
        """
        ...


@dataclass(frozen=True, slots=True)
class NoImporters:
    """Importers of a kernel without plugins: native formats alone."""

    endings: tuple[str, ...] = ()
    models: Mapping[str, Model] = field(default_factory=dict)

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], settings: Settings) -> Translation:
        """Raise MalformedFileError."""
        raise MalformedFileError(f"no importer reads {uri}", file=uri)


@dataclass(frozen=True, slots=True)
class Translated:
    """Translation of a file, and the files that went into it.

    Attributes:
        file: the original.
        format: `.glb`, `.urdf` or `.yaml`.
        data: the file in that format; relative names in it count from the original.
        files: SHA-256 of the files that the original names and that were found, by name as asked for.
        warnings: what was odd.
        settings: with which the importer worked.
    """

    file: File
    format: str
    data: bytes
    files: tuple[tuple[str, str], ...]
    warnings: tuple[FileWarning, ...]
    settings: Settings

    def as_file(self) -> File:
        """Return the translation under the original's name."""
        return File(self.file.key, self.data, self.file.sha256)


def translate(importers: Importers, file: File, files: Files, settings: Settings | None = None) -> Translated:
    """Return a file translated to a native format; what it names is read through `files`.

    Raises:
        MalformedFileError: when the importer refuses the file; the message names it.
        MissingFileError: when it cannot do without a file that is nowhere; the message says what was tried.
        KernelError: PLUGIN_FAILED when the importer asks again for what it has, or without end.
    """
    found: dict[str, str] = {}
    missing: dict[str, MissingFileError] = {}

    def read(name: str) -> bytes | None:
        try:
            dependent = files.read(name, file.key)
        except MissingFileError as error:
            missing[name] = error
            return None
        found[name] = dependent.sha256
        return dependent.data

    try:
        translation = run(importers, file.data, file.key, read, settings or {})
    except KernelError as error:
        absent = missing.get(error.metadata.get("missing", ""))
        if absent is None:
            raise
        raise absent.at(str(error)) from error
    return Translated(
        file,
        translation.format,
        translation.data,
        tuple(found.items()),
        tuple(FileWarning.told(text, file.key) for text in translation.warnings),
        settings or {},
    )


def run(
    importers: Importers, data: bytes, uri: str, read: Callable[[str], bytes | None], settings: Settings
) -> Translation:
    """Return what an importer makes of a file; `read` gives what it asks for, None for what is nowhere.

    Raises MalformedFileError when it refuses the file, and KernelError (PLUGIN_FAILED) when it asks without end.
    """
    known: dict[str, bytes | None] = {}
    for _ in range(ROUNDS):
        try:
            translation = importers.translate(data, uri, known, settings)
            size, most = len(translation.data), MOST_BYTES[translation.format]
            if size > most:
                what = f"its translation to {translation.format} has {size} bytes; at most {most} are read"
                reason = Reason.TOO_LARGE
                raise KernelError(f"{place_in(uri, None)}: {what}", reason=reason, size_bytes=size, limit_bytes=most)
            return translation
        except FilesNeeded as needed:
            new = [name for name in dict.fromkeys(needed.names) if name not in known]
            if not new:
                _failed(uri, f"asks again for {', '.join(map(repr, needed.names)) or 'nothing'}, which it has")
            known.update((name, read(name)) for name in new)
        except ArgumentError as error:
            raise _refused(uri, str(error), error.metadata) from error
        except KernelError as error:
            if error.reason is not Reason.INVALID_ARGUMENT:
                raise
            raise _refused(uri, str(error), error.metadata) from error
    _failed(uri, f"asks for more and more files: {len(known)} in {ROUNDS} rounds")


def _refused(uri: str, message: str, metadata: Mapping[str, str]) -> MalformedFileError:
    """Return an importer's refusal, with the name of the file before it where the importer does not begin with one."""
    name = place_in(uri, None)
    text = message if message.startswith(name) or "file" in metadata else f"{name}: {message}"
    error = MalformedFileError(text, file=uri)
    error.metadata.update(metadata)
    return error


def _failed(uri: str, what: str) -> NoReturn:
    raise KernelError(f"{place_in(uri, None)}: the importer {what}", reason=Reason.PLUGIN_FAILED, file=uri)
