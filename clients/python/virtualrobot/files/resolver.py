"""The one resolver: which file does a URI in a model or scene file mean?

`package://`, `model://`, `file://`, relative and absolute names, as URDF, SDF, mesh and scene files write them. The
client uses it for files on its own machine, the kernel for files on its machine.

Files come from anywhere, and could name any other file of the machine. So what a file names must lie in or below its
own folder (`packages.own_folder`) or a known package, links followed; whether there is a file elsewhere is not told.
What a person names may lie anywhere, unless the resolver was given folders, as a kernel's is: anybody may name files in
calls. Nothing is opened but `package.xml` files, and files whose content is stated.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath, PureWindowsPath
from urllib.parse import unquote

from virtualrobot.files.packages import (
    RELATIVE_LEVELS,
    SEARCH_DEPTH,
    SEARCH_LEVELS,
    declared_name,
    environment_folders,
    folders_by_content,
    installed_folders,
    nearby_folders,
    own_folder,
    python_package_folder,
)

_SCHEME = re.compile(r"^([A-Za-z][A-Za-z0-9+.-]+):(.*)$", re.DOTALL)  # two letters or more: `C:` is a drive
_PACKAGE_SCHEMES = ("package", "model")


class UnresolvedUriError(FileNotFoundError):
    """A URI that names no file here; `tried` lists every place that was looked at, in order."""

    def __init__(self, uri: str, referrer: Path | None, tried: Sequence[Path], hint: str = "") -> None:
        """Say which `uri` of which file (`referrer`) was sought, where (`tried`), and a `hint` what would help."""
        self.uri, self.referrer, self.tried = uri, referrer, tuple(tried)
        named_by = f", named by {referrer}," if referrer is not None else ""
        places = "; tried " + ", ".join(str(place) for place in self.tried) if self.tried else ""
        super().__init__(f"{uri!r}{named_by} is not there{places}" + (f"; {hint}" if hint else ""))


def is_relative(uri: str) -> bool:
    """Return whether `uri` counts from the folder of the file that names it: no scheme, no root, no drive."""
    return not _SCHEME.match(uri) and not PurePosixPath(uri).is_absolute() and not PureWindowsPath(uri).anchor


def join_uri(referrer: str, uri: str) -> str:
    """Return the one name of a file that `referrer` (itself a path or URI) names as `uri`.

    A relative `uri` counts from the referrer's folder, so that `package://a/meshes/x.obj` naming `x.mtl` gives
    `package://a/meshes/x.mtl`; others stand for themselves. Backslashes become slashes; `.` and `..` are worked out.
    """
    uri = uri.replace("\\", "/")
    if not is_relative(uri):
        return uri
    referrer = referrer.replace("\\", "/")
    scheme, separator, path = referrer.rpartition("://")
    parts: list[str] = []
    for part in [*path.split("/")[:-1], *uri.split("/")]:
        if part == ".." and parts and parts[-1] not in ("", ".."):
            parts.pop()
        elif part != "." and (part or not parts):
            parts.append(part)
    return scheme + separator + "/".join(parts)


class _Namer:
    """Origin of a file's name: a person, or a file with the folders that its own files lie below.

    `own` of a person are the folders whose files may be named; None: all. A file on another machine has no own folders,
    and no place (`source`).
    """

    def __init__(self, source: Path | None, own: tuple[Path, ...] | None, *, person: bool = False) -> None:
        self.source, self.own, self.person = source, own, person
        self.starts = [Path.cwd()] if person else [] if source is None else _folders_of(source)

    def may(self, folder: Path) -> bool:
        """Return whether a folder that nothing says to be a package may be taken."""
        return self.own is None or any(_lies_below(folder, own) for own in self.own)


class Resolver:
    """Finds the files that URIs mean, with folders that are told for packages."""

    def __init__(
        self, packages: Mapping[str, str | Path] | None = None, folders: Iterable[str | Path] | None = None
    ) -> None:
        """Take folders by package name, which win over all other places.

        What a person names must lie below one of `folders`, links followed, or in a known package; None: anywhere.
        """
        self.packages = {name: Path(folder) for name, folder in (packages or {}).items()}
        self.folders = None if folders is None else tuple(Path(os.path.abspath(folder)) for folder in folders)
        # A robot has dozens of meshes in one package; its folders are looked for once.
        self._known: dict[tuple, list[Path]] = {}
        # The textures of a mesh may lie beside the robot that names the mesh, so what was found keeps the folders of
        # the file that named it.
        self._own: dict[Path, tuple[Path, ...]] = {}
        self._namers: dict[Path, _Namer] = {}

    def resolve(self, uri: str, referrer: str | Path | None = None, sha256: str = "") -> Path:
        """Return the absolute path of the existing file that `uri` means when the file `referrer` names it.

        Without a referrer it is a person who names it. A relative name counts from the folder of the referrer; when it
        has a folder in it, from the RELATIVE_LEVELS folders above that too. So does an absolute path that is nowhere:
        some models write their own folder as `/`.

        A package is looked for in this order: the folders told to the constructor (and then nowhere else), the
        environment (VIRTUALROBOT_PACKAGE_PATH, ROS_PACKAGE_PATH, AMENT_PREFIX_PATH, and Gazebo's GZ_SIM_RESOURCE_PATH,
        GAZEBO_MODEL_PATH, SDF_PATH), the parents of the referrer (a folder of that name, or one whose package.xml says
        so), an installed Python package of that name (such as `pybullet_data`; it is not imported), ROS distributions
        on this machine (`/opt/ros`). Since many models name a package that differs from its folder, any parent of the
        referrer under which the rest of the URI exists comes next, and last, when no folder is known as the package,
        folders near the referrer under which the rest exists (`packages.folders_by_content`). Names count letter case
        on every system.

        What a file names and lies neither in its own folder nor in a known package is not found, unless it has the
        content that the file states for it (`sha256`): who knows that learns nothing by it.

        Raises:
            UnresolvedUriError: when there is no such file, or several folders near the referrer have it and none has
                more of the package's name than the others; its text lists every place that was tried.
        """
        if referrer is None:
            return self._resolve(uri, _Namer(None, self.folders, person=True), sha256)
        source = Path(referrer).absolute()
        if source not in self._namers:
            self._namers[source] = _Namer(source, self._own.get(source) or self._own_folders(source))
        return self._resolve(uri, self._namers[source], sha256)

    def _own_folders(self, source: Path) -> tuple[Path, ...]:
        """Return the folders that a file's own files lie below; none that is wider than what a person may name."""
        own = dict.fromkeys((own_folder(source), own_folder(source.resolve())))
        if self.folders is None:
            return tuple(own)
        known = self._packages_above(source)
        within = [folder for folder in self.folders if _lies_below(source, folder)]
        narrow: dict[Path, None] = {}
        for folder in own:
            if any(folder.is_relative_to(one) for one in (*within, *known)):
                narrow[folder] = None
            else:
                narrow |= dict.fromkeys((*within, *known))
        return tuple(narrow)

    def may_name(self, file: str | Path) -> bool:
        """Return whether a person may name a file, there or not: it lies below `folders` or in a known package."""
        place = Path(os.path.normpath(file))
        return self.folders is None or any(
            _lies_below(place, folder) for folder in (*self.folders, *self._packages_above(place))
        )

    def resolve_known(self, uri: str) -> Path:
        """Return the file of a known package that a file on another machine names; errors as of `resolve`."""
        return self._resolve(uri, _Namer(None, ()), "")

    def _resolve(self, uri: str, namer: _Namer, sha256: str) -> Path:
        tried: list[Path] = []
        hint, outside = "", False
        for place, roots in self._candidates(uri, namer):
            candidate = Path(os.path.normpath(place))
            if candidate in tried:
                continue
            if roots is not None and not any(_lies_below(place, root) for root in roots):
                outside = True
                if sha256 and _has_content(candidate, sha256):
                    return candidate
                continue
            tried.append(candidate)
            other = _spelled_otherwise(candidate)
            if candidate.is_file() and other is None:
                # What a person names by its path has its own folder, and not all that the person may name.
                if roots is not None and (not namer.person or _package_and_inner(uri)[0]):
                    self._own.setdefault(candidate, roots)
                return candidate
            if other is not None and not hint:
                hint = f"{other} differs in letter case"
        near = [] if hint else self._near(uri, namer)
        if len(near) == 1:
            return near[0]
        if near:
            hint = f"several folders near it have such a file and none has the package's name: {_listed(near)}"
        hint = hint or self._hint(uri, namer)
        if outside and not hint:
            own = f"its own folder ({_listed(namer.own)})" if namer.own else "what came with it"
            hint = f"what a file names must lie in {own} or in a known package"
            if namer.person:
                below = _listed(namer.own or ()) or "no folder"
                hint = (
                    f"what calls name must lie below {below} or in a known package; send the file, or start the kernel "
                    "with --files FOLDER"
                )
        raise UnresolvedUriError(uri, namer.source, tried, hint)

    def _candidates(self, uri: str, namer: _Namer) -> Iterator[tuple[Path, tuple[Path, ...] | None]]:
        """Yield the places where `uri` may be, the best first, each with the folders that it must lie below."""
        match = _SCHEME.match(uri)
        if match is None:
            yield from self._plain(uri, namer)
            return
        scheme, rest = match[1].lower(), match[2]
        if scheme in _PACKAGE_SCHEMES:
            name, inner = _package_and_inner(uri)
            for spelling in dict.fromkeys((inner, unquote(inner))):
                if name and spelling:
                    for folder in self._package_folders(name, namer):
                        yield folder / spelling, (folder,)
        elif scheme == "file":
            path = unquote(rest)
            if path.startswith("//"):
                host, slash, local = path[2:].partition("/")
                # `file://meshes/x.stl` is wrong but common: what should be a host is a folder.
                path = slash + local if host in ("", "localhost") else path[2:]
            if re.match(r"^/[A-Za-z]:[/\\]", path):
                path = path[1:]  # file:///C:/x means C:/x
            yield from self._plain(path, namer)

    def _plain(self, name: str, namer: _Namer) -> Iterator[tuple[Path, tuple[Path, ...] | None]]:
        """Yield the places of a relative or absolute path; backslashes count as slashes where they must."""
        source, own = namer.source, namer.own
        for spelling in dict.fromkeys((name, name.replace("\\", "/"))):
            path = Path(spelling).expanduser() if spelling.startswith("~") else Path(spelling)
            if path.is_absolute():
                yield path, None if own is None else (*own, *self._packages_above(path))
                if source is not None and path.anchor == "/":
                    # Some models write the folder of the model as `/`.
                    inner = path.relative_to("/")
                    yield from ((folder / inner, own) for folder in source.parents[: RELATIVE_LEVELS + 1])
            elif spelling and not PureWindowsPath(spelling).drive:  # a drive of Windows is nowhere on other systems
                yield from ((folder / path, own) for folder in namer.starts)
                if source is not None and len(path.parts) > 1:
                    # Some names count from the folder that a program of their author's was started in.
                    yield from ((folder / path, own) for folder in source.parent.parents[:RELATIVE_LEVELS])

    def _packages_above(self, path: Path) -> list[Path]:
        """Return the folders above a path that are known as packages of their names."""
        anyone = _Namer(None, ())
        known = [*self.packages.values()]
        for folder in Path(os.path.normpath(path)).parents:
            if folder.name:
                known += [place for place in self._folders_known_as(folder.name, anyone) if place == folder]
        return known

    def _package_folders(self, name: str, namer: _Namer) -> Iterator[Path]:
        """Yield the folders that the package `name` may be, the best first."""
        if name in self.packages:
            yield self.packages[name]
            return
        yield from self._folders_known_as(name, namer)
        for start in namer.starts:
            yield from filter(namer.may, (start, *start.parents))

    def _folders_known_as(self, name: str, namer: _Namer) -> list[Path]:
        key = (name, namer.source and namer.source.parent, namer.own)
        if key not in self._known:
            self._known[key] = list(dict.fromkeys(self._found_folders(name, namer)))
        return self._known[key]

    def _found_folders(self, name: str, namer: _Namer) -> Iterator[Path]:
        """Yield the folders that are known as the package `name`, the best first."""
        yield from environment_folders(name)
        for start in namer.starts:
            yield from nearby_folders(name, start, namer.may)
        if (folder := python_package_folder(name)) is not None:
            yield folder
        yield from installed_folders(name)

    def _near(self, uri: str, namer: _Namer) -> list[Path]:
        """Return the files near the referrer that may be meant by the URI of a package that is nowhere."""
        name, inner = _package_and_inner(uri)
        if not inner or namer.source is None or name in self.packages or self._folders_known_as(name, namer):
            return []
        for start in namer.starts:
            folders = folders_by_content(name, unquote(inner), start, namer.may)
            found = [folder / unquote(inner) for folder in folders if _lies_below(folder / unquote(inner), folder)]
            if found:
                return [Path(os.path.normpath(place)) for place in found]
        return []

    def _hint(self, uri: str, namer: _Namer) -> str:
        match = _SCHEME.match(uri)
        scheme = match[1].lower() if match else ""
        if scheme in _PACKAGE_SCHEMES:
            name, inner = _package_and_inner(uri)
            if name in self.packages:
                return ""
            right = f"say where the package {name!r} is, or set VIRTUALROBOT_PACKAGE_PATH to the folder that holds it"
            if known := self._folders_known_as(name, namer):
                return f"the package {name!r} is {known[0]}, without {inner!r}; if another is meant, {right}"
            if not inner or namer.source is None:
                return right
            return (
                f"nor does any folder up to {SEARCH_DEPTH} levels below those {SEARCH_LEVELS} levels above the file "
                f"have {inner!r}; {right}"
            )
        if scheme not in ("", "file"):
            return f"{scheme}:// is not read: use package://, file:// or a path"
        return "it is a path of Windows" if PureWindowsPath(uri).drive and os.name != "nt" else ""


