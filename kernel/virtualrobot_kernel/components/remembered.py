"""Descriptions of the kernel's own plugins, remembered from start to start so that none has to import them all.

They are what the plugins themselves said, with a stamp of all that it can depend on: their sources and the SDK's, the
interpreter, and which packages are installed. They lie beside the compiled code, and name the files of the plugins'
own: who deletes that code has the next start import the plugins, and compile it before anybody waits for it.
"""

from __future__ import annotations

import hashlib
import logging
import os
import site
import sys
import sysconfig
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import EntryPoint
from importlib.util import find_spec
from pathlib import Path

import msgspec
from virtualrobot_sdk.compiled.cache import cache_directory, files_of_code, processor
from virtualrobot_sdk.worker.blame import package_of
from virtualrobot_sdk.worker.description import Description

from virtualrobot_kernel.whole_files import write_whole

log = logging.getLogger(__name__)

SDK = "virtualrobot_sdk"

NO_SOURCES = {"__pycache__", "node_modules"}
"""Folders of what is made of sources, or builds a page: no plugin imports anything from there."""


@dataclass(frozen=True, slots=True)
class Memory:
    """Contents of the file: the stamp, the files of compiled code that were there, and the descriptions by plugin."""

    stamp: str
    code: tuple[str, ...]
    plugins: dict[str, Description]


def recall(points: Sequence[EntryPoint]) -> dict[str, Description]:
    """Return the descriptions of these plugins by name; none when anything is not as it was, or can't be read."""
    try:
        memory = msgspec.msgpack.decode(_path().read_bytes(), type=Memory)
    except (OSError, msgspec.MsgspecError, UnicodeDecodeError):
        return {}
    as_it_was = memory.stamp == _stamp(points) and all(map(os.path.exists, memory.code))
    return memory.plugins if as_it_was else {}


def remember(points: Sequence[EntryPoint], plugins: Mapping[str, Description]) -> None:
    """Write the descriptions of these plugins, whose code is imported and compiled; where that fails, do without."""
    code = tuple(map(str, files_of_code(*(package_of(point.value) for point in points), SDK)))
    try:
        write_whole(_path(), msgspec.msgpack.encode(Memory(_stamp(points), code, dict(plugins))))
    except OSError as error:
        log.info("what plugins offer is not remembered: %s", error)


def _path() -> Path:
    """Return the file, one for each installation; the sources of this package are in the name of its folder."""
    return cache_directory(Path(__file__).parent) / "plugins.msgpack"


def _stamp(points: Sequence[EntryPoint]) -> str:
    """Return a digest of all that the plugins' descriptions depend on."""
    stamp = hashlib.sha256(repr((sys.version, processor(), [(point.name, point.value) for point in points])).encode())
    installed = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib"), site.getusersitepackages()}
    for folder in sorted(installed):
        if os.path.isdir(folder):
            stamp.update(f"{folder} {os.stat(folder).st_mtime_ns}\n".encode())
    for package in sorted({package_of(point.value) for point in points} | {SDK}):
        spec = find_spec(package)
        for top in spec.submodule_search_locations or () if spec else ():
            for folder, folders, names in os.walk(top):
                folders[:] = sorted({*folders} - NO_SOURCES)
                for name in sorted(names):
                    about = os.stat(os.path.join(folder, name))
                    stamp.update(f"{folder}/{name} {about.st_mtime_ns} {about.st_size}\n".encode())
    return stamp.hexdigest()
