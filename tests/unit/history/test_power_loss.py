"""Loss of power: what is left is the journal as it was, without ghosts, and no older than was promised."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.rows import CheckpointRow, Row
from virtualrobot_kernel.history.store import Store

from tests.tiers import Draws
from tests.unit.history.lossy import Disk, LossyVFS, promised

SEED = 0x5EED5EED
ROWS = 120


@pytest.mark.parametrize("power", [True, pytest.param(False, marks=pytest.mark.long)])
def test_what_was_promised_is_there_and_nothing_else(
    tmp_path: Path, rng: np.random.Generator, draws: Draws, power: bool
) -> None:
    """With `power` each transaction is promised, and without it those before the store was tidied."""
    disk = Disk()
    vfs = LossyVFS(disk)
    (tmp_path / "disk").mkdir()
    store = Store(tmp_path / "disk" / "j.db", SEED, power=power, connect=vfs.connect)
    rows = [Row(n, n, 0.0, "me", rng.bytes(int(rng.choice([40, 300, 9000])))) for n in range(1, ROWS + 1)]
    begun, notes, at = len(disk.steps), [(0, 0)], 0
    while at < ROWS:
        count = int(rng.integers(1, 4))
        store.write(rows[at : at + count])
        at = min(at + count, ROWS)
        if tidied := bool(rng.random() < 0.1):
            store.add_hashes(at, rng.bytes(80))
            store.tidy()
        if tidied or power:
            notes.append((len(disk.steps), at))
        if rng.random() < 0.1:
            store.add_checkpoint(CheckpointRow(0, at, at, "", "", 0.0, 1, rng.bytes(5000)), {})
    end = len(disk.steps)
    told = 0
    for _ in range(draws(500)):
        cut = int(rng.integers(begun, end + 1))
        disk.after_loss(tmp_path / "left", cut, rng)
        try:
            left = Store(tmp_path / "left" / "j.db", SEED)
        except KernelError as error:
            # Where nothing was promised, the database itself may not be whole yet.
            assert not promised(notes, cut) and not power, error
            told += 1
            continue
        left.check()
        found = [one.commands for one in left.rows()]
        assert found == [one.commands for one in rows[: len(found)]], "a ghost, or a gap"
        assert len(found) >= promised(notes, cut)
        left.close()
    store.close()
    assert told < 100
