"""Twists that keys of a terminal mean: within limits, and none without somebody who holds one."""

from __future__ import annotations

import pytest
from virtualrobot.cli.key_screen import AGAIN_SECONDS, FIRST_SECONDS, HeldKey
from virtualrobot.cli.teleoperation import KEYS, REST, DriveKeys


class Time:
    """Time that the test lets go by."""

    now = 10.0

    def __call__(self) -> float:
        return self.now


def test_a_key_counts_until_it_is_repeated_and_a_little_longer() -> None:
    time = Time()
    held = HeldKey(time)
    assert held.key == ""
    held.press("w")
    time.now += FIRST_SECONDS - 0.01
    assert held.key == "w"
    for _ in range(100):
        held.press("w")
        time.now += AGAIN_SECONDS - 0.01
        assert held.key == "w"
    time.now += 0.02
    assert held.key == ""
    held.press("w")  # pressed anew: the terminal repeats it late again
    time.now += FIRST_SECONDS - 0.01
    held.press("a")
    time.now += FIRST_SECONDS - 0.01
    assert held.key == "a"
    held.release()
    assert held.key == ""


def test_keys_mean_twists_within_the_limits() -> None:
    keys = DriveKeys((0.4, 0.4, 0.8), clock=Time())
    meant: dict[str, tuple[float, ...]] = {}
    for key in KEYS:
        keys.press(key)
        meant[key] = keys.wanted()
    assert meant["w"] == meant["up"] == (0.4, 0.0, 0.0) and meant["s"] == meant["down"] == (-0.4, 0.0, 0.0)
    assert meant["a"] == meant["left"] == (0.0, 0.0, 0.8) and meant["d"] == meant["right"] == (0.0, 0.0, -0.8)
    # In bows the craft goes to the side of the keyboard where the key is: of u and m, and of o and the full stop.
    assert meant["u"] == (0.4, 0.0, 0.8) and meant["o"] == (0.4, 0.0, -0.8)
    assert meant["m"] == (-0.4, 0.0, -0.8) and meant["."] == (-0.4, 0.0, 0.8)
    assert meant["J"] == (0.0, 0.4, 0.0) and meant["L"] == (0.0, -0.4, 0.0)
    keys.press("?")
    assert keys.wanted() == meant["L"]
    keys.press(" ")
    assert keys.wanted() == REST


def test_brackets_slow_down_and_speed_up() -> None:
    keys = DriveKeys((0.4, 0.4, 0.8), clock=Time())
    keys.press("]")
    keys.press("u")
    assert (keys.share, keys.wanted()) == (1.0, (0.4, 0.0, 0.8))
    for share in (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.1):
        keys.press("[")
        assert keys.share == pytest.approx(share)
        assert keys.wanted() == pytest.approx((0.4 * share, 0.0, 0.8 * share))
