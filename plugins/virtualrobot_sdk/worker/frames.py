"""Frames on a pipe: a length, the number of the call that they belong to, and the content."""

from __future__ import annotations

import io
import struct

_HEADER = struct.Struct("<QQ")
_AT_ONCE = 1 << 16
"""Largest size (bytes) with which header and content go in one piece: one system call, and the reader wakes up once."""
_LONGEST = 1 << 34


class NotAFrame(Exception):
    """Bytes came through the pipe that `write_frame` did not write."""


def write_frame(pipe: io.FileIO, number: int, content: bytes) -> None:
    """Write one frame; raises OSError when nobody reads any more."""
    header = _HEADER.pack(len(content), number)
    pieces = (header + content,) if len(content) <= _AT_ONCE else (header, content)
    for piece in pieces:
        written = pipe.write(piece) or 0
        if written < len(piece):
            rest = memoryview(piece)[written:]
            while rest:
                rest = rest[pipe.write(rest) or 0 :]


def read_frame(pipe: io.FileIO) -> tuple[int, bytes | bytearray] | None:
    """Return the number and the content of the next frame, or None when the other end is closed.

    Nothing may be written behind a frame before it is answered.
    """
    start = pipe.read(_AT_ONCE)
    while start and len(start) < _HEADER.size:
        more = pipe.read(_AT_ONCE)
        start = start + more if more else b""
    if not start:
        return None
    length, number = _HEADER.unpack_from(start)
    here = len(start) - _HEADER.size
    if here > length or length > _LONGEST:
        raise NotAFrame(f"{here} bytes where a frame of {length} should be")
    if here == length:
        return number, start[_HEADER.size :]
    content = bytearray(length)
    content[:here] = memoryview(start)[_HEADER.size :]
    rest = memoryview(content)[here:]
    while rest:
        count = pipe.readinto(rest)
        if not count:
            return None
        rest = rest[count:]
    return number, content
