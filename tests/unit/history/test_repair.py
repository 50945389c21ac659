"""A damaged journal is made anew of what can be read: unchanged and without a gap; its files stay as they were."""

from __future__ import annotations

import shutil
import sqlite3
import zipfile
from collections.abc import Callable
from contextlib import closing
from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, MalformedFileError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.codec import same
from virtualrobot_kernel.history.folder import JOURNAL, Folder, read_project
from virtualrobot_kernel.history.history import History
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.last_tick import LastTick
from virtualrobot_kernel.history.pages import PAGE_BYTES, rows
from virtualrobot_kernel.history.past import PastFolder
from virtualrobot_kernel.history.recovery import recovered
from virtualrobot_kernel.history.repair import ASIDE, repair
from virtualrobot_kernel.history.salvage import SalvagedStore
from virtualrobot_kernel.history.steps import Steps
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.stored_steps import StoredSteps
from virtualrobot_kernel.history.tail import MAGIC
from virtualrobot_kernel.history.tick_hash import tick_hash
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.report import Reported, write_report
from virtualrobot_kernel.world.state import Snapshot

from tests.tiers import Draws
from tests.unit.history.runs import Run, random_run
from tests.unit.history.test_replay import stored
from tests.unit.history.test_store import SEED, content, filled
from tests.unit.world.builders import TICK

Damage = Callable[[bytearray], None]


def project_of(folder: Path, run: Run, checkpoints: tuple[int, ...] = ()) -> dict[str, bytes]:
    """Write a folder as a kernel has left it that has done a run; return the bytes of its files."""
    made = Folder(folder, round(TICK * 1e9))
    made.close()
    store = Store(folder / JOURNAL, made.project.seed)
    store.note_tick(made.project.tick_nanoseconds)
    source = stored(run, checkpoints)
    for row in source.rows():
        store.write([row])
    for head in source.checkpoints():
        found = source.checkpoint(head.id)
        assert found is not None
        store.add_checkpoint(found, dict(zip(found.parts, source.parts(found.parts), strict=True)))
    for at in range(0, len(run.ticks), 100):
        store.add_hashes(at + 1, b"".join(tick_hash(*one) for one in run.ticks[at : at + 100]))
    store.close()
    last = LastTick(folder / "last_tick", made.project.seed)
    last.write(run.last[1].tick)
    last.close()
    return {one.name: one.read_bytes() for one in folder.iterdir() if one.is_file() and one.name != "lock"}


def spoil(path: Path, damage: Damage) -> bytes:
    """Damage a file; return its bytes."""
    data = bytearray(path.read_bytes())
    damage(data)
    path.write_bytes(data)
    return bytes(data)


def no_header(data: bytearray) -> None:
    """Overwrite the first page: SQLite takes the file for none of its own."""
    data[:PAGE_BYTES] = bytes(PAGE_BYTES)


def begun(folder: Path) -> History:
    """Return the history with which a kernel would go on."""
    opened = Folder(folder)
    try:
        return History(opened, TICK, world_poses)
    except KernelError:
        opened.close()
        raise


@pytest.mark.parametrize("wal", [False, True])
def test_pages_have_the_rows_that_were_written(tmp_path: Path, rng: np.random.Generator, wal: bool) -> None:
    """All of them, without a first page; entries with 9 kB are on several pages."""
    store = Store(tmp_path / "j.db", SEED)
    filled(store, rng, 200)
    expected = content(store)
    if not wal:
        store.close()
    for name in ("j.db", "j.db-wal"):
        if (tmp_path / name).exists():
            shutil.copy(tmp_path / name, tmp_path / f"copy-{name}")
    store.close()
    if not wal:
        spoil(tmp_path / "copy-j.db", no_header)
    other = SalvagedStore(tmp_path / "new.db", SEED)
    other.adopt(rows(tmp_path / "copy-j.db", tmp_path / "copy-j.db-wal"))
    assert content(other) == expected
    other.close()


