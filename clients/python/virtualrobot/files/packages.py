"""Folders of packages: ROS, Gazebo, folders around a file, installed Python packages; and the own folder of a file."""

from __future__ import annotations

import importlib.util
import os
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

SEARCH_LEVELS = 3
"""Number of folders above that of the file in which a search for a package of another name begins too."""

SEARCH_DEPTH = 2
"""Depth in folders of that search below each of those."""

SEARCH_FOLDERS = 2000
"""Largest number of folders that it looks at below each of those."""

RELATIVE_LEVELS = 2
"""Number of folders above that of the file that a relative name may count from."""

PACKAGE_LEVELS = 4
"""Number of folders above a file that may be the folder of its package."""

PACKAGE_FILES = ("package.xml", "model.config")
"""Files that lie in the folder of a package of ROS or a model of Gazebo."""

ROS_FOLDER = Path("/opt/ros")
"""Folder in which distributions of ROS are installed on Linux."""

CMEEL_FOLDER = "cmeel.prefix/share"
"""Folder beside Python's packages in which cmeel installs packages of ROS, such as example-robot-data."""

# Each lists folders that are packages or hold packages, as ROS 1 reads ROS_PACKAGE_PATH.
_FOLDER_VARIABLES = ("VIRTUALROBOT_PACKAGE_PATH", "ROS_PACKAGE_PATH")
# Each lists folders that hold models, as Gazebo and libsdformat read them; in URDF files they take packages for models.
_MODEL_VARIABLES = ("GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH", "SDF_PATH")
_CRAWL_DEPTH = 3  # workspace/src, repository, package: deeper ones are rare and a crawl of a home folder takes long
_NAME = re.compile(r"<name>\s*([^<\s]+)\s*</name>")
_NOT_PACKAGES = {"node_modules", "__pycache__", "build", "install", "log"}
# Folders that lie in that of a model, by the names that they have in packages of robots.
_PARTS = re.compile(
    r"(urdf|xacro|sdf|srdf|mjcf|mesh|visual|collision|texture|material|image|media|config|launch|stl|dae|obj)(e?s)?",
    re.IGNORECASE,
)


def own_folder(path: Path) -> Path:
    """Return the folder that the own files of a model or mesh lie in or below.

    The nearest of the PACKAGE_LEVELS folders above it that is a package (`is_package`), else the installed Python
    package that it lies in, else the nearest above it whose name is not that of a part (`meshes`, `urdf`, ...). Never a
    folder that many things share, such as that of a user, unless the file lies right in it.
    """
    parents = path.parents[:PACKAGE_LEVELS]
    marked = next((folder for folder in parents if is_package(folder)), None) or _python_package_above(path)
    if marked is not None:
        return marked
    folder = path.parent
    for above in parents[1:]:
        if not _PARTS.fullmatch(folder.name) or is_shared(above):
            break
        folder = above
    return folder


def is_package(folder: Path) -> bool:
    """Return whether a folder says that it is a package of ROS or a model of Gazebo."""
    return any((folder / name).is_file() for name in PACKAGE_FILES)


def is_shared(folder: Path) -> bool:
    """Return whether many things share a folder: the disk's root and what is right in it, and that of a user."""
    home = Path.home()
    return len(folder.parts) <= 2 or home.is_relative_to(folder) or str(folder.parent) in ("/home", "/Users")


def _python_package_above(path: Path) -> Path | None:
    for entry in map(Path, filter(None, sys.path)):
        if path.is_relative_to(entry):
            top = entry / path.relative_to(entry).parts[0]
            if (top / "__init__.py").is_file():
                return top
    return None


def environment_folders(name: str) -> Iterator[Path]:
    """Yield the folders that the environment gives to the package `name`."""
    for variable in _FOLDER_VARIABLES:
        for entry in filter(None, os.environ.get(variable, "").split(os.pathsep)):
            yield from _crawl(name, Path(entry), _CRAWL_DEPTH)
    for entry in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        folder = Path(entry) / "share" / name
        if folder.is_dir():
            yield folder
    for variable in _MODEL_VARIABLES:
        for entry in filter(None, os.environ.get(variable, "").split(os.pathsep)):
            if (Path(entry) / name).is_dir():
                yield Path(entry) / name


