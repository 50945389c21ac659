"""Last tick of a world, in a small file that is mapped into memory: it survives a killed process at no cost."""

from __future__ import annotations

import mmap
import os
import struct
import zlib
from pathlib import Path

_SLOT = struct.Struct("<QI")
SIZE = 4096


class LastTick:
    """Number of the last tick, written to two places in turn: one of them is whole whenever the process ends."""

    def __init__(self, path: Path, seed: int) -> None:
        """Open or make the file at `path`; checksums begin with `seed`."""
        self._seed = seed
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            if os.fstat(descriptor).st_size < SIZE:
                os.write(descriptor, bytes(SIZE))  # a file with holes would end the process where a disk is full
            self._map = mmap.mmap(descriptor, SIZE)
        finally:
            os.close(descriptor)

    def read(self) -> int:
        """Return the last tick that was written; 0 when there is none, or none that is whole."""
        found = (_SLOT.unpack_from(self._map, place) for place in (0, _SLOT.size))
        return max((tick for tick, crc in found if crc == self._crc(tick)), default=0)

    def write(self, tick: int) -> None:
        """Write the number of the last tick."""
        _SLOT.pack_into(self._map, (tick & 1) * _SLOT.size, tick, self._crc(tick))

    def close(self) -> None:
        """Close the file."""
        self._map.close()

    def _crc(self, tick: int) -> int:
        return zlib.crc32(tick.to_bytes(8, "little"), self._seed)