def _package_and_inner(uri: str) -> tuple[str, str]:
    """Return name and rest of a URI with a package; two empty texts for another one."""
    match = _SCHEME.match(uri)
    if match is None or match[1].lower() not in _PACKAGE_SCHEMES:
        return "", ""
    name, _, inner = match[2].replace("\\", "/").lstrip("/").partition("/")
    return ("", "") if name in (".", "..") else (name, inner)


def _listed(places: Sequence[Path]) -> str:
    return ", ".join(map(str, places[:10])) + (f" and {len(places) - 10} more" if len(places) > 10 else "")


def _lies_below(place: Path, folder: Path) -> bool:
    """Return whether a place lies below a folder, links followed, and is not hidden there.

    A workspace of ROS may install a package by links to its sources: those have the same package.xml.
    """
    real, root = Path(os.path.realpath(place)), Path(os.path.realpath(folder))
    if not real.is_relative_to(root):
        name = declared_name(root)
        sources = (above for above in real.parents if name is not None and declared_name(above) == name)
        if not Path(os.path.normpath(place)).is_relative_to(folder) or (root := next(sources, None)) is None:
            return False
    return not any(part.startswith(".") for part in real.relative_to(root).parts)


def _has_content(path: Path, sha256: str) -> bool:
    """Return whether there is a file with this SHA-256."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest() == sha256.lower()
    except OSError:
        return False


def _folders_of(source: Path) -> list[Path]:
    """Return the folder that a file is in, and the one that it is in behind symbolic links."""
    return list(dict.fromkeys((source.parent, source.resolve().parent)))


def _spelled_otherwise(path: Path) -> Path | None:
    """Return the existing path that differs from `path` in letter case only, or None when there is none.

    On a file system that ignores case a wrong spelling is found too; it would not be on another machine.
    """
    if path.exists() and not path.with_name(path.name.swapcase()).exists():
        return None  # this file system tells cases apart
    found = Path(path.anchor)
    for part in path.relative_to(path.anchor).parts:
        try:
            names = os.listdir(found)
        except OSError:
            names = [part] if (found / part).exists() else []  # a folder that may be passed but not listed
        alike = part if part in names else next((name for name in names if name.lower() == part.lower()), None)
        if alike is None:
            return None
        found /= alike
    return None if found == path else found
