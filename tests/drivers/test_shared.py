"""Memory that kernel and hosts share: what is written is read, and what is torn is never."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_sdk.drivers import Mode, Safety
from virtualrobot_sdk.drivers.shared import (
    CELL_FILE,
    NEVER,
    SLOTS,
    CellBlock,
    HostState,
    Report,
    TickRing,
    shared_folder,
    stop_cell,
)

K = 6


class TestTheCellsBlock:
    def test_it_says_what_was_written_to_all_who_attach(self, tmp_path: Path) -> None:
        cell = CellBlock.create(tmp_path / CELL_FILE)
        other = CellBlock.attach(tmp_path / CELL_FILE)
        assert (other.newest, other.newest_braked, other.stop_ns, other.stopped) == (-1, -1, NEVER, False)
        cell.complete(7)
        cell.complete(8, braked=False)
        cell.beat(5)
        cell.ramp_ns = 9
        assert (other.newest, other.newest_braked, other.beaten_ns, other.ramp_ns) == (8, 7, 5, 9)
        other.close()
        cell.close()
        assert not list(tmp_path.iterdir())

    def test_the_earliest_stop_holds_until_it_is_released(self, tmp_path: Path) -> None:
        cell = CellBlock.create(tmp_path / CELL_FILE)
        cell.stop(50)
        cell.stop(70)
        assert cell.stop_ns == 50
        cell.release()
        assert not cell.stopped
        before = time.monotonic_ns()
        stop_cell(tmp_path)
        assert before <= cell.stop_ns <= time.monotonic_ns()

    def test_what_is_no_cell_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(OSError, match=CELL_FILE):
            stop_cell(tmp_path)
        (tmp_path / CELL_FILE).write_bytes(b"x" * 100)
        with pytest.raises(OSError, match="too short"):
            stop_cell(tmp_path)
        (tmp_path / CELL_FILE).write_bytes(b"x" * 5000)
        with pytest.raises(OSError, match="another number"):
            stop_cell(tmp_path)

    def test_its_folder_is_its_owners_alone(self) -> None:
        folder = shared_folder()
        try:
            assert os.name == "nt" or folder.stat().st_mode & 0o777 == 0o700
        finally:
            folder.rmdir()


class TestARing:
    def test_a_tick_is_read_as_it_was_written(self, tmp_path: Path, rng: np.random.Generator) -> None:
        ring = TickRing.create(tmp_path / "r", K)
        host = TickRing.attach(tmp_path / "r")
        q, v, brake = rng.normal(size=K), rng.normal(size=K), rng.normal(size=(70, K))
        assert ring.put(5, 123, q, v, 2**63 + 1, brake)
        assert not ring.put(6, 124, q, v, 0, None)
        assert not ring.put(7, 125, q, v, 0, np.zeros((ring.rows + 1, K)))
        one = host.get(5)
        assert one is not None and one.brake is not None
        assert (one.tick, one.play_ns, one.outputs) == (5, 123, 2**63 + 1)
        assert np.array_equal(one.q, q) and np.array_equal(one.v, v) and np.array_equal(one.brake, brake)
        assert (two := host.get(6)) is not None and two.brake is None
        assert host.get(4) is None and host.get(-1) is None
        ring.put(5 + SLOTS, 126, q, v, 0, None)
        assert host.get(5) is None

    @pytest.mark.parametrize("place", ["head", "joints", "brake"])
    def test_a_torn_tick_is_gone(self, tmp_path: Path, place: str) -> None:
        ring = TickRing.create(tmp_path / "r", K)
        ring.put(0, 0, np.zeros(K), np.zeros(K), 0, np.ones((3, K)))
        with (tmp_path / "r").open("r+b") as file:
            file.seek(8192 + {"head": 17, "joints": 50, "brake": 48 + 96 + 8}[place])
            file.write(b"\x5a")
        assert ring.get(0) is None

    def test_what_is_overwritten_while_it_is_read_is_never_wrong(self, tmp_path: Path) -> None:
        """All numbers of a tick are equal, so that a mixture of two shows."""
        ring, over = TickRing.create(tmp_path / "r", K), threading.Event()
        host = TickRing.attach(tmp_path / "r")

        def write() -> None:
            for tick in range(0, 3000 * SLOTS, SLOTS):
                ring.put(tick, tick, np.full(K, tick), np.full(K, tick), tick, np.full((40, K), tick))
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
        host = TickRing.attach(tmp_path / "r")
        assert ring.reported() is None
        q, v = rng.normal(size=K), rng.normal(size=K)
        host.report(
            Report(
                HostState.ACTIVE,
                42,
                0.5,
                True,
                q,
                v,
                q + 1.0,
                Mode.RUNNING,
                Safety.REDUCED,
                2**64 - 1,
                0.7,
                9,
                3,
                1e-4,
                2,
                77,
            )
        )
        one = ring.reported()
        assert one is not None and one.active and not one.faulty and one.braking
        assert (one.state, one.tick, one.rate, one.mode, one.safety) == (
            *(HostState.ACTIVE, 42, 0.5, Mode.RUNNING, Safety.REDUCED),
        )
        assert (one.inputs, one.speed_scaling, one.cycles, one.skipped) == (2**64 - 1, 0.7, 9, 3)
        assert (one.lateness, one.fault, one.at_ns) == (1e-4, 2, 77)
        assert np.array_equal(one.positions, q)
        assert np.array_equal(one.played, q + 1.0)
        host.report(Report(state=HostState.ERROR))
        assert (two := ring.reported()) is not None and two.faulty
        assert np.isnan(two.positions).all()

    def test_wrong_sizes_are_refused(self, tmp_path: Path) -> None:
        ring = TickRing.create(tmp_path / "r", K)
        with pytest.raises(ValueError, match="6 joints"):
            ring.put(0, 0, np.zeros(5), np.zeros(5), 0, None)
        with pytest.raises(ValueError, match="1 to 64"):
            TickRing.create(tmp_path / "s", 0)
