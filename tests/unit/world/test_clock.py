"""The pacer against a clock that the test sets: when ticks are due, and what happens when they are late."""

from __future__ import annotations

import pytest
from virtualrobot_kernel.world.clock import CATCH_UP_SECONDS, Clock, Mode, Pacer

TICK = 0.004


def pacer(speed: float = 1.0) -> Pacer:
    return Pacer(Clock(Mode.REALTIME, speed, 4_000_000), 0.0)


def test_ticks_are_due_one_period_apart() -> None:
    pace = pacer(2.0)
    due = []
    for _ in range(5):
        now = (due[-1] if due else 0.0) + (pace.wait_seconds(due[-1] if due else 0.0) or 0.0)
        due.append(now)
        pace.ticked(now)
    assert due == pytest.approx([TICK / 2 * count for count in range(1, 6)])


def test_a_little_lateness_is_caught_up_by_ticks_in_a_row() -> None:
    pace = pacer()
    now, ticks = 10.5 * TICK, 0
    while pace.wait_seconds(now) == 0.0:
        pace.ticked(now)
        ticks += 1
    assert ticks == 10
    assert pace.clock.late_ticks == 9  # all but the last, which is half a period late


def test_much_lateness_lets_simulation_time_fall_behind() -> None:
    pace = pacer()
    now = CATCH_UP_SECONDS + 1.0
    assert pace.wait_seconds(now) == 0.0
    pace.ticked(now)
    assert pace.wait_seconds(now) == pytest.approx(TICK)


def test_the_real_time_factor_is_what_was_reached() -> None:
    pace, now = pacer(), 0.0
    for _ in range(1000):
        now += 2 * TICK  # a machine that manages half the rate
        pace.ticked(now)
    assert pace.clock.real_time_factor == pytest.approx(0.5, rel=0.02)


def test_stepped_time_is_never_due() -> None:
    pace = pacer()
    pace.set(Mode.STEPPED, 1.0, 5.0)
    assert pace.wait_seconds(100.0) is None
