"""The tail: what is damaged is told by file and byte, and nothing is read that wasn't written by this kernel."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_kernel.history.folder import TAIL
from virtualrobot_kernel.history.rows import Row
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.tail import BYTES, MappedFile, Tail, tail_rows

from tests.tiers import Draws
from tests.unit.history.lossy import Disk, LossyVFS, promised

SEED = 0x5EED5EED
LIFE = 77


def row(seq: int, rng: np.random.Generator) -> Row:
    """Return a row that nothing else could be taken for."""
    return Row(seq, 3 * seq, 1.8e9 - seq, f"author {seq % 3}: \u00e4", rng.bytes(int(rng.choice([0, 60, 900]))))


def begun(folder: Path, life: int = LIFE) -> Tail:
    tail = Tail(folder, SEED)
    tail.begin(lambda: life)
    return tail


def read(folder: Path, after: int = 0, life: int = LIFE) -> list[object]:
    """Return what rows say, of a tail that isn't damaged."""
    rows, damage = tail_rows(folder, SEED, life, after)
    assert not damage
    return [astuple(one) for one in rows]


def test_entries_go_to_two_files_by_turns(tmp_path: Path, rng: np.random.Generator) -> None:
    tail = begun(tmp_path)
    rows = [row(seq, rng) for seq in range(1, 31)]
    told = [astuple(one) for one in rows]
    for place, one in enumerate(rows):
        tail.append(one)
        if place == 9:
            tail.turn()
        if place == 19:
            assert read(tmp_path) == told[:20] and read(tmp_path, 7) == told[7:20]
            tail.turn()  # the other one isn't free
            assert read(tmp_path) == told[:20]
            tail.free()
            assert read(tmp_path, 10) == told[10:20] and read(tmp_path) == []
            tail.turn()
    assert read(tmp_path, 10) == told[10:]
    assert read(tmp_path, 30) == []
    tail.close(remove=True)
    assert not list(tmp_path.iterdir())
    assert tail_rows(tmp_path, SEED, 0, 0) == ([], [])
    assert "is missing: what was changed last may be missing" in tail_rows(tmp_path, SEED, LIFE, 0)[1][0]


def test_a_file_grows_for_what_is_large_and_gets_small_again(tmp_path: Path, rng: np.random.Generator) -> None:
    tail = begun(tmp_path)
    rows = [Row(seq, 0, 0.0, "", rng.bytes(size)) for seq, size in enumerate((10, 9 * BYTES, BYTES, 10), 1)]
    for one in rows:
        tail.append(one)
    assert read(tmp_path) == [astuple(one) for one in rows]
    assert (tmp_path / TAIL[0]).stat().st_size > 9 * BYTES
    tail.turn()
    tail.free()
    assert (tmp_path / TAIL[0]).stat().st_size == BYTES
    tail.append(row(5, rng))
    assert len(read(tmp_path, 4)) == 1
    tail.close(remove=False)
    assert len(read(tmp_path, 4)) == 1


def test_entries_of_another_kernel_are_none(tmp_path: Path, rng: np.random.Generator) -> None:
    """Its numbers may be given again, where power was lost: entries of the same size stand in the same places."""
    before = begun(tmp_path, 1)
    for seq in range(1, 11):
        before.append(Row(seq, 0, 0.0, "", b"before"))
    before.close(remove=False)
    left = (tmp_path / TAIL[0]).read_bytes()
    now = begun(tmp_path, 2)
    for seq in range(1, 4):
        now.append(Row(seq, 0, 0.0, "", b"now..."))
    now.close(remove=False)
    file = tmp_path / TAIL[0]
    written = file.read_bytes()
    end = written.rindex(b"now...") + len(b"now...")
    file.write_bytes(written[:end] + left[end:])  # as if the mark at the end had not come to the disk
    rows, damage = tail_rows(tmp_path, SEED, 2, 0)
    assert [one.commands for one in rows] == [b"now..."] * 3
    assert len(damage) == 1 and f"what begins at byte {end} was not written as a whole" in damage[0]


