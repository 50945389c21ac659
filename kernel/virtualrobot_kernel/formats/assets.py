"""Asset store: files by content, kept in memory and found again by the SHA-256 of their bytes."""

from __future__ import annotations

import hashlib
import re
import threading

from virtualrobot_kernel.errors import KernelError, Reason

MEBIBYTE = 1024 * 1024
_SHA256 = re.compile(r"[0-9a-f]{64}")


class AssetStore:
    """Store of bytes by their SHA-256 (64 lower-case hexadecimal digits); any thread may put and get."""

    def __init__(self, limit_bytes: int = 256 * MEBIBYTE, total_limit_bytes: int = 4096 * MEBIBYTE) -> None:
        """Accept assets of at most `limit_bytes` each and `total_limit_bytes` together."""
        self.limit_bytes = limit_bytes
        self.total_limit_bytes = total_limit_bytes
        self._assets: dict[str, bytes] = {}
        self._total = 0
        self._lock = threading.Lock()

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
        if not _SHA256.fullmatch(key):
            raise KernelError(
                f"{sha256!r} is no SHA-256: it has 64 hexadecimal digits", reason=Reason.MALFORMED_ASSET, sha256=sha256
            )
        raise KernelError(
            f"no asset has the SHA-256 {sha256}: upload it first", reason=Reason.UNKNOWN_ASSET, sha256=sha256
        )

    def has(self, sha256: str) -> bool:
        """Return whether the store holds the asset."""
        return sha256.lower() in self._assets
