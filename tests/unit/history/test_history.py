"""The history of a kernel: after an end at any moment the world is as it was, and a full disk loses nothing."""

from __future__ import annotations

import shutil
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import astuple, replace
from itertools import count, pairwise
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.history import upkeep
from virtualrobot_kernel.history.codec import same
from virtualrobot_kernel.history.folder import LAST_TICK, TAIL, Folder
from virtualrobot_kernel.history.history import History, rules_of
from virtualrobot_kernel.history.past import PastFolder
from virtualrobot_kernel.history.recovery import image, recovered
from virtualrobot_kernel.history.step import StepKind
from virtualrobot_kernel.history.steps import Wanted
from virtualrobot_kernel.history.upkeep import Moment, Rules
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import (
    ClearWorld,
    CreateNodes,
    CreateSignal,
    EndSetpoints,
    SetSetpoint,
    SetSignal,
    StartSetpointMotion,
    StopMotions,
    UpdateNode,
)
from virtualrobot_kernel.world.history_commands import RestartWorld
from virtualrobot_kernel.world.state import EndCause, Signal
from virtualrobot_kernel.world.store import World

from tests.tiers import Draws
from tests.unit.history.runs import drawn
from tests.unit.world.builders import TICK, arm, part, shifted
from tests.unit.world.test_programs import NAMES, program

GUARD = 60.0
CLOCK = Clock(Mode.STEPPED, 1.0, round(TICK * 1e9))


@contextmanager
def kernel(path: Path | None, rules: Rules | None = None) -> Iterator[tuple[World, History]]:
    """Give a world and its history as a kernel has them, on a folder or in memory."""
    history = History(Folder(path, CLOCK.tick_nanoseconds) if path else None, TICK, world_poses, rules)
    begin = history.begin
    world = World(world_poses, history.journal, CLOCK, begin.structure, begin.state)
    history.start()
    world.start()
    try:
        yield world, history
    finally:
        world.close()
        history.close()


def killed(path: Path, to: Path) -> Path:
    """Return a copy of a folder as a kernel leaves it that is killed now: what it has written, at once."""
    shutil.rmtree(to, ignore_errors=True)
    to.mkdir()
    for name in (LAST_TICK, *TAIL, "journal.db-wal", "journal.db", "project.json"):
        if (path / name).exists():
            shutil.copy(path / name, to / name)
    return to


def begun(path: Path) -> Moment:
    """Return the world that a kernel on a folder begins with."""
    history = History(Folder(path), TICK, world_poses)
    history.store.close()
    history.close_files()
    return history.begin


def differ(one: Moment, world: World) -> str:
    """Return where a moment and a world differ, in any bit."""
    now = world.snapshot
    return same(image_of(one.structure, one.state), image_of(now.structure, now.state))


def settled(history: History) -> History:
    """Return a history once all that was told is in it."""
    history.settle()
    return history


def setup(world: World) -> None:
    """Have an arm, signals and a part."""
    signals = (CreateSignal(Signal(name, False)) for name in NAMES)
    world.submit([arm(), *signals, CreateNodes((part("cup", shifted(1.0)),))], "ann").result(GUARD)


def random_batch(world: World, rng: np.random.Generator) -> None:
    """Do something, or have it refused."""
    now = world.snapshot
    world.submit(drawn(rng, Change(now.structure, now.state)), "bob").exception(GUARD)


@pytest.mark.parametrize("entries", [3, 10_000])
def test_a_world_that_was_killed_is_there_again_bit_for_bit(
    tmp_path: Path, rng: np.random.Generator, draws: Draws, entries: int
) -> None:
    """With checkpoints every few entries, whose parts are shared, and from the entries alone."""
    with kernel(tmp_path / "a", Rules(entries=entries)) as (world, history):
        setup(world)
        for _ in range(draws(50)):
            random_batch(world, rng)
            world.step(int(rng.integers(1, 30))).result(GUARD)
            if rng.random() < 0.5:
                history.upkeep.look_after()
            if rng.random() < 0.2:
                assert differ(begun(killed(tmp_path / "a", tmp_path / "b")), world) == ""
        last = world.snapshot
        checkpoints = len(history.store.checkpoints())
        assert settled(history).store.check() == history.begin.number + history.store.last_seq
    assert (checkpoints > 1) == (entries == 3)
    begin = begun(tmp_path / "a")
    assert same(image_of(begin.structure, begin.state), image_of(last.structure, last.state)) == ""