def installed_folders(name: str) -> Iterator[Path]:
    """Yield the folders of the package `name` in the ROS distributions of this machine, the last in the alphabet first.

    They are looked at although nobody has sourced their setup file.
    """
    if sys.platform.startswith("linux"):
        for distribution in reversed(_children(ROS_FOLDER)):
            folder = distribution / "share" / name
            if folder.is_dir():
                yield folder


def nearby_folders(name: str, start: Path, may: Callable[[Path], bool]) -> Iterator[Path]:
    """Yield the folders that may be the package `name`, from `start` upwards.

    At each level: the folder itself when its package.xml says so or it has that name, a folder of that name in it, and
    folders in it whose package.xml says so. One that only has the name must be a package, or one that `may` be taken.
    """
    for folder in (start, *start.parents):
        for named in (folder, folder / name):
            called = named.name == name and named.is_dir() and (is_package(named) or may(named))
            if called or declared_name(named) == name:
                yield named
        if folder != folder.parent:  # not every folder of the disk's root
            yield from (child for child in _children(folder) if child.name != name and declared_name(child) == name)


def folders_by_content(name: str, inner: str, start: Path, may: Callable[[Path], bool]) -> list[Path]:
    """Return the folder near `start` that must be the package `name`, since the file `inner` exists under it.

    Many models name a package that differs from its folder. From `start` and each of SEARCH_LEVELS folders above it the
    folders down to SEARCH_DEPTH below are looked at, SEARCH_FOLDERS of them at most; the first level at which there is
    any decides. Only packages count, and folders that `may` be taken. Of several there the one is meant whose path
    shares the most words with the package's name (`kuka_kr6` for `kuka_kr6_support`). Where that leaves several, all
    are returned: which one is meant cannot be known.
    """
    wanted = _words(name)
    for level in (start, *start.parents[:SEARCH_LEVELS]):
        if level == level.parent:
            break  # not every folder of the disk's root
        shared = {
            folder: len(wanted & _words("/".join(folder.relative_to(level).parts)))
            for folder in _below(level)
            if (folder / inner).is_file() and (is_package(folder) or may(folder))
        }
        if shared:
            return [folder for folder, count in shared.items() if count == max(shared.values())]
    return []


def _words(name: str) -> set[str]:
    return set(filter(None, re.split(r"[^a-z0-9]+", name.lower())))


def _below(root: Path) -> Iterator[Path]:
    """Yield a folder and those below it, level by level, each by name."""
    level, looked_at = [root], 0
    for _ in range(SEARCH_DEPTH + 1):
        below: list[Path] = []
        for folder in level:
            if looked_at >= SEARCH_FOLDERS:
                return
            looked_at += 1
            yield folder
            below.extend(_children(folder))
        level = below


def python_package_folder(name: str) -> Path | None:
    """Return the folder of the installed Python package `name` without importing it, or None.

    A folder without `__init__.py` is none: any folder in the working folder would be one. A name that Python has no
    packages of may be one of ROS that lies among Python's, as those do that come with Pinocchio (`CMEEL_FOLDER`).
    """
    if not name.isidentifier():
        folders = (Path(place) / CMEEL_FOLDER / name for place in sys.path)
        return next((folder for folder in folders if is_package(folder)), None)
    try:
        spec = importlib.util.find_spec(name)
    except (ImportError, ValueError):  # ValueError: a module of this name is loaded and has no spec
        return None
    locations = spec.submodule_search_locations if spec is not None and spec.origin is not None else None
    return Path(next(iter(locations))) if locations else None


def declared_name(folder: Path) -> str | None:
    """Return the name that the folder's package.xml declares, or None."""
    try:
        text = (folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    match = _NAME.search(text)
    return match[1] if match else None


def _crawl(name: str, folder: Path, depth: int) -> Iterator[Path]:
    """Yield the package `name` in a folder of packages, this folder included."""
    declared = declared_name(folder)
    if folder.name == name or declared == name:
        if folder.is_dir():
            yield folder
    elif declared is None and depth > 0:  # packages do not hold packages
        for child in _children(folder):
            yield from _crawl(name, child, depth - 1)


def _children(folder: Path) -> list[Path]:
    """Return the folders in a folder, by name, without hidden ones and those that never hold a package's sources."""
    try:
        with os.scandir(folder) as entries:
            names = [e.name for e in entries if not e.name.startswith(".") and e.is_dir()]
    except OSError:
        return []
    return [folder / name for name in sorted(names) if name not in _NOT_PACKAGES]
