"""Files with damage, for importers: cut off, changed, pieces gone or twice, numbers of another size."""

from __future__ import annotations

import re

import numpy as np

_ODD_NUMBERS = (b"0", b"-1", b"2.5", b"1e308", b"-1e308", b"1e-300", b"nan", b"99999999999", b"4294967295", b"")
_LONGEST_PIECE = 300


def damaged(data: bytes, rng: np.random.Generator) -> tuple[bytes, str]:
    """Return a copy of a file with one damage of a random kind, and what it is in words."""
    start = int(rng.integers(len(data)))
    end = start + int(rng.integers(1, _LONGEST_PIECE))
    kind = int(rng.integers(6))
    if kind == 0:
        return data[:start], f"cut off after {start} bytes"
    if kind == 1:
        changed = bytearray(data)
        places = [int(place) for place in rng.integers(len(data), size=int(rng.integers(1, 20)))]
        for place in places:
            changed[place] = int(rng.integers(256))
        return bytes(changed), f"other bytes at {', '.join(map(str, sorted(places)))}"
    if kind == 2:
        place = int(rng.integers(len(data)))
        changed = bytearray(data)
        changed[place] ^= 1 << int(rng.integers(8))
        return bytes(changed), f"a bit changed at {place}"
    if kind == 3:
        return data[:start] + data[end:], f"without bytes {start} to {end}"
    if kind == 4:
        place = int(rng.integers(len(data)))
        return data[:place] + data[start:end] + data[place:], f"bytes {start} to {end} once more at {place}"
    numbers = list(re.finditer(rb"\d+(\.\d+)?", data))
    if not numbers:
        return data[:start], f"cut off after {start} bytes"
    number, other = numbers[int(rng.integers(len(numbers)))], _ODD_NUMBERS[int(rng.integers(len(_ODD_NUMBERS)))]
    changed = data[: number.start()] + other + data[number.end() :]
    return changed, f"{number[0].decode()} at {number.start()} made {other.decode()!r}"