def test_a_database_that_cannot_be_opened_is_whole_again(tmp_path: Path, rng: np.random.Generator) -> None:
    run = random_run(rng, 60)
    before = project_of(tmp_path / "cell", run, (20,))
    spoiled = spoil(tmp_path / "cell" / JOURNAL, no_header)
    with pytest.raises(MalformedFileError, match=r"is damaged: .*virtualrobot repair"):
        begun(tmp_path / "cell")
    told = repair(tmp_path / "cell", world_poses)
    assert told is not None
    count = len(run.entries)
    assert (told.first, told.last, told.lost, told.lost_ticks, told.lost_checkpoints) == (1, count, 0, 0, 0)
    lost = "as far as can be told 0 entries, 0 ticks and 0 checkpoints are lost"
    assert str(told).startswith(f"entries 1 to {count} and {run.last[1].tick:,} ticks are kept; {lost}; ")
    aside = {one.name: one.read_bytes() for one in (tmp_path / "cell" / ASIDE).iterdir()}
    assert aside == {JOURNAL: spoiled, "last_tick": before["last_tick"]}
    history = begun(tmp_path / "cell")
    try:
        assert same(image_of(history.begin.structure, history.begin.state), image_of(*run.last)) == ""
    finally:
        history.close_files()
    assert repair(tmp_path / "cell", world_poses) is None, "it is sound"


def test_steps_that_are_lost_are_made_anew_of_their_entries(tmp_path: Path, rng: np.random.Generator) -> None:
    """As the world's thread tells entries and the history keeps them; one with a wrong checksum is lost alone."""
    run, codec = random_run(rng, 40), world_codec()
    project_of(tmp_path, run)
    told: list[Told] = []
    recovered(Store(), codec, 0, TICK, world_poses, list(stored(run).rows()), told.append)
    Steps(kept := StoredSteps(Store(), codec)).keep(told)
    expected = [astuple(row) for row, _ in kept.waiting()]
    assert len(expected) > 10
    spoil(tmp_path / JOURNAL, no_header)
    done = repair(tmp_path, world_poses)
    assert (
        done is not None and done.made_steps == len(expected) and f"; {len(expected)} steps are made anew" in str(done)
    )
    seed = read_project(tmp_path).seed
    with closing(Store(tmp_path / JOURNAL, seed)) as store:
        assert [astuple(row) for row in store.steps()][::-1] == expected
    with closing(sqlite3.connect(tmp_path / JOURNAL)) as database, database:
        database.execute("UPDATE steps SET label = 'moved nothing' WHERE number = ?", (expected[5][0],))
    done = repair(tmp_path, world_poses)
    assert done is not None and done.made_steps == 1
    with closing(Store(tmp_path / JOURNAL, seed)) as store:
        assert [astuple(row) for row in store.steps()][::-1] == expected


def test_a_lost_entry_ends_what_can_be_repeated_unless_a_checkpoint_comes_after_it(
    tmp_path: Path, rng: np.random.Generator
) -> None:
    run = random_run(rng, 30)
    count = len(run.entries)
    for name, checkpoints, kept in (("a", (), (1, 9)), ("b", (15,), (16, count)), ("c", (5, 15), (16, count))):
        folder = tmp_path / name
        project_of(folder, run, checkpoints)
        store = Store(folder / JOURNAL, read_project(folder).seed)
        store._writer.execute("UPDATE entries SET crc = crc + 1 WHERE seq = 10")
        store.close()
        told = repair(folder, world_poses)
        assert told is not None
        assert (told.first, told.last) == kept
        assert told.lost == count - (kept[1] - kept[0] + 1)
        assert told.tick == (run.entries[8].tick if kept[1] == 9 else run.last[1].tick)
        assert told.lost_ticks == run.last[1].tick - told.tick
        history = begun(folder)
        try:
            last = run.worlds[9] if kept[1] == 9 else run.last
            found = history.begin
            if kept[1] == 9:
                assert found.structure.nodes.keys() == last[0].nodes.keys()
            else:
                assert same(image_of(found.structure, found.state), image_of(*last)) == ""
        finally:
            history.close_files()


def test_whatever_is_damaged_what_is_kept_is_what_was(tmp_path: Path, rng: np.random.Generator, draws: Draws) -> None:
    """Pages and bits at random: the journal is sound afterwards, and its replay comes to the joints that were."""
    run = random_run(rng, 60)
    files = project_of(tmp_path / "cell", run, (20, 40))
    shutil.rmtree(tmp_path / "cell")
    seed = None
    for number in range(draws(40)):
        folder = tmp_path / f"{number}"
        folder.mkdir()
        for name, data in files.items():
            (folder / name).write_bytes(data)
        seed = seed or read_project(folder).seed

        def damage(data: bytearray) -> None:
            pages = len(data) // PAGE_BYTES
            for page in rng.integers(0, pages, int(rng.integers(1, 4))):
                data[page * PAGE_BYTES : (page + 1) * PAGE_BYTES] = rng.bytes(PAGE_BYTES)
            for _ in range(int(rng.integers(0, 8))):
                data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))

        spoiled = spoil(folder / JOURNAL, damage)
        try:
            told = repair(folder, world_poses)
        except KernelError as error:
            assert "there is nothing to go on from" in str(error)
            left = {one.name: one.read_bytes() for one in folder.iterdir() if one.name != "lock"}
            assert left == {**files, JOURNAL: spoiled}
            continue
        if told is None:
            continue
        assert (told.aside / JOURNAL).read_bytes() == spoiled
        store = Store(folder / JOURNAL, seed)
        assert store.check() == told.last - told.first + 1
        codec = world_codec()
        for row in store.rows():
            was = run.entries[row.seq - 1]
            assert (row.tick, row.commands) == (was.tick, codec.encode(was.commands))
        store.close()
        history = begun(folder)
        try:
            assert history.begin.state.tick == told.tick
            if told.last == len(run.entries):
                assert same(image_of(history.begin.structure, history.begin.state), image_of(*run.last)) == ""
        finally:
            history.close_files()


