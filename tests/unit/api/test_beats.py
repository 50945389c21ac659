"""Times at which beats of a held motion were sent, told from when they come."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.api.holding import BEAT_SECONDS, DRIFT, BeatClock


def test_beats_that_come_at_once_count_from_when_they_come() -> None:
    clock = BeatClock()
    for number in range(100):
        now = 7.0 + 0.05 * number
        assert clock.sent(now, 1000.0 + 0.05 * number) == pytest.approx(now, abs=1e-3)


def test_a_burst_of_what_was_held_up_is_old() -> None:
    """A network is cut for 5 s in which the key is let go after one; then all beats come at once."""
    clock = BeatClock()
    assert clock.sent(10.0, 0.0) == 10.0
    sent = np.arange(0.05, 1.0, 0.05)
    for said in sent.tolist():
        assert 15.0 - clock.sent(15.0, said) > BEAT_SECONDS
    assert clock.sent(15.01, 5.01) == pytest.approx(15.01, abs=DRIFT * 6.0), "the key is down again"


def test_the_beat_that_was_least_late_sets_the_clock() -> None:
    clock = BeatClock()
    clock.sent(10.5, 0.0)  # half a second late, which nobody can know yet
    assert clock.sent(10.05, 0.05) == pytest.approx(10.05)
    assert clock.sent(10.6, 0.1) == pytest.approx(10.1, abs=DRIFT)


@pytest.mark.parametrize("drift", [-0.9 * DRIFT, 0.9 * DRIFT])
def test_clocks_that_drift_hold_for_hours(drift: float) -> None:
    clock = BeatClock()
    for now in np.arange(0.0, 4 * 3600.0, 0.5).tolist():
        assert now - clock.sent(now, now * (1.0 + drift)) < BEAT_SECONDS / 10
