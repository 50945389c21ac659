"""Memory that kernel and hosts share: what is written is read, and what is torn is never."""

from __future__ import annotations

import os
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from virtualrobot_sdk.drivers import Mode, Safety
from virtualrobot_sdk.drivers.shared import (
    BRAKE_ROWS,
    CELL,
    NEVER,
    SLOTS,
    CellBlock,
    Report,
    State,
    TickRing,
    make_folder,
    stop_cell,
)

K = 6


class TestTheCellsBlock:
    def test_it_says_what_was_written_to_all_who_attach(self, tmp_path: Path) -> None:
        cell = CellBlock.create(tmp_path / CELL)
        other = CellBlock.attach(tmp_path / CELL)
        assert (other.newest, other.newest_braked, other.stop_ns) == (-1, -1, NEVER)
        cell.complete(7, True)
        cell.complete(8, False)
        assert (other.newest, other.newest_braked) == (8, 7)
        other.close()
        cell.close()

    def test_the_first_stop_holds_until_it_is_released(self, tmp_path: Path) -> None:
        cell = CellBlock.create(tmp_path / CELL)
        cell.stop(50)
        cell.stop(70)
        assert (cell.stop_ns, cell.commit(4), cell.commit(5), cell.committed) == (50, 4, 4, 4)
        cell.release()
        assert (cell.stop_ns, cell.committed) == (NEVER, -1)
        before = time.monotonic_ns()
        stop_cell(tmp_path)
        assert before <= cell.stop_ns <= time.monotonic_ns()

    def test_what_is_no_cell_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(OSError, match=CELL):
            stop_cell(tmp_path)
        (tmp_path / CELL).write_bytes(b"x" * 100)
        with pytest.raises(ValueError, match="100 bytes; 4096 are expected"):
            stop_cell(tmp_path)
        (tmp_path / CELL).write_bytes(b"x" * 4096)
        with pytest.raises(ValueError, match="another version"):
            stop_cell(tmp_path)

    def test_its_folder_is_its_owners_alone(self) -> None:
        folder = make_folder()
        try:
            assert os.name == "nt" or folder.stat().st_mode & 0o777 == 0o700
        finally:
            folder.rmdir()


