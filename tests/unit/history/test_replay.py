"""A replay is at any moment what was, from whichever checkpoint it comes; a verification finds the first difference."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.codec import Codec, same
from virtualrobot_kernel.history.documents import Parts
from virtualrobot_kernel.history.replay import Replay
from virtualrobot_kernel.history.rows import CheckpointRow, Row
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.tick_hash import BYTES, differing_robots, tick_hash
from virtualrobot_kernel.history.verify import verify
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Structure

from tests.tiers import Draws
from tests.unit.history.runs import Run, random_run
from tests.unit.world.builders import TICK, after, arm, empty

CODEC = world_codec()


def stored(run: Run, checkpoints: tuple[int, ...] = ()) -> Store:
    """Return a store in memory that has a run, with checkpoints before some entries."""
    store, memory = Store(), Parts()
    for number, entry in enumerate(run.entries):
        if number in checkpoints:
            structure, state = run.worlds[number]
            written = CODEC.encode_in_parts(image_of(structure, state), memory)
            parts = tuple(written.parts)
            row = CheckpointRow(0, number, state.tick, "", "", 0.0, len(structure.nodes), written.body, parts)
            store.add_checkpoint(row, written.fresh)
        store.write([Row(number + 1, entry.tick, 0.0, entry.author, CODEC.encode(entry.commands))])
    return store


def replay_of(run: Run, store: Store) -> Replay:
    return Replay(store, CODEC, TICK, world_poses, run.last[1].tick)


def hashes_of(run: Run) -> list[tuple[int, bytes]]:
    """Return the hashes of a run's ticks in blocks of a hundred."""
    every = [tick_hash(*one) for one in run.ticks]
    return [(at + 1, b"".join(every[at : at + 100])) for at in range(0, len(every), 100)]