def test_a_tail_that_cannot_be_read_is_told(tmp_path: Path, rng: np.random.Generator) -> None:
    """Its entries go with a number that the database has lost; joints go no further than to the last known entry."""
    run = random_run(rng, 20)
    project_of(tmp_path / "cell", run)
    spoil(tmp_path / "cell" / JOURNAL, no_header)
    (tmp_path / "cell" / "tail.0").write_bytes(MAGIC + rng.bytes(200))
    told = repair(tmp_path / "cell", world_poses)
    assert told is not None
    assert (told.last, told.tick, told.lost_tail) == (len(run.entries), run.entries[-1].tick, True)
    assert "are lost, and what was changed in the last second; " in str(told)
    assert "; the damaged files are in" in str(told)


def test_what_cannot_be_repaired_stays_as_it_is(tmp_path: Path, rng: np.random.Generator) -> None:
    with pytest.raises(KernelError, match="is no project folder"):
        repair(tmp_path, world_poses)
    files = project_of(tmp_path / "cell", random_run(rng, 10))
    used = Folder(tmp_path / "cell")
    with pytest.raises(KernelError, match="another kernel uses the folder"):
        repair(tmp_path / "cell", world_poses)
    used.close()
    spoiled = spoil(tmp_path / "cell" / JOURNAL, lambda data: data.__setitem__(slice(0, len(data)), bytes(len(data))))
    with pytest.raises(
        MalformedFileError, match=r"neither the first entry nor a checkpoint of .*journal\.db can be read"
    ):
        repair(tmp_path / "cell", world_poses)
    assert {one.name for one in (tmp_path / "cell").iterdir()} == {*files, "lock"}
    assert (tmp_path / "cell" / JOURNAL).read_bytes() == spoiled
    (tmp_path / "cell" / JOURNAL).unlink()
    with pytest.raises(KernelError, match=r"has no journal\.db that could be repaired"):
        repair(tmp_path / "cell", world_poses)


def test_a_past_is_a_copy_but_its_damage_is_told_of_the_folder_itself(tmp_path: Path, rng: np.random.Generator) -> None:
    folder = tmp_path / "cell"
    project_of(folder, random_run(rng, 20))
    with closing(Store(folder / JOURNAL, read_project(folder).seed)) as store:
        store.note_life(7)  # a kernel that was killed, whose tail is gone
    past = PastFolder(folder)
    assert past.store.warnings == [f"{folder / 'tail.0'} is missing: what was changed last may be missing"]
    past.close()
    spoil(folder / JOURNAL, lambda data: data.__setitem__(slice(0, 16), bytes(16)))
    with pytest.raises(MalformedFileError) as refused:
        PastFolder(folder)
    assert str(refused.value).startswith(f"{folder / JOURNAL} is damaged: it does not begin as a database does")
    assert str(refused.value).endswith(f"virtualrobot repair {folder}")


def test_the_report_of_a_kernel_that_runs_misses_no_tail(tmp_path: Path, rng: np.random.Generator) -> None:
    folder = tmp_path / "cell"
    run = random_run(rng, 20)
    project_of(folder, run)
    project = read_project(folder)
    with closing(Store(folder / JOURNAL, project.seed)) as store:
        store.note_life(7)
        world = Snapshot(*run.last, world_poses(*run.last), 0, 0.0, TICK)
        write_report(tmp_path / "fault.zip", Reported(store, project, world, AssetStore()))
        assert store.life == 7
    with zipfile.ZipFile(tmp_path / "fault.zip") as archive:
        archive.extractall(tmp_path / "fault")
    past = PastFolder(tmp_path / "fault")
    assert past.store.warnings == [] and past.store.last_seq > 0
    past.close()
