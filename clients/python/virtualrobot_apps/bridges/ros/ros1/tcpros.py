"""TCPROS: headers of connections, and messages behind their length.

Source: wiki.ros.org, "ROS/TCPROS" and "ROS/Connection Header".
"""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Mapping

MOST_HEADER, MOST_MESSAGE = 1 << 20, 64 << 20
"""Bytes of a header and of a message at most."""

HEADER_SECONDS = 10.0
"""Time (s) that a peer has to say who it is."""


class TcprosError(ConnectionError):
    """A connection that can't be; its text is for people, and is told to the peer."""


async def read_block(reader: asyncio.StreamReader, most: int) -> bytes:
    """Return the bytes behind their length; raises TcprosError when they would be more than `most`."""
    (size,) = struct.unpack("<I", await reader.readexactly(4))
    if size > most:
        raise TcprosError(f"{size} bytes are announced; there may be {most}")
    return await reader.readexactly(size)


def block(data: bytes) -> bytes:
    """Return bytes behind their length."""
    return struct.pack("<I", len(data)) + data


async def read_header(reader: asyncio.StreamReader) -> dict[str, str]:
    """Return the fields of a header; raises TcprosError for what is none, or takes too long."""
    try:
        async with asyncio.timeout(HEADER_SECONDS):
            data = await read_block(reader, MOST_HEADER)
    except TimeoutError as error:
        raise TcprosError(f"no header has come after {HEADER_SECONDS:g} s") from error
    fields: dict[str, str] = {}
    place = 0
    while place < len(data):
        if place + 4 > len(data) or place + 4 + (size := struct.unpack_from("<I", data, place)[0]) > len(data):
            raise TcprosError("a header's field is longer than the header")
        key, _, value = data[place + 4 : place + 4 + size].partition(b"=")
        fields[key.decode("utf-8", "replace")] = value.decode("utf-8", "replace")
        place += 4 + size
    return fields


def header(fields: Mapping[str, str]) -> bytes:
    """Return a header with its length."""
    return block(b"".join(block(f"{key}={value}".encode()) for key, value in fields.items()))
