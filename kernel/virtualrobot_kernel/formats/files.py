"""Sources of a model's files: what the client has uploaded first, then the kernel's disk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

from virtualrobot.files.resolver import Resolver, UnresolvedUriError, is_relative, join_uri

from virtualrobot_kernel.errors import MissingFileError
from virtualrobot_kernel.formats.assets import AssetStore


@dataclass(frozen=True, slots=True)
class File:
    """File that was read.

    `key` is its one name: the name under which it was uploaded, or its absolute path on the kernel's disk. The names
    that the file itself mentions count from there.
    """

    key: str
    data: bytes
    sha256: str


@dataclass(frozen=True, slots=True)
class Files:
    """Files that one request may name.

    Attributes:
        store: keeps everything that is read.
        uploaded: SHA-256 by name, as the client gave them; a nested name is joined: a mesh `package://a/meshes/x.obj`
            that names `x.mtl` has it under `package://a/meshes/x.mtl`. The name as written in the file works too.
        resolver: finds files on the kernel's disk; None forbids the disk.
    """

    store: AssetStore
    uploaded: Mapping[str, str] = field(default_factory=dict)
    resolver: Resolver | None = None

    def read(self, uri: str, referrer: str = "", sha256: str = "") -> File:
        """Return the file that `referrer` (the key of the file that names it; empty: the request) names as `uri`.

        What a file names must lie in its own folder or in a known package, or have the content that it states for it
        (`sha256`); see `virtualrobot.files.resolver`. An uploaded file has no folder on the kernel's disk, nor has one
        that says to lie where requests may name nothing.

        Raises:
            MissingFileError: when it is neither uploaded nor found; the message names the file, who names it and each
                place that was tried.
            KernelError: TOO_LARGE over the limit of the store; UNKNOWN_ASSET when what was stated as uploaded is not.
        """
        names = list(dict.fromkeys((join_uri(referrer, uri), uri, unquote(join_uri(referrer, uri)))))
        for name in names:
            if name in self.uploaded:
                held = self.uploaded[name].lower()
                return File(name, self.store.get(held), held)
        tried = [f"uploaded as {name!r}" for name in names] if self.uploaded else []
        path = self._find(uri, referrer, sha256, tried)
        self.store.check_size(path.stat().st_size, str(path))
        try:
            data = path.read_bytes()
        except OSError as error:
            raise _missing(uri, referrer, [f"{path} ({error.strerror or error})"]) from error
        return File(str(path), data, self.store.put(data))

    def _find(self, uri: str, referrer: str, sha256: str, tried: list[str]) -> Path:
        """Return the file's path on the disk; raise MissingFileError when it is nowhere."""
        if self.resolver is None:
            raise _missing(uri, referrer, [*tried, "the kernel's disk is not looked at"])
        try:
            if not referrer:
                return self.resolver.resolve(uri)
            if referrer not in self.uploaded and Path(referrer).is_absolute() and self.resolver.may_name(referrer):
                return self.resolver.resolve(uri, referrer, sha256)
            if is_relative(uri):
                # Its folder is on the client's machine; the kernel's own working folder has nothing to do with it.
                raise _missing(uri, referrer, tried)
            return self.resolver.resolve_known(uri)
        except UnresolvedUriError as error:
            raise _missing(uri, referrer, [*tried, *map(str, error.tried)], str(error)) from error
        except (OSError, ValueError) as error:  # a name too long, a null character, a folder that may not be read
            raise _missing(uri, referrer, [*tried, str(error)]) from error


def _missing(uri: str, referrer: str, tried: list[str], resolved: str = "") -> MissingFileError:
    """Return the error for a file that is nowhere; `resolved` is what the resolver says about it."""
    named_by = f", named by {referrer}," if referrer else ""
    places = ", ".join(tried) or "nothing: it was not uploaded"
    message = resolved or f"{uri!r}{named_by} is not there; tried {places}"
    return MissingFileError(message, file=uri, referrer=referrer, tried=places)