@pytest.mark.parametrize("how", ["cut", "zeros", "bit"])
def test_damage_is_told_or_does_no_harm(tmp_path: Path, rng: np.random.Generator, draws: Draws, how: str) -> None:
    tail = begun(tmp_path)
    rows = [row(seq, rng) for seq in range(1, 31)]
    for place, one in enumerate(rows):
        tail.append(one)
        if place == 14:
            tail.turn()
    tail.close(remove=False)
    whole = [(tmp_path / name).read_bytes() for name in TAIL]
    used = [data.rstrip(b"\0") for data in whole]
    for _ in range(draws(500)):
        number = int(rng.integers(2))
        place, bit = int(rng.integers(len(used[number]) + 4)), int(rng.integers(8))
        data = bytearray(whole[number])
        if how == "cut":
            del data[place:]
        elif how == "zeros":
            data[place:] = bytes(len(data) - place)
        else:
            data[place] ^= 1 << bit
        (tmp_path / TAIL[number]).write_bytes(data)
        (tmp_path / TAIL[1 - number]).write_bytes(whole[1 - number])
        found, damage = tail_rows(tmp_path, SEED, LIFE, 0)
        assert [astuple(one) for one in found] == [astuple(one) for one in rows[: len(found)]], "a ghost"
        if len(found) < len(rows) and how == "bit":
            assert damage and TAIL[number] in damage[0]


class LossyFile(MappedFile):
    """File whose writes and syncs are noted as steps of a disk."""

    def __init__(self, disk: Disk, path: Path, size: int) -> None:
        """Open it."""
        self.disk, self.name = disk, str(path)
        super().__init__(path, size)
        if not any(name == self.name for name, *_ in disk.steps):
            disk.steps.append((self.name, "write", 0, bytes(size)))

    def resize(self, size: int) -> None:
        """Note zeros at the end."""
        if size > self.size:
            self.disk.steps.append((self.name, "write", self.size, bytes(size - self.size)))
        else:
            self.disk.steps.append((self.name, "truncate", size, b""))
        super().resize(size)

    def write(self, place: int, data: bytes) -> None:
        """Note it, sector by sector of the file."""
        super().write(place, data)
        self.disk.steps.append((self.name, "write", place, data))

    def sync(self) -> None:
        """Note it."""
        self.disk.steps.append((self.name, "sync", 0, b""))


@pytest.mark.long
@pytest.mark.parametrize("power", [True, False])
def test_after_a_loss_of_power_there_are_no_ghosts_and_what_was_promised_is_there(
    tmp_path: Path, rng: np.random.Generator, draws: Draws, power: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Over several kernels, each of which goes on with what the one before has left: database and tail on one disk."""
    monkeypatch.setattr("virtualrobot_kernel.history.tail.BYTES", 4096)
    disk = Disk()
    vfs = LossyVFS(disk)
    (tmp_path / "disk").mkdir()
    notes: list[tuple[int, int]] = [(0, 0)]
    truth: list[bytes] = []
    last, begun_at = 0, None
    for _ in range(3):
        store = Store(tmp_path / "disk" / "j.db", SEED, power=power, connect=vfs.connect)
        rows, damage = tail_rows(tmp_path / "disk", SEED, store.life, store.last_seq)
        assert not damage and [one.commands for one in rows] == truth[store.last_seq :]
        store.write(rows)
        tail = Tail(tmp_path / "disk", SEED, power, lambda path, size: LossyFile(disk, path, size))

        def new_life(store: Store = store) -> int:
            life = int(rng.integers(1, 2**32))
            store.note_life(life)
            return life

        tail.begin(new_life)
        if begun_at is None:
            store.tidy()
            begun_at = len(disk.steps)
        waiting: list[Row] = []
        for _ in range(40):
            for _ in range(int(rng.integers(1, 4))):
                last += 1
                truth.append(rng.bytes(int(rng.choice([40, 40, 300, 9000]))))
                waiting.append(Row(last, 0, 0.0, "me", truth[-1]))
                tail.append(waiting[-1])
            if power:
                tail.sync()
                notes.append((len(disk.steps), last))
            if rng.random() < 0.3:
                tail.turn()
                store.write(waiting)
                if rng.random() < 0.7:
                    tail.free()
                waiting = []
                if rng.random() < 0.5:
                    store.tidy()
                    notes.append((len(disk.steps), last))
        tail.close(remove=False)
        store.close()
        notes.append((len(disk.steps), 0))
    assert begun_at is not None
    for _ in range(draws(500)):
        cut = int(rng.integers(begun_at, len(disk.steps) + 1))
        disk.after_loss(tmp_path / "left", cut, rng)
        left = Store(tmp_path / "left" / "j.db", SEED)
        rows, _ = tail_rows(tmp_path / "left", SEED, left.life, left.last_seq)
        found = [one.commands for one in (*left.rows(), *rows)]
        left.close()
        assert found == truth[: len(found)], "a ghost, or a gap"
        assert len(found) >= promised(notes, cut)
