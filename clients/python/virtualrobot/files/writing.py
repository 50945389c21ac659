"""Files that the kernel gives, written to this machine."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from virtualrobot.errors import InvalidArgumentError, VirtualRobotError
from virtualrobot.files.assets import Assets
from virtualrobot.files.resolver import is_relative
from virtualrobot.v1 import nodes_pb2


def write_beside(
    folder: Path, files: Iterable[nodes_pb2.AssetFile], assets: Assets, *, replace: bool = True
) -> list[Path]:
    """Download files and write them below a folder, by their names; return their paths. Folders in it are made.

    Raises:
        VirtualRobotError: when a name would lead out of the folder; nothing has been written then.
        InvalidArgumentError: when the folder itself is not there.
        InvalidArgumentError: when one cannot be written, or, unless `replace`, when one is there with other bytes.
    """
    files = list(files)
    for file in files:
        # Windows reads backslashes and colons in names as parts of a path.
        if not is_relative(file.uri) or {"\\", ":"} & set(file.uri) or {"", ".", ".."} & set(file.uri.split("/")):
            raise VirtualRobotError(f"the kernel names a file outside the folder {folder}: {file.uri!r}")
    if not replace and (others := [file.uri for file in files if _has_other_bytes(folder / file.uri, file.sha256)]):
        raise InvalidArgumentError(
            f"{folder / others[0]} is there already and is something else: choose another folder"
        )
    check_folder(folder)
    written = []
    for file in files:
        path = folder / file.uri
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InvalidArgumentError(f"{path.parent} cannot be made: {error.strerror or error}") from error
        written.append(write_file(path, assets.download(file.sha256)))
    return written


def check_folder(folder: Path) -> None:
    """Raise InvalidArgumentError when a folder is not there: a name that is not quite right makes no new one."""
    if not folder.is_dir():
        raise InvalidArgumentError(f"the folder {str(folder)!r} is not there; make it first, or choose another one")


def _has_other_bytes(path: Path, sha256: str) -> bool:
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() != sha256


def write_file(path: Path, data: bytes) -> Path:
    """Write a file as a whole or not at all, into a folder that is there; return its path."""
    check_folder(path.parent)
    try:
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(data)
            # mkstemp makes files that only their owner can read; what is saved is an ordinary file.
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(temporary, 0o666 & ~mask)
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise
    except OSError as error:
        raise InvalidArgumentError(f"{path} cannot be written: {error.strerror or error}") from error
    except ValueError as error:  # a NUL in its name
        raise InvalidArgumentError(f"{str(path)!r} cannot be the name of a file: {error}") from error
    return path