def test_it_goes_on_at_rest_and_what_was_done_before_is_undone_after(tmp_path: Path, rng: np.random.Generator) -> None:
    with kernel(tmp_path) as (world, _):
        setup(world)
        world.submit([program(rng, world.snapshot.state, "a", 0)]).result(GUARD)
        world.submit([UpdateNode("cup", new_name="mug")], "ann").result(GUARD)
        was = world.step(20).result(GUARD)
    assert was.state.motions and was.state.v.any()
    with kernel(tmp_path) as (world, history):
        now = world.submit([RestartWorld()], "kernel").result(GUARD).snapshot.state
        assert np.array_equal(now.q, was.state.q) and not now.v.any() and now.tick == was.state.tick
        (ended,) = now.ended
        assert (ended.phase, ended.end_tick) == (Phase.ABORTED, now.tick)
        assert ended.cancellation and ended.cancellation.cause is EndCause.KERNEL_RESTARTED
        assert now.epoch == was.state.epoch + 1
        step = settled(history).steps.to_undo()
        assert (step.label, step.author, step.kind) == ("renamed 'cup' to 'mug'", "ann", StepKind.EDIT)
        assert [one.number for one in history.steps.store.find(Wanted(node="cup"))] == [3, 1]
    with kernel(tmp_path) as (world, _):
        assert not world.snapshot.state.motions and world.snapshot.state.tick == was.state.tick


def test_checkpoints_by_name_are_there_after_a_restart(tmp_path: Path, rng: np.random.Generator) -> None:
    with kernel(tmp_path) as (world, history):
        setup(world)
        made = settled(history).checkpoints.create("lunch", "ann")
        was = world.snapshot
        world.submit([ClearWorld()]).result(GUARD)
    with kernel(tmp_path) as (world, history):
        (found,) = history.checkpoints.all
        assert (found.name, found.author, found.id, found.node_count) == (
            "lunch",
            "ann",
            made.id,
            len(was.structure.nodes),
        )
        command = history.checkpoints.restoring(found)
        world.submit([command], "bob").result(GUARD)
        assert same(tuple(world.snapshot.structure.nodes.values()), tuple(was.structure.nodes.values())) == ""
        left = settled(history).checkpoints.left_by(command)
        assert left and left.automatic and left.node_count == 1 and left.author == "bob"
        assert [one.name for one in history.checkpoints.all] == ["lunch", left.name]
        history.checkpoints.remove("lunch")
    with kernel(tmp_path) as (world, history):
        assert [one.name for one in history.checkpoints.all] == [left.name]
        assert len(world.snapshot.structure.nodes) == len(was.structure.nodes)
        world.submit([history.checkpoints.restoring(left)]).result(GUARD)
        assert len(world.snapshot.structure.nodes) == 1
        history.store.check()


def test_a_damaged_checkpoint_leaves_the_one_before(tmp_path: Path, rng: np.random.Generator) -> None:
    with kernel(tmp_path, Rules(entries=2)) as (world, history):
        setup(world)
        for _ in range(6):
            random_batch(world, rng)
            world.step(3).result(GUARD)
            history.upkeep.look_after()
        store = settled(history).store
        assert len(store.checkpoints()) > 1
        newest = store.checkpoints()[-1].id
        store._writer.execute("UPDATE checkpoints SET body = x'00' WHERE id = ?", (newest,))
        codec = history.codec
        moment, warnings = recovered(store, codec, 0, TICK, world_poses)
        assert differ(moment, world) == ""
        assert len(warnings) == 1 and f"the checkpoint {newest} can't be read" in warnings[0]


def test_a_damaged_entry_is_named(tmp_path: Path) -> None:
    with kernel(tmp_path / "a") as (world, history):
        setup(world)
        for value in (True, False, True):
            world.submit([SetSignal(NAMES[0], value)]).result(GUARD)
        history.upkeep.look_after()
        copy = killed(tmp_path / "a", tmp_path / "b")
    database = sqlite3.connect(copy / "journal.db")
    database.execute("UPDATE entries SET commands = substr(commands, 2) WHERE seq = 3")
    database.commit()
    database.close()
    with pytest.raises(KernelError, match=r"journal\.db is damaged: the entry 3 has a wrong checksum"):
        begun(copy)


