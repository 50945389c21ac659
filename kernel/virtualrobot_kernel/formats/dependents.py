"""Dependencies of a mesh file: materials, textures and buffers, and what those name in turn."""

from __future__ import annotations

from collections.abc import Iterable

from virtualrobot.files.resolver import join_uri

from virtualrobot_kernel.errors import MissingFileError
from virtualrobot_kernel.formats.collada import image_names, material_warnings, parse_collada
from virtualrobot_kernel.formats.files import File, Files
from virtualrobot_kernel.formats.references import buffer_names, counted_from, ending, list_references
from virtualrobot_kernel.formats.xml import FileWarning, place_in


def find_dependents(files: Files, main: File) -> tuple[dict[str, str], list[FileWarning]]:
    """Return the SHA-256 of all that a mesh file names, by name as counted from it, and warnings.

    Raises:
        MissingFileError: for a buffer that is nowhere. A material or texture costs the look only and is a warning.
    """
    found: dict[str, str] = {}
    warnings: list[FileWarning] = []
    _gather(files, main, main, found, warnings)
    return found, warnings


def _gather(files: Files, main: File, file: File, found: dict[str, str], warnings: list[FileWarning]) -> None:
    """Read what `file` names, by name as counted from the main file, and what those files name."""
    for name in _named(file, warnings):
        known_as = name if file is main else counted_from(main.key, join_uri(file.key, name))
        if known_as in found:
            continue
        try:
            dependent = _read(files, name, file.key)
        except MissingFileError as error:
            if name in buffer_names(file.data, file.key):
                raise
            warnings.append(FileWarning(f"{place_in(file.key, None)}: {error}; drawn without it", file.key))
            continue
        found[known_as] = dependent.sha256
        _gather(files, main, dependent, found, warnings)


def _named(file: File, warnings: list[FileWarning]) -> Iterable[str]:
    """Return the references of a file; a COLLADA document is parsed once for that and for its warnings."""
    if ending(file.key) != ".dae":
        return list_references(file.data, file.key)
    root = parse_collada(file.data, file.key)
    warnings.extend(material_warnings(root, file.key))
    return [name for name in dict.fromkeys(image_names(root)) if name]


def _read(files: Files, name: str, referrer: str) -> File:
    """Return the file by its name, or one of that name beside its referrer: exporters write their own disk's paths."""
    try:
        return files.read(name, referrer)
    except MissingFileError:
        beside = name.rpartition("/")[2]
        if beside == name or not beside:
            raise
        try:
            return files.read(beside, referrer)
        except MissingFileError:
            pass  # the first error says more
        raise
