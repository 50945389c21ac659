"""The last tick in a mapped file: whole whenever the process ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from virtualrobot_kernel.history.last_tick import LastTick


def test_the_last_one_is_read_again(tmp_path: Path) -> None:
    first = LastTick(tmp_path / "last_tick", 7)
    assert first.read() == 0
    for tick in (1, 2, 3, 4, 100, 101, 2**40):
        first.write(tick)
        assert first.read() == tick
    first.close()
    again = LastTick(tmp_path / "last_tick", 7)
    assert again.read() == 2**40
    again.close()


def test_a_damaged_place_leaves_the_tick_before(tmp_path: Path, rng: np.random.Generator) -> None:
    path = tmp_path / "last_tick"
    first = LastTick(path, 7)
    first.write(41)
    first.write(42)
    first.close()
    data = path.read_bytes()
    for bit in range(96):
        spoiled = bytearray(data)
        spoiled[bit // 8] ^= 1 << bit % 8
        path.write_bytes(spoiled)
        again = LastTick(path, 7)
        assert again.read() == 41
        again.close()
    path.write_bytes(data)
    foreign = LastTick(path, 8)
    assert foreign.read() == 0
    foreign.close()