def test_nothing_changes_while_the_disk_is_full_and_all_is_kept_once_it_is_not(tmp_path: Path) -> None:
    """The database may not grow: SQLite says the same of a full disk."""
    with kernel(tmp_path / "a") as (world, history):
        setup(world)
        following = StartSetpointMotion("arm", ("a",), SetpointMode.POSITION, 1000.0)
        (motion,) = world.submit([following]).result(GUARD).created
        world.step(5).result(GUARD)
        run = history.store._writer.execute
        (pages,) = run("PRAGMA page_count").fetchone()
        run(f"PRAGMA max_page_count={pages}").fetchall()
        names, refused, until = count(), None, time.monotonic() + GUARD
        while refused is None and time.monotonic() < until:
            refused = world.submit([CreateSignal(Signal(f"signal {next(names)}", 0))]).exception(GUARD)
        assert isinstance(refused, KernelError) and refused.reason is Reason.WRONG_STATE
        assert "full" in str(refused) and "Make room" in str(refused)
        kept = begun(killed(tmp_path / "a", tmp_path / "b"))
        acknowledged = world.snapshot.state.signals.keys()
        assert acknowledged == kept.state.signals.keys(), "nothing that was answered is lost"

        before = world.snapshot.state
        for command in (SetSignal("signal 0", 1), ClearWorld()):
            assert isinstance(world.submit([command]).exception(GUARD), KernelError)
        assert world.snapshot.state is before
        assert world.step(3).result(GUARD).state.tick == before.tick + 3, "time goes on"
        world.submit([EndSetpoints(str(motion))]).result(GUARD)
        world.submit([StopMotions()]).result(GUARD)
        assert not world.step(100).result(GUARD).state.motions

        run("PRAGMA max_page_count=1000000").fetchall()
        until = time.monotonic() + GUARD
        while world.submit([SetSignal("signal 0", 2)]).exception(GUARD) and time.monotonic() < until:
            time.sleep(0.05)
        assert world.snapshot.state.signals["signal 0"].value == 2
        settled(history).store.check()
        assert differ(begun(killed(tmp_path / "a", tmp_path / "b")), world) == ""


def test_the_oldest_goes_and_the_rest_is_replayed(rng: np.random.Generator) -> None:
    """In memory, with room for few entries."""
    with kernel(None, Rules(entries=200, most_bytes=300_000)) as (world, history):
        setup(world)
        world.submit([UpdateNode("cup", new_name="mug")]).result(GUARD)
        for number in range(3000):
            done = world.submit([SetSignal(NAMES[number % 3], bool(rng.integers(2)))])
            if not number % 100:
                world.step(1).result(GUARD)
                done.result(GUARD)
                history.upkeep.look_after()
        done.result(GUARD)
        history.upkeep.look_after()
        store = settled(history).store
        assert store.forgotten > 1000 and store.size_bytes < 400_000
        store.check()
        moment, warnings = recovered(store, history.codec, 0, TICK, world_poses)
        assert not warnings and differ(moment, world) == ""
        assert history.steps.to_undo().label == "renamed 'cup' to 'mug'", (
            "edits are undone though their entries are gone"
        )


def test_what_is_older_goes_with_its_checkpoints(rng: np.random.Generator) -> None:
    with kernel(None, Rules(entries=5)) as (world, history):
        setup(world)
        for _ in range(20):
            world.submit([SetSignal(NAMES[0], bool(rng.integers(2)))]).result(GUARD)
            history.upkeep.look_after()
        assert len(history.store.checkpoints()) > 3 and not history.store.forgotten
        history.upkeep.rules = replace(history.upkeep.rules, most_seconds=-1.0)
        history.upkeep.look_after()
        (left,) = history.store.checkpoints()
        assert history.store.forgotten == left.seq > 15
        moment, _ = recovered(history.store, history.codec, 0, TICK, world_poses)
        assert differ(moment, world) == ""


def test_how_much_is_kept_is_said_in_words() -> None:
    assert rules_of("500MB", True).most_bytes == 500_000_000
    assert rules_of("1.5 GB, 30d", True) == replace(Rules(), most_bytes=1_500_000_000, most_seconds=30 * 86400.0)
    assert rules_of("12h", False).most_seconds == 43200.0
    assert rules_of("80MB", True).bytes == 10_000_000, "a checkpoint is due before all of it is to go"
    for wrong in ("5", "1MB", "x", "GB", "-3d", "0d", ",", "1e9MB"):
        with pytest.raises(KernelError, match="such as 500MB, 4GB"):
            rules_of(wrong, True)


