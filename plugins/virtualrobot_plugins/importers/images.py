"""Images that go into a GLB file as they are."""

from __future__ import annotations


def drawable(data: bytes | None) -> bytes | None:
    """Return the image when it is one that GLB files may hold, PNG or JPEG, and not cut off; else None."""
    if data is None:
        return None
    if data.startswith(b"\x89PNG\r\n\x1a\n") and b"IEND" in data[-32:]:
        return data
    if data.startswith(b"\xff\xd8\xff") and b"\xff\xd9" in data[-64:]:
        return data
    return None