class TestARing:
    def test_a_tick_is_read_as_it_was_written(self, tmp_path: Path, rng: np.random.Generator) -> None:
        ring = TickRing.create(tmp_path / "r", K)
        host = TickRing.attach(tmp_path / "r", K)
        q, v, brake = rng.normal(size=K), rng.normal(size=K), rng.normal(size=(70, K))
        assert ring.put(5, 123, q, v, 2**62 + 1, brake)
        assert not ring.put(6, 124, q, v, 0, None)
        assert not ring.put(7, 125, q, v, 0, np.zeros((BRAKE_ROWS + 1, K)))
        one = host.get(5)
        assert one is not None and one.brake is not None
        assert (one.tick, one.play_ns, one.outputs) == (5, 123, 2**62 + 1)
        assert np.array_equal(one.q, q) and np.array_equal(one.v, v) and np.array_equal(one.brake, brake)
        assert (two := host.get(6)) is not None and two.brake is None
        assert host.get(4) is None and host.get(-1) is None
        ring.put(5 + SLOTS, 126, q, v, 0, None)
        assert host.get(5) is None

    def test_ticks_of_a_rest_are_read_as_if_each_were_written(self, tmp_path: Path, rng: np.random.Generator) -> None:
        """A kernel that tells a rest once says what one says that writes each tick, to whoever reads within a ring."""
        short, long = TickRing.create(tmp_path / "s", K), TickRing.create(tmp_path / "l", K)
        host = TickRing.attach(tmp_path / "s", K)
        tick = 0
        told = []
        # Short ones are more than a ring knows rests: those are written tick by tick.
        for length in (1, SLOTS, *[3] * 20, SLOTS + 1, 3 * SLOTS, 2, *[7] * 30, 2 * SLOTS + 7):
            q = rng.normal(size=K)
            joints, outputs = short.joints_of(q, np.zeros(K), q[None]), int(rng.integers(8))
            lasts = False
            for place in range(length):
                long.put_joints(tick, 4 * tick, outputs, joints)
                lasts = lasts or (place > 0 and short.rest(tick, 4 * tick, outputs, joints, 4))
                if not lasts:
                    short.put_joints(tick, 4 * tick, outputs, joints)
                # The whole ring where a long rest begins or ends, else some of it.
                whole = length > SLOTS and place in (0, 1, length - 1)
                every = range(SLOTS) if whole else (0, 1, 2, 3, 7, 15, 60, SLOTS - 1)
                for back in (back for back in every if back <= tick):
                    one, same = host.get(tick - back), long.get(tick - back)
                    assert one is not None and same is not None and one.brake is not None and same.brake is not None
                    assert (one.tick, one.play_ns, one.outputs) == (same.tick, same.play_ns, same.outputs)
                    assert (one.q == same.q).all() and (one.v == same.v).all() and (one.brake == same.brake).all()
                tick += 1
            told.append(lasts)
        assert told.count(True) > 10 and told.count(False) > 10
        short.clear()
        assert host.get(tick - 1) is None

    def test_a_rest_that_is_torn_is_gone(self, tmp_path: Path) -> None:
        ring = TickRing.create(tmp_path / "r", K)
        ring.rest(7, 0, 0, ring.joints_of(np.ones(K), np.zeros(K), np.ones((1, K))), 4)
        content = np.memmap(tmp_path / "r", np.int64)
        assert ring.get(7) is not None and ring.get(90) is not None and ring.get(6) is None
        content[int(np.flatnonzero(content.view(np.float64) == 1.0)[0])] ^= 0x5A00
        assert ring.get(7) is None and ring.get(90) is None

    def test_the_pulse_of_reports_tells_when_more_is_new_than_a_cycle(self, tmp_path: Path) -> None:
        ring = TickRing.create(tmp_path / "r", K)
        host = TickRing.attach(tmp_path / "r", K)
        rest = State.ACTIVE, 0, 0, 0, -1, False, Mode.RUNNING, Safety.NORMAL, 0, 0, 1.0, 1.0
        said = Report(0, *rest, q=np.zeros(K), v=np.zeros(K), error=np.zeros(K))
        assert (ring.pulse()[:2], ring.played) == ((0, 0), -1)
        host.report(said)
        news = ring.pulse()[1]
        error = np.zeros(K)
        error[2] = -0.25
        host.report(replace(said, ns=9, cycles=5, skipped=2, lateness_ns=3, tick=7, q=np.ones(K), error=error))
        assert (ring.pulse(), ring.played) == ((5, news, 0.25), 7)
        changed: list[dict[str, Any]] = [
            *({"state": State.STOPPING}, {"on_brake": True}, {"mode": Mode.LOCAL}, {"inputs": 4}, {"words": 1}),
            *({"safety": Safety.FAULT}, {"rate": 0.5}, {"speed_scaling": 0.5}, {"is_faulty": True}),
        ]
        for change in changed:
            said = replace(said, **change)
            host.report(said)
            news += 1
            assert ring.pulse()[1] == news, change
        host.report(replace(said, tick=-1, error=np.full(K, np.nan)))
        assert np.isnan(ring.pulse()[2]) and ring.played == 7
        ring.clear()
        assert ring.played == -1

    @pytest.mark.parametrize("word", [2, 7, 20], ids=["head", "joints", "brake"])
    def test_a_torn_tick_is_gone(self, tmp_path: Path, word: int) -> None:
        """A slot's words: six of its head, two of each joint, then its brake."""
        ring = TickRing.create(tmp_path / "r", K)
        ring.put(0, 0, np.zeros(K), np.zeros(K), 0, np.ones((3, K)))
        content = np.memmap(tmp_path / "r", np.int64)
        first = int(np.flatnonzero(content.view(np.float64) == 1.0)[0]) - 2 * K - 6
        assert ring.get(0) is not None
        content[first + word] ^= 0x5A00
        assert ring.get(0) is None

    def test_what_is_overwritten_while_it_is_read_is_never_wrong(self, tmp_path: Path) -> None:
        """All numbers of a tick are equal, so that a mixture of two shows."""
        ring, over = TickRing.create(tmp_path / "r", K), threading.Event()
        host = TickRing.attach(tmp_path / "r", K)

        def write() -> None:
            for tick in range(0, 3000 * SLOTS, SLOTS):
                full = np.full((42, K), float(tick))
                ring.put(tick, tick, full[0], full[1], tick, full[2:])
            over.set()

        thread = threading.Thread(target=write)
        thread.start()
        tick = 0
        while not over.is_set():
            one = host.get(tick)
            if one is None:
                tick += SLOTS if tick < 2999 * SLOTS else -tick
                continue
            assert one.brake is not None and (one.brake == tick).all() and (one.q == tick).all()
        thread.join()
        assert host.get(2999 * SLOTS) is not None

    def test_a_report_comes_back_whole(self, tmp_path: Path, rng: np.random.Generator) -> None:
        ring = TickRing.create(tmp_path / "r", K)
        host = TickRing.attach(tmp_path / "r", K)
        assert ring.reported() is None
        q, v = rng.normal(size=K), rng.normal(size=K)
        said = Report(
            *(77, State.ACTIVE, 9, 3, 1000, 42, True, Mode.RUNNING, Safety.REDUCED, 2**64 - 1, 2, 0.5, 0.7),
            *(q, v, q + 1.0, True),
        )
        host.report(said)
        one = ring.reported()
        assert one is not None
        for name in Report.__dataclass_fields__:
            assert np.array_equal(getattr(one, name), getattr(said, name)), name
        assert ring.reported() is one
        host.report(said)
        assert ring.reported() is not one
