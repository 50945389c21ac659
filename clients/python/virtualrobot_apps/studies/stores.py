"""Stores of studies: a folder, or one in a bucket of S3, into which the workers of a cluster write by themselves.

What is written is there whole or not at all.
"""

from __future__ import annotations

import importlib.util
import io
import os
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from virtualrobot.errors import WrongStateError

if TYPE_CHECKING:
    from obstore.store import S3Store

SCHEME = "s3://"
_UNWRITTEN_SECONDS = 3600.0
"""Age (s) from which a file that is not whole yet won't be so: another run may be at younger ones."""
_TRIES = 5
_LONGEST_SECONDS = 30.0


class Store(Protocol):
    """Files by name; a name may have folders in front, with slashes.

    All but `where` raise OSError, in words, when the place can't be reached.
    """

    def make(self) -> None:
        """Make what must be there before anything is written."""
        ...

    def names(self, folder: str) -> list[str]:
        """Return the names, sorted, without the folder, of the files in a folder."""
        ...

    def has(self, name: str) -> bool:
        """Return whether there is such a file."""
        ...

    def open(self, name: str) -> Path | io.BytesIO:
        """Return what a reader takes: the file itself, or all that is in it. Raise FileNotFoundError without one."""
        ...

    def read(self, name: str) -> bytes:
        """Return what is in a file; raise FileNotFoundError without one."""
        ...

    def write(self, name: str, content: bytes) -> None:
        """Write a file, in the place of one that is there."""
        ...

    def add(self, name: str, content: bytes) -> None:
        """Write a file of which any writer writes the same: one of them is kept."""
        ...

    def remove(self, name: str) -> None:
        """Remove a file, if it is there."""
        ...

    def where(self, name: str = "") -> str:
        """Return the place of a file, or of all of them, for people."""
        ...

    def scratch(self) -> Path:
        """Return a folder of this machine for what a worker leaves as it dies; it is there."""
        ...


def store_of(place: Path | str) -> Store:
    """Return the store at a place: a folder, or `s3://BUCKET/FOLDER`.

    Raises:
        WrongStateError: when nobody can write there: no bucket is named, or the library that would do it is missing.
    """
    if isinstance(place, Path) or not place.startswith(SCHEME):
        return Folder(Path(place))
    if not place.removeprefix(SCHEME).partition("/")[0]:
        raise WrongStateError(f"{place!r} names no bucket: {SCHEME}BUCKET/FOLDER belongs here")
    if importlib.util.find_spec("obstore") is None:
        raise WrongStateError("results in a bucket need obstore: pip install 'virtualrobot[s3]'")
    return Bucket(place.rstrip("/"))


class Folder:
    """Folder of this machine, or of a disk that several share."""

    def __init__(self, folder: Path) -> None:
        """Name it; nothing is read or made yet."""
        self._folder = folder

    def make(self) -> None:
        """Make the folders, without what killed workers have left."""
        for name in ("cells", "lost"):
            (self._folder / name).mkdir(parents=True, exist_ok=True)
        old = time.time() - _UNWRITTEN_SECONDS
        for file in (*(self._folder / "cells").glob(".*.tmp"), *(self._folder / "lost").glob("*.txt")):
            if file.stat().st_mtime < old and (file.suffix == ".tmp" or not file.stat().st_size):
                file.unlink(missing_ok=True)

    def names(self, folder: str) -> list[str]:
        """Return the names of the files in a folder."""
        return sorted(file.name for file in (self._folder / folder).glob("[!.]*"))

    def has(self, name: str) -> bool:
        """Return whether there is such a file."""
        return (self._folder / name).is_file()

    def open(self, name: str) -> Path:
        """Return the file."""
        return self._folder / name

    def read(self, name: str) -> bytes:
        """Return what is in a file."""
        return (self._folder / name).read_bytes()

    def write(self, name: str, content: bytes) -> None:
        """Write a file under another name, and rename it."""
        file = self._folder / name
        temporary = file.with_name(f".{file.stem}.{os.getpid()}.{threading.get_ident()}.tmp")
        try:
            temporary.write_bytes(content)
            os.replace(temporary, file)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise

    add = write

    def remove(self, name: str) -> None:
        """Remove a file."""
        (self._folder / name).unlink(missing_ok=True)

    def where(self, name: str = "") -> str:
        """Return the path."""
        return str(self._folder / name)

    def scratch(self) -> Path:
        """Return the folder `lost` beside the cells."""
        return self._folder / "lost"


