"""Cyclic programs: one image and one change a cycle, to the tick in stepped time, and none too often in real time."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
import virtualrobot
from virtualrobot.errors import InvalidArgumentError, UnknownNameError
from virtualrobot_apps.cell_io.scan import ScanCycle, Value


def test_scans_are_a_cycle_apart_and_write_at_one_instant(steps: virtualrobot.Client) -> None:
    for name in ("a", "b"):
        steps.signals.create(name, 0)
    length = steps.clock.read().tick_length
    with steps.signals.follow(["a", "b"]) as watch:
        changes = iter(watch)
        first = next(changes).stamp.tick
        times: list[float] = []

        def program(signals: Mapping[str, Value], now: float) -> dict[str, Value]:
            times.append(now)
            return {name: int(signals[name]) + 1 for name in ("a", "b")}  # type: ignore[arg-type]

        ScanCycle(steps, program, cycle=5 * length).run(cycles=4)
        seen = [next(changes) for _ in range(4)]
    assert [one.values for one in seen] == [{"a": count, "b": count} for count in (1, 2, 3, 4)]
    assert [one.stamp.tick - first for one in seen] == [0, 5, 10, 15]
    assert times == pytest.approx([0, 5 * length, 10 * length, 15 * length])


def test_each_scan_of_real_time_is_a_cycle_or_is_counted(client: virtualrobot.Client) -> None:
    """On a busy machine cycles are left out; those that ran and those that were left out are the time that went by."""
    client.signals.create("beat", 0)
    length = client.clock.read().tick_length
    times: list[float] = []

    def program(signals: Mapping[str, Value], now: float) -> dict[str, Value]:
        times.append(now)
        return {"beat": len(times)}

    plc = ScanCycle(client, program, cycle=10 * length)
    plc.run(cycles=10)
    assert client.signals["beat"] == 10
    cycles = [round(one / (10 * length)) for one in times]
    assert cycles == sorted(set(cycles)), "no cycle twice"
    assert len(times) - 1 <= cycles[-1] <= len(times) - 1 + plc.left_out


def test_a_program_s_faults_are_its_caller_s(steps: virtualrobot.Client) -> None:
    with pytest.raises(UnknownNameError):
        ScanCycle(steps, lambda signals, now: {"nothing": True}).run(cycles=1)
    for cycle in (0.0, -1.0, float("nan")):
        with pytest.raises(InvalidArgumentError, match="a cycle is at least a tick"):
            ScanCycle(steps, lambda signals, now: {}, cycle=cycle)
