"""Time that waits for a film: no picture is lost, however slowly they are drawn."""

from __future__ import annotations

from typing import Any, cast

import pytest
from virtualrobot.view.pictures import Picture
from virtualrobot_apps.demos.palletizing.pacing import MOST_BEHIND, Pace

KEPT = 10_000
"""How many pictures the kernel keeps (docs/pictures-and-films.md)."""
RATE = 25.0


class Clock:
    """A clock whose calls are counted."""

    def __init__(self, speed: float) -> None:
        """Begin."""
        self.speed, self.calls = speed, 0

    @property
    def speed_factor(self) -> float:
        return self.speed

    @speed_factor.setter
    def speed_factor(self, factor: float) -> None:
        assert 0.01 <= factor <= 100.0
        self.speed, self.calls = factor, self.calls + 1


def filmed(speed: float, seconds: float, first: float, length: float = 600.0) -> tuple[Clock, float]:
    """Film so many seconds of simulation time, each picture drawn in `seconds` and the first one later.

    Returns the clock after it and the most pictures that ever waited.
    """
    clock = Clock(speed)
    wall = happened = most = 0.0
    pace = Pace(cast(Any, clock), RATE, lambda: wall)
    for number in range(int(length * RATE)):
        took = seconds + (first if number == 0 else 0.0)
        wall += took
        happened = min(happened + took * clock.speed, length)
        while number > happened * RATE:
            wall += 0.1
            happened = min(happened + 0.1 * clock.speed, length)
        most = max(most, happened * RATE - number)
        pace.told(Picture(b"", "raw", 0, 0, number / RATE, number, int(happened * RATE - number)))
    pace.end()
    return clock, most


@pytest.mark.long
@pytest.mark.parametrize("speed", [0.5, 1.0, 20.0, 100.0])
@pytest.mark.parametrize("seconds", [0.01, 0.2, 1.5])
def test_no_picture_is_lost(speed: float, seconds: float) -> None:
    clock, most = filmed(speed, seconds, first=20.0)
    assert most < 0.9 * KEPT
    assert clock.speed == speed
    assert clock.calls < 50


def test_time_is_left_alone_where_drawing_keeps_up() -> None:
    clock, most = filmed(1.0, 0.02, first=5.0)
    assert clock.calls == 0 and most < MOST_BEHIND
