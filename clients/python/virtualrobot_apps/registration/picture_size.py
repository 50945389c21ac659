"""Sizes of pictures by the first bytes of their files, so that a small file that is a huge picture isn't unpacked."""

from __future__ import annotations

import struct

_PNG = b"\x89PNG\r\n\x1a\n"
_JPEG = b"\xff\xd8"
_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
"""Markers of a JPEG (ITU-T T.81, table B.1) that begin a frame, which tells height and width."""


def size_of(data: bytes) -> tuple[int, int] | None:
    """Return width and height (pixels) of a PNG or a JPEG; None for anything else."""
    if data.startswith(_PNG) and len(data) >= 24:
        width, height = struct.unpack(">II", data[16:24])
        return width, height
    if not data.startswith(_JPEG):
        return None
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        kind, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4])
        if kind in _FRAMES:
            height, width = struct.unpack(">HH", data[at + 5 : at + 9])
            return width, height
        # A fill byte stands alone; all before a frame have a length.
        at += 1 if kind == 0xFF else 2 + length
    return None