def test_it_is_at_each_moment_what_was(rng: np.random.Generator, draws: Draws) -> None:
    """Forwards, backwards and at random; with checkpoints, with moments that are kept, and without."""
    run = random_run(rng, draws(250))
    count = len(run.entries)
    before = {state.tick: (structure, state) for structure, state in run.ticks}
    done = {entry.tick for entry in run.entries}
    for store in (stored(run), stored(run, (count // 3, count // 2))):
        replay = replay_of(run, store)
        for tick in [run.last[1].tick, 0, *rng.integers(0, run.last[1].tick, 10).tolist()]:
            cursor = replay.at(tick)
            assert cursor.state.tick == tick
            if tick and tick not in done:
                assert same(image_of(*before[tick]), image_of(cursor.structure, cursor.state)) == ""
        assert same(image_of(*run.last), image_of(*_at(replay, 10**9))) == ""
        assert replay.warnings == {}


@dataclass(frozen=True)
class Newer:
    """Command of a program to come."""

    number: int


def _at(replay: Replay, tick: int) -> tuple[Structure, State]:
    cursor = replay.at(tick)
    return cursor.structure, cursor.state


def test_moments_that_are_kept_change_nothing(
    rng: np.random.Generator, draws: Draws, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = random_run(rng, draws(150))
    monkeypatch.setattr("virtualrobot_kernel.history.replay.APART_SECONDS", 0.002)
    plain, kept = replay_of(run, stored(run)), replay_of(run, stored(run))
    kept.keep_moments()
    assert len(kept._kept) > 3
    for tick in rng.integers(0, run.last[1].tick, 20).tolist():
        assert same(image_of(*_at(plain, tick)), image_of(*_at(kept, tick))) == ""


def test_the_begin_is_the_oldest_checkpoint_where_entries_were_thinned_out(rng: np.random.Generator) -> None:
    run = random_run(rng, 40)
    count = len(run.entries)
    store = stored(run, (count // 2,))
    while store.forget(count // 2, 0):
        pass
    replay = replay_of(run, store)
    assert replay.first_tick == replay.at(0).state.tick == run.worlds[count // 2][1].tick
    assert same(image_of(*run.last), image_of(*_at(replay, 10**9))) == ""
    store.remove_checkpoints([1])
    with pytest.raises(KernelError, match=r"thinned out, and no checkpoint is left"):
        replay_of(run, store)


def test_what_was_is_verified(rng: np.random.Generator, draws: Draws) -> None:
    run = random_run(rng, draws(200))
    hashes = hashes_of(run)
    verdict = verify(replay_of(run, stored(run)), hashes)
    assert (verdict.ticks, verdict.tick, verdict.without_hash) == (len(run.ticks), None, 0)
    assert str(verdict) == f"{len(run.ticks)} ticks are the same"
    missing = verify(replay_of(run, stored(run)), [hashes[0], *hashes[2:]])
    assert (missing.tick, missing.ticks + missing.without_hash) == (None, len(run.ticks))


def check_planted(rng: np.random.Generator, count: int) -> None:
    """Fail unless each of so many differences is named: whichever bit of whichever joint in whichever tick it is."""
    run = random_run(rng, 20)
    store, recorded = stored(run), b"".join(tick_hash(*one) for one in run.ticks)
    moved = [at for at, (structure, _) in enumerate(run.ticks) if structure.robots]
    for _ in range(count):
        at = int(rng.choice(moved))
        structure, state = run.ticks[at]
        joints = {"q": state.q.copy(), "v": state.v.copy()}
        flipped = joints[rng.choice([*joints])]
        flipped.view(np.uint64)[rng.integers(len(flipped))] ^= np.uint64(1) << np.uint64(rng.integers(64))
        hashes = bytearray(recorded)
        hashes[at * BYTES : (at + 1) * BYTES] = tick_hash(structure, replace(state, **joints))
        verdict = verify(replay_of(run, store), [(1, bytes(hashes))])
        assert (verdict.tick, verdict.ticks, verdict.robots) == (at + 1, at, ("arm",))
        assert f"tick {at + 1} differs, by 'arm', after entry {verdict.entry}" in str(verdict)


def test_the_first_difference_is_named(rng: np.random.Generator) -> None:
    check_planted(rng, 20)


@pytest.mark.long
def test_a_thousand_differences_are_named(rng: np.random.Generator) -> None:
    check_planted(rng, 1000)


def test_a_difference_is_named_though_what_comes_after_it_is_damaged(rng: np.random.Generator) -> None:
    run = random_run(rng, 20)
    store, hashes = stored(run), b"".join(tick_hash(*one) for one in run.ticks)
    store._writer.execute("UPDATE entries SET crc = crc + 1 WHERE seq = 6")
    with pytest.raises(KernelError, match="the entry 6 has a wrong checksum"):
        verify(replay_of(run, store), [(1, hashes)])
    tick = run.entries[4].tick  # after it the next entry is read
    planted = bytearray(hashes)
    planted[(tick - 1) * BYTES] ^= 1
    assert verify(replay_of(run, store), [(1, bytes(planted))]).tick == tick


def test_robots_are_told_apart(rng: np.random.Generator, draws: Draws) -> None:
    """Of four robots always the one; of twenty five, since a byte of the hash is of every fourth one."""
    for count, most in ((4, 1), (20, 5)):
        change = after(empty(), *(arm(f"arm{number}") for number in range(count)))
        robots = sorted(change.structure.robots)
        was = tick_hash(change.structure, change.state)
        unclear = 0
        for _ in range(draws(500)):
            uid = int(rng.choice(robots))
            q = change.state.q.copy()
            q[int(rng.choice(range(len(q))[change.structure.robots[uid].q_slice]))] += rng.normal() * 1e-12
            now = tick_hash(change.structure, replace(change.state, q=q))
            assert now[:4] != was[:4]
            found = differing_robots(change.structure, was, now)
            assert uid in found
            unclear += len(found) > most
        assert unclear <= draws(500) / 25  # a byte is the same by chance in one of 256


def test_what_cannot_be_repeated_is_told_and_left_out(rng: np.random.Generator) -> None:
    run = random_run(rng, 20)
    store = stored(run)
    last = run.last[1].tick
    again = CODEC.encode(tuple(run.entries[0].commands))
    store.write([Row(len(run.entries) + 1, last, 0.0, "ann", again)])
    replay = replay_of(run, store)
    assert same(image_of(*run.last), image_of(*_at(replay, last))) == ""
    (warning,) = replay.warnings.values()
    assert warning.startswith(f"entry {len(run.entries) + 1} by ann can't be repeated: the name 'arm' is taken")


def test_what_a_newer_program_has_written_is_refused_by_its_entry(rng: np.random.Generator) -> None:
    run = random_run(rng, 20)
    store = stored(run)
    newer = Codec([Newer], versions={Newer: 2}, migrations={("Newer", 1): list}).encode((Newer(1),))
    store.write([Row(len(run.entries) + 1, run.last[1].tick, 0.0, "ann", newer)])
    number = len(run.entries) + 1
    with pytest.raises(KernelError, match=f"entry {number}: it has a 'Newer' of version 2, which this program doesn't"):
        replay_of(run, store).at(10**9)