def test_a_clock_that_is_set_back_changes_no_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator
) -> None:
    with kernel(tmp_path) as (world, history):
        setup(world)
        now = time.time()
        for number in range(10):
            monkeypatch.setattr(time, "time", lambda number=number: now - 1000.0 * number)
            world.submit([SetSignal(NAMES[0], bool(number % 2))]).result(GUARD)
        monkeypatch.undo()
        rows = list(settled(history).store.rows(1))
        assert [one.seq for one in rows] == [*range(2, 12)]
        assert all(one.time > other.time for one, other in pairwise(rows))
    assert begun(tmp_path).state.signals[NAMES[0]].value is True


def test_what_a_killed_kernel_left_in_its_tail_becomes_steps_and_checkpoints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As long as nobody has read its history, nothing of it is in the database."""
    monkeypatch.setattr(upkeep, "ROUND_SECONDS", 10.0 * GUARD)
    with kernel(tmp_path / "a") as (world, history):
        setup(world)
        settled(history).checkpoints.create("noon", "ann")
        world.submit([UpdateNode("cup", new_name="mug")], "ann").result(GUARD)
        world.submit([history.checkpoints.restoring(history.checkpoints.get("noon"))], "bob").result(GUARD)
        world.submit([UpdateNode("cup", new_name="jug")], "eve").result(GUARD)
        copy = killed(tmp_path / "a", tmp_path / "b")
        assert differ(begun(copy), world) == ""
        was = [astuple(one) for one in settled(history).store.steps()]
        checkpoints = [replace(one, wall_time=0.0) for one in history.checkpoints.all]
    found = sqlite3.connect(copy / "journal.db")
    assert found.execute("SELECT max(seq), max(number) FROM entries, steps").fetchone() == (1, 1)
    found.close()
    with kernel(copy) as (_, history):
        assert settled(history).steps.to_undo().label == "renamed 'cup' to 'jug'"
        assert [astuple(one) for one in history.store.steps()] == was and len(was) == 4
        assert [replace(one, wall_time=0.0) for one in history.checkpoints.all] == checkpoints
        assert len(checkpoints) == 2


def test_a_past_has_what_is_in_the_tail_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a kernel that goes on, whose folder stays as it is."""
    monkeypatch.setattr(upkeep, "ROUND_SECONDS", 10.0 * GUARD)
    with kernel(tmp_path) as (world, _):
        setup(world)
        world.step(5).result(GUARD)
        world.submit([SetSignal(NAMES[0], True)]).result(GUARD)
        world.step(5).result(GUARD)
        past = PastFolder(tmp_path)
        cursor = past.replay(world_poses).at(past.last_tick)
        assert differ(cursor.moment, world) == "" and cursor.moment.number == 2
        past.close()
        world.submit([SetSignal(NAMES[0], False)]).result(GUARD)
    assert begun(tmp_path).state.signals[NAMES[0]].value is False


def test_a_checkpoint_has_all_that_was_answered_before(tmp_path: Path, rng: np.random.Generator) -> None:
    """With setpoints at every tick, whose worlds nobody keeps."""
    with kernel(tmp_path) as (world, history):
        setup(world)
        (motion,) = world.submit([StartSetpointMotion("arm", ("a",), SetpointMode.POSITION, 1e9)]).result(GUARD).created
        for number in range(20):
            world.submit([SetSetpoint(str(motion), (0.01 * number,))]).result(GUARD)
            world.step(int(rng.integers(1, 10))).result(GUARD)
            made = settled(history).checkpoints.create("", "ann")
            left = image(history.store, history.codec, made.id)
            assert differ(Moment(0, left.structure, left.state), world) == ""


def test_a_disk_that_is_full_is_told_in_one_line(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full() -> None:
        raise sqlite3.OperationalError("database or disk is full")

    with kernel(None) as (_, history):
        monkeypatch.setattr(history.store, "tidy", full)
        for _ in range(3):
            history.upkeep.look_after()
    assert caplog.text.count("the history can't be looked after; it is tried again: database or disk is full") == 1
    assert "Traceback" not in caplog.text
