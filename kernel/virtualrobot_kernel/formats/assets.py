"""Asset store: files by content, in memory and perhaps in a folder, found again by the SHA-256 of their bytes."""

from __future__ import annotations

import hashlib
import os
import re
import threading
from pathlib import Path

from virtualrobot_kernel.errors import KernelError, MissingFileError, Reason

MEBIBYTE = 1024 * 1024
_SHA256 = re.compile(r"[0-9a-f]{64}")


class AssetStore:
    """Store of bytes by their SHA-256 (64 lower-case hexadecimal digits); any thread may put and get."""

    def __init__(
        self,
        limit_bytes: int = 256 * MEBIBYTE,
        total_limit_bytes: int = 4096 * MEBIBYTE,
        folder: Path | None = None,
        sync: bool = False,
        read_only: bool = False,
    ) -> None:
        """Accept assets of at most `limit_bytes` each and `total_limit_bytes` together.

        With a folder each is a file in it, too, and what is there is held already; with `sync` it survives a loss of
        power. A folder that is `read_only` stays as it is.
        """
        self._folder = folder
        self._writes = folder is not None and not read_only
        self._sync = sync
        if folder is not None and self._writes:
            folder.mkdir(exist_ok=True)
        self.limit_bytes = limit_bytes
        self.total_limit_bytes = total_limit_bytes
        self._assets: dict[str, bytes] = {}
        self._total = 0
        self._lock = threading.Lock()

    @property
    def folder(self) -> Path | None:
        """Folder whose files are held; None: there is none."""
        return self._folder

    def check_size(self, size: int, name: str = "the file") -> None:
        """Raise TOO_LARGE when an asset of `size` bytes is over the limit: ask before the bytes are read.

        `name` says in the message which file it is.
        """
        if size > self.limit_bytes:
            raise KernelError(
                f"{name} has {size} bytes; an asset may have at most {self.limit_bytes}",
                reason=Reason.TOO_LARGE,
                size_bytes=size,
                limit_bytes=self.limit_bytes,
            )

    def put(self, data: bytes, expected_sha256: str | None = None) -> str:
        """Keep `data` and return its SHA-256; the same bytes again cost nothing.

        Raises:
            KernelError: MALFORMED_ASSET when the bytes do not have `expected_sha256`, TOO_LARGE over either limit.
        """
        self.check_size(len(data), "the asset")
        sha256 = hashlib.sha256(data).hexdigest()
        if expected_sha256 is not None and expected_sha256.lower() != sha256:
            raise KernelError(
                f"the {len(data)} bytes have the SHA-256 {sha256}, not {expected_sha256!r} as stated",
                reason=Reason.MALFORMED_ASSET,
                stated_sha256=expected_sha256,
                sha256=sha256,
            )
        with self._lock:
            if sha256 in self._assets:
                return sha256
            if self._total + len(data) > self.total_limit_bytes:
                raise KernelError(
                    f"{len(data)} more bytes would make {self._total + len(data)}; all assets together may have at "
                    f"most {self.total_limit_bytes}",
                    reason=Reason.TOO_LARGE,
                    size_bytes=self._total + len(data),
                    limit_bytes=self.total_limit_bytes,
                )
            if self._folder is not None and self._writes:
                self._write(self._folder / sha256, data)
            self._assets[sha256] = bytes(data)
            self._total += len(data)
        return sha256

    def get(self, sha256: str) -> bytes:
        """Return the bytes with this SHA-256.

        Raises:
            KernelError: MALFORMED_ASSET when `sha256` is no SHA-256, UNKNOWN_ASSET when the store does not hold it.
        """
        key = sha256.lower()
        data = self._assets.get(key)
        if data is not None:
            return data
        if (file := self._file(key)) is not None:
            return self._read(file, key)
        if not _SHA256.fullmatch(key):
            raise KernelError(
                f"{sha256!r} is no SHA-256: it has 64 hexadecimal digits", reason=Reason.MALFORMED_ASSET, sha256=sha256
            )
        raise KernelError(
            f"no asset has the SHA-256 {sha256}: upload it first", reason=Reason.UNKNOWN_ASSET, sha256=sha256
        )

    def has(self, sha256: str) -> bool:
        """Return whether the store holds the asset."""
        key = sha256.lower()
        return key in self._assets or self._file(key) is not None

    def _file(self, key: str) -> Path | None:
        """Return the file of an asset, if the folder has it."""
        if self._folder is None or not _SHA256.fullmatch(key):
            return None
        return file if (file := self._folder / key).is_file() else None

    def _read(self, file: Path, key: str) -> bytes:
        """Return the bytes of a file of the folder and keep them; refuse those that aren't what they were."""
        try:
            data = file.read_bytes()
        except OSError as error:
            raise MissingFileError(f"the asset {file} can't be read: {error.strerror}", file=file) from error
        if hashlib.sha256(data).hexdigest() != key:
            raise KernelError(
                f"the asset {file} is damaged: its bytes are not those that its name says; put back a copy",
                reason=Reason.MALFORMED_ASSET,
                file=file,
                sha256=key,
            )
        with self._lock:
            if key not in self._assets:
                self._assets[key] = data
                self._total += len(data)
        return data

    def _write(self, file: Path, data: bytes) -> None:
        new = file.with_suffix(".new")
        try:
            with open(new, "wb") as opened:
                opened.write(data)
                if self._sync:
                    opened.flush()
                    os.fsync(opened.fileno())
            os.replace(new, file)
        except OSError as error:
            new.unlink(missing_ok=True)
            raise KernelError(
                f"the asset can't be written to {file.parent}: {error.strerror}", reason=Reason.WRONG_STATE, file=file
            ) from error
