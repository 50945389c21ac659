"""Space mice without hardware: a module in place of hidapi's, whose device sends reports as 3Dconnexion's do."""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any

INFO: dict[str, Any] = {
    "path": b"/dev/hidraw7",
    "vendor_id": 0x256F,
    "product_id": 0xC635,
    "usage_page": 1,
    "usage": 8,
    "product_string": "SpaceMouse Compact",
}
"""Entry of a SpaceMouse Compact in the list of hidapi."""


def translation(x: int = 0, y: int = 0, z: int = 0) -> bytes:
    """Return report 1 of a device that tells translation and rotation apart."""
    return struct.pack("<Bhhh", 1, x, y, z)


def rotation(rx: int = 0, ry: int = 0, rz: int = 0) -> bytes:
    """Return report 2."""
    return struct.pack("<Bhhh", 2, rx, ry, rz)


def motion(*counts: int) -> bytes:
    """Return report 1 of a device that tells all six axes together."""
    return struct.pack("<B6h", 1, *counts)


def pressed(bits: int) -> bytes:
    """Return report 3."""
    return struct.pack("<BI", 3, bits)


class FakeHid:
    """Module `hid` with one device; any thread may have it report."""

    def __init__(self, *infos: dict[str, Any], refuses: str = "") -> None:
        """Have devices, by default a SpaceMouse Compact, which `refuses` to be opened with a text."""
        self.infos = infos or (INFO,)
        self.opened: bytes | None = None
        self.is_there, self.is_closed = True, False
        self._refuses = refuses
        self._reports: deque[bytes] = deque()

    def enumerate(self) -> Iterator[dict[str, Any]]:
        return iter(self.infos)

    def device(self) -> FakeHid:
        return self

    def open_path(self, path: bytes) -> None:
        if self._refuses:
            raise OSError(self._refuses)
        self.opened = path

    def set_nonblocking(self, value: bool) -> None:
        assert value

    def read(self, length: int) -> list[int]:
        if not self.is_there:
            raise OSError("read error")
        return list(self._reports.popleft()[:length]) if self._reports else []

    def close(self) -> None:
        self.is_closed = True

    def send(self, *reports: bytes | Sequence[int]) -> None:
        """Have the device send reports."""
        self._reports.extend(bytes(one) for one in reports)