class Bucket:
    """Folder in a bucket of S3, or of what speaks as it does; the environment says how it is reached (`AWS_...`).

    A part is one conditional put (`If-None-Match: *`): of several workers that do a block, the first one's stays.
    """

    def __init__(self, url: str) -> None:
        """Name it by its URL; nothing is asked yet."""
        self._url = url

    def make(self) -> None:
        """Do nothing: a bucket has no folders, and nothing in it is half written."""

    def names(self, folder: str) -> list[str]:
        """Return the names of the objects in a folder."""
        with _told(self._url):
            found = [one["path"] for page in _client(self._url).list(folder) for one in page]
        return sorted(path.removeprefix(f"{folder}/") for path in found)

    def has(self, name: str) -> bool:
        """Return whether there is such an object."""
        try:
            with _told(self.where(name)):
                _client(self._url).head(name)
        except FileNotFoundError:
            return False
        return True

    def open(self, name: str) -> io.BytesIO:
        """Return all that is in an object."""
        return io.BytesIO(self.read(name))

    def read(self, name: str) -> bytes:
        """Return what is in an object."""
        with _told(self.where(name)):
            return bytes(_client(self._url).get(name).bytes())

    def write(self, name: str, content: bytes) -> None:
        """Put an object."""
        with _told(self.where(name)):
            _client(self._url).put(name, content)

    def add(self, name: str, content: bytes) -> None:
        """Put an object where there is none."""
        from obstore.exceptions import AlreadyExistsError

        with _told(self.where(name)):
            try:
                # In parts, as the library does with what is big, there would be no condition.
                _client(self._url).put(name, content, mode="create", use_multipart=False)
            except AlreadyExistsError:
                pass

    def remove(self, name: str) -> None:
        """Delete an object."""
        with _told(self.where(name)):
            _client(self._url).delete(name)

    def where(self, name: str = "") -> str:
        """Return the URL."""
        return f"{self._url}/{name}" if name else self._url

    def scratch(self) -> Path:
        """Return a folder among this machine's temporary ones: what a worker of another machine leaves stays there."""
        folder = Path(tempfile.gettempdir()) / f"virtualrobot-study-{self._url.removeprefix(SCHEME).replace('/', '-')}"
        folder.mkdir(exist_ok=True)
        return folder


@cache
def _client(url: str) -> S3Store:
    """Return what speaks to a bucket, once in each process; raise WrongStateError where the environment is wrong."""
    from obstore.exceptions import BaseError
    from obstore.store import S3Store

    plain = {"allow_http": os.environ.get("AWS_ENDPOINT_URL", "").startswith("http://")}
    retries = {"max_retries": _TRIES, "retry_timeout": timedelta(seconds=_LONGEST_SECONDS)}
    try:
        return S3Store.from_url(url, client_options=plain, retry_config=retries)  # pyright: ignore[reportArgumentType]
    except BaseError as error:
        raise WrongStateError(f"{url} cannot be reached: {_line(error)}") from error


@contextmanager
def _told(place: str) -> Iterator[None]:
    """Raise the library's errors as OSError, in a line."""
    from obstore.exceptions import BaseError

    try:
        yield
    except FileNotFoundError as error:
        if "NoSuchBucket" in str(error):
            bucket = place.removeprefix(SCHEME).partition("/")[0]
            raise OSError(f"there is no bucket {bucket!r}") from error
        raise
    except BaseError as error:
        raise OSError(_line(error)) from error


def _line(error: Exception) -> str:
    """Return what a service or a library says, without the document it says it in."""
    text = str(error)
    if "<Message>" in text:
        return text.partition("<Message>")[2].partition("</Message>")[0]
    return " ".join(text.partition("\n")[0].split())
