"""The store: what was written is read back, and what is damaged is told by its file and row, or does no harm."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterable
from contextlib import nullcontext
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, MalformedFileError
from virtualrobot_kernel.history.rows import CheckpointRow, Row, StepRow
from virtualrobot_kernel.history.store import Store

from tests.tiers import Draws

SEED = 0x5EED5EED


def row(seq: int, rng: np.random.Generator) -> Row:
    """Return a row that nothing else could be taken for."""
    commands = rng.bytes(int(rng.choice([0, 60, 900, 9000])))
    return Row(seq, seq * 3, 1.8e9 - seq, f"author {seq % 3}", commands)


def step(seq: int, rng: np.random.Generator) -> StepRow:
    """Return a step of the row with this number."""
    names = tuple((uid, f"node {uid}") for uid in range(int(rng.integers(3))))
    touched = tuple(int(uid) for uid in np.unique(rng.integers(2, 50, int(rng.integers(3)))))
    kind = "edit" if seq % 2 else "signal"
    about = f"did {seq}: \u00e4"
    return StepRow(seq, seq, seq * 3, 1.8e9, f"author {seq % 3}", kind, about, names, 0, rng.bytes(20), touched)


def fields(rows: Iterable[Row | StepRow]) -> list[object]:
    """Return what rows say."""
    return [astuple(one) for one in rows]


def filled(store: Store, rng: np.random.Generator, count: int = 30) -> list[Row]:
    """Write rows, two checkpoints and hashes; return the rows."""
    rows = [row(seq, rng) for seq in range(1, count + 1)]
    store.write(rows[:1])
    keys = b"a" * 16, b"b" * 16
    begin = CheckpointRow(0, 1, 3, "begin", "me", 1.8e9, 7, b"body", keys[:1])
    store.add_checkpoint(begin, {keys[0]: b"part a"})
    store.write(rows[1:10])
    store.add_hashes(0, rng.bytes(80))
    store.write(rows[10:])
    end = CheckpointRow(0, count, 3 * count, "", "kernel", 1.8e9, 9, b"other body", keys)
    store.add_checkpoint(end, {keys[1]: b"part b"})
    store.add_hashes(10, rng.bytes(160))
    store.write([], [(step(one.seq, rng), 0) for one in rows])
    return rows


def content(store: Store) -> tuple[list[object], ...]:
    """Return all that can be read, having looked at every row."""
    store.check()
    checkpoints = [one for head in store.checkpoints() if (one := store.checkpoint(head.id))]
    return (
        fields(store.rows()),
        fields(store.steps()),
        [(one.id, one.seq, one.tick, one.name, one.author, one.body, store.parts(one.parts)) for one in checkpoints],
        list(store.hashes()),
    )


@pytest.mark.parametrize("in_file", [True, False])
def test_what_was_written_is_read_back(tmp_path: Path, rng: np.random.Generator, in_file: bool) -> None:
    path = tmp_path / "j.db" if in_file else None
    store = Store(path, SEED)
    rows = filled(store, rng)
    for _ in range(2):
        assert fields(store.rows()) == fields(rows)
        assert [one.seq for one in store.rows(7, 9)] == [8, 9]
        assert [one.number for one in store.steps()] == [*range(30, 0, -1)]
        assert [one.number for one in store.steps("author = ?", ["author 1"], 26)] == [25, 22, 19, 16, 13, 10, 7, 4, 1]
        about = [one.number for one in store.steps() if 7 in one.touched]
        found = store.steps("number IN (SELECT number FROM touched WHERE uid = ?)", [7])
        assert [one.number for one in found] == about
        first, last = store.checkpoints()
        assert (first.name, first.seq, first.author, last.tick) == ("begin", 1, "me", 90)
        assert (whole := store.checkpoint(last.id)) and store.parts(whole.parts) == [b"part a", b"part b"]
        assert [tick for tick, _ in store.hashes()] == [0, 10] and [tick for tick, _ in store.hashes(12)] == [10]
        assert (store.last_seq, store.last_tick) == (30, 90)
        if not in_file:
            break
        store.close()
        assert not list(tmp_path.glob("j.db-*"))
        store = Store(path, SEED)
    store.close()


def test_a_step_takes_the_place_of_those_that_it_draws_out(rng: np.random.Generator) -> None:
    store = Store(None, SEED)
    first = replace(step(5, rng), touched=(7, 8))
    store.write([], [(first, 0)])
    drawn = replace(first, number=6, label="longer")
    for _ in range(2):
        store.write([], [(drawn, 5)])
    assert fields(store.steps()) == fields([drawn])
    assert (one := store.step(5)) and one.label == "longer" and store.step(4) is None and store.step(7) is None
    assert [one.number for one in store.steps("number IN (SELECT number FROM touched WHERE uid = 8)")] == [6]
    store.close()


def test_parts_go_with_the_last_checkpoint_that_has_them(rng: np.random.Generator) -> None:
    store = Store(None, SEED)
    filled(store, rng)
    first, last = (one.id for one in store.checkpoints())
    store.remove_checkpoints([first])
    assert store.parts([b"a" * 16])
    store.remove_checkpoints([last])
    with pytest.raises(KernelError, match=f"the part {(b'a' * 16).hex()} is missing"):
        store.parts([b"a" * 16])
    store.close()


def test_old_entries_are_forgotten_some_at_a_time(rng: np.random.Generator) -> None:
    store = Store(None, SEED)
    rows = filled(store, rng)
    while store.forget(21, 30, most=4):
        pass
    assert [one.seq for one in store.rows()] == [*range(22, 31)] and store.forgotten == 21
    steps = [one.number for one in store.steps()]
    assert steps == [*range(30, 21, -1), *range(21, 0, -2)], "edits can still be undone"
    assert store.last_seq == 30
    store.write([row(31, rng)])
    assert fields(store.rows(29)) == fields([rows[29], *store.rows(30)])
    store.close()


def test_a_failed_write_leaves_nothing_behind(tmp_path: Path, rng: np.random.Generator) -> None:
    store = Store(tmp_path / "j.db", SEED)
    store.write([row(1, rng)])
    with pytest.raises(sqlite3.IntegrityError):
        store.write([row(2, rng), row(2, rng)])
    with pytest.raises(sqlite3.IntegrityError):
        store.write([row(1, rng)])
    store.write([row(2, rng)])
    assert [one.seq for one in store.rows()] == [1, 2]
    store.close()


def test_missing_and_foreign_rows_are_named(tmp_path: Path, rng: np.random.Generator) -> None:
    path = tmp_path / "j.db"
    store = Store(path, SEED)
    filled(store, rng)
    store.close()
    with pytest.raises(
        MalformedFileError, match=r"j\.db is damaged: it belongs to another folder; put a copy of the folder back"
    ):
        Store(path, SEED + 1)
    for sql, word in (
        ("DELETE FROM entries WHERE seq = 4", "the entry 4 is missing"),
        ("UPDATE entries SET commands = x'00' WHERE seq = 5", "the entry 5 has a wrong checksum"),
        ("UPDATE steps SET label = 'x' WHERE number = 6", "the step 6 has a wrong checksum"),
        ("UPDATE entries SET seq = seq + 1 WHERE seq = 30", "the entry 30 is missing"),
        ("UPDATE checkpoints SET body = 'text'", "the checkpoint 1 has a wrong checksum"),
        ("UPDATE parts SET body = x'00'", "the part 61616161616161616161616161616161 has a wrong checksum"),
        ("DELETE FROM parts", "the part 61616161616161616161616161616161 is missing"),
        ("UPDATE hashes SET hashes = x'00' WHERE first_tick = 10", "the hashes from tick 10 on have a wrong checksum"),
    ):
        copy = Path(shutil.copy(path, tmp_path / "copy.db"))
        other = sqlite3.connect(copy)
        other.execute(sql)
        other.commit()
        other.close()
        store = Store(copy, SEED)
        with pytest.raises(MalformedFileError, match=rf"copy\.db is damaged: .*{word}"):
            store.check()
        store.close()


def test_another_length_of_ticks_than_the_journal_has_is_refused(tmp_path: Path) -> None:
    for nanoseconds in (4_000_000, 4_000_000, 8_000_000):
        store = Store(tmp_path / "j.db", SEED)
        wrong = nanoseconds != 4_000_000
        with pytest.raises(MalformedFileError, match="a tick has 8 ms, the journal 4 ms") if wrong else nullcontext():
            store.note_tick(nanoseconds)
        store.close()


def test_a_newer_form_is_refused(tmp_path: Path) -> None:
    Store(tmp_path / "j.db", SEED).close()
    other = sqlite3.connect(tmp_path / "j.db")
    other.execute("PRAGMA user_version=2")
    other.close()
    with pytest.raises(KernelError, match="newer version, in form 2; this one knows 1"):
        Store(tmp_path / "j.db", SEED)


def test_a_log_that_cannot_be_read_stays_as_it_is(tmp_path: Path, rng: np.random.Generator) -> None:
    """SQLite alone would delete it, and take an empty database, or one that is none, for all there was."""
    store = Store(tmp_path / "j.db", SEED)
    filled(store, rng)
    for name in ("j.db", "j.db-wal"):
        shutil.copy(tmp_path / name, tmp_path / f"copy-{name}")
    store.close()
    for name, head, said in (("j.db-wal", 32, "holds can't be read"), ("j.db", 16, "does not begin as a database")):
        for file in ("j.db", "j.db-wal"):
            shutil.copy(tmp_path / f"copy-{file}", tmp_path / file)
        data = (tmp_path / name).read_bytes()
        (tmp_path / name).write_bytes(bytes(head) + data[head:])
        left = [(tmp_path / file).read_bytes() for file in ("j.db", "j.db-wal")]
        with pytest.raises(MalformedFileError, match=f"is damaged: .*{said}"):
            Store(tmp_path / "j.db", SEED)
        assert [(tmp_path / file).read_bytes() for file in ("j.db", "j.db-wal")] == left


@pytest.mark.parametrize("where", ["j.db", pytest.param("j.db-wal", marks=pytest.mark.long)])
def test_a_flipped_bit_is_told_or_does_no_harm(
    tmp_path: Path, rng: np.random.Generator, draws: Draws, where: str
) -> None:
    store = Store(tmp_path / "j.db", SEED)
    filled(store, rng)
    expected = content(store)
    if where == "j.db":
        store.close()
    else:  # as a killed kernel leaves it
        for name in ("j.db", "j.db-wal"):
            shutil.copy(tmp_path / name, tmp_path / f"copy-{name}")
        store.close()
        for name in ("j.db", "j.db-wal"):
            (tmp_path / f"copy-{name}").replace(tmp_path / name)
    files = {name: (tmp_path / name).read_bytes() for name in ("j.db", "j.db-wal") if (tmp_path / name).exists()}
    size, told = len(files[where]), 0
    for number in range(draws(500)):
        place = tmp_path / f"{number}"
        place.mkdir()
        for name, data in files.items():
            spoiled = bytearray(data)
            if name == where:
                spoiled[int(rng.integers(size))] ^= 1 << int(rng.integers(8))
            (place / name).write_bytes(spoiled)
        try:
            store = Store(place / "j.db", SEED)
        except KernelError as error:
            assert "j.db is damaged" in str(error) or "newer version" in str(error)
            told += 1
            continue
        try:
            found = content(store)
            if found != expected:
                assert store.warnings and "j.db-wal: pages" in store.warnings[0], number
                kept, all = found[0], expected[0]
                assert kept == all[: len(kept)], "what is left is how the journal was a while before"  # pyright: ignore
            told += bool(store.warnings)
        except KernelError as error:
            assert "j.db is damaged" in str(error)
            told += 1
        finally:
            store.close()
        shutil.rmtree(place)
    assert told
