"""Checksum of words in shared memory, in compiled code: the CRC-32 of IEEE 802.3, which `zlib.crc32` computes, too.

Eight bytes at a time, by one table for each: Kounavis and Berry, Novel Table Lookup-Based Algorithms for
High-Performance CRC Generation, IEEE Transactions on Computers 57 (2008), section 3 (slicing by 8).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from virtualrobot_sdk.compiled.cache import inlined

Integers = np.ndarray[Any, np.dtype[np.int64]]

_REFLECTED = 0xEDB88320
"""Polynomial, its lowest power in the highest bit."""


def _tables() -> np.ndarray[Any, np.dtype[np.uint32]]:
    """Return (8, 256) what a byte adds to the checksum, by how many bytes come after it."""
    tables = np.empty((8, 256), np.uint32)
    for byte in range(256):
        rest = byte
        for _ in range(8):
            rest = rest >> 1 ^ (_REFLECTED if rest & 1 else 0)
        tables[0, byte] = rest
    for after in range(1, 8):
        tables[after] = tables[after - 1] >> 8 ^ tables[0][tables[after - 1] & 0xFF]
    return tables


_TABLES = _tables()


@inlined
def crc32_of(words: Integers) -> int:
    """Return the CRC-32 of words (n,) of 64 bits, the lowest byte of each first, as in little-endian memory."""
    crc = np.int64(0xFFFFFFFF)
    for place in range(words.shape[0]):
        word = words[place]
        low = (word ^ crc) & 0xFFFFFFFF
        high = word >> 32 & 0xFFFFFFFF
        crc = (
            np.int64(_TABLES[7, low & 0xFF])
            ^ np.int64(_TABLES[6, low >> 8 & 0xFF])
            ^ np.int64(_TABLES[5, low >> 16 & 0xFF])
            ^ np.int64(_TABLES[4, low >> 24])
            ^ np.int64(_TABLES[3, high & 0xFF])
            ^ np.int64(_TABLES[2, high >> 8 & 0xFF])
            ^ np.int64(_TABLES[1, high >> 16 & 0xFF])
            ^ np.int64(_TABLES[0, high >> 24])
        )
    return int(crc ^ 0xFFFFFFFF)
