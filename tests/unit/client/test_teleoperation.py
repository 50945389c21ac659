"""What keys and a gamepad want of a craft: within limits, and nothing without somebody who holds them."""

from __future__ import annotations

import pytest
from virtualrobot.cli import gamepad as module
from virtualrobot.cli.teleoperation import HELD_SECONDS, REST, Gamepad, HeldGamepad, HeldKeys, Limits
from virtualrobot.errors import InvalidArgumentError, WrongStateError

LIMITS = Limits(0.4, 0.8)

DRIVE = [("ABS_Y", -32768.0), ("BTN_TL", 1.0), ("ABS_X", 16384.0), ("ABS_Z", 255.0), ("ABS_RX", 900.0)]
"""Events of a gamepad as `inputs` told them: stick up, dead man's button, stick half to the right, a trigger, a rest
off the middle."""


def test_a_key_counts_while_it_is_repeated() -> None:
    now = [10.0]
    keys = HeldKeys(LIMITS, lambda: now[0])
    assert keys.twist() == REST
    keys.press("w")
    assert keys.twist() == (0.4, 0.0, 0.0)
    now[0] += HELD_SECONDS - 0.01
    keys.press("e")
    assert keys.twist() == (0.4, 0.0, 0.8)
    now[0] += HELD_SECONDS + 0.01
    assert keys.twist() == REST
    keys.press("left")
    assert keys.twist() == (0.0, 0.0, 0.8)
    keys.press(" ")
    assert keys.twist() == REST
    keys.press("?")
    assert keys.twist() == REST


def test_keys_are_slowed_and_never_beyond_the_limits() -> None:
    keys = HeldKeys(LIMITS, lambda: 0.0)
    for _ in range(30):
        keys.press("]")
    keys.press("s")
    assert keys.twist() == (-0.4, 0.0, 0.0)
    for _ in range(5):
        keys.press("[")
    assert keys.twist() == pytest.approx((-0.2, 0.0, 0.0))
    for _ in range(30):
        keys.press("[")
    assert keys.twist() == pytest.approx((-0.04, 0.0, 0.0))


def test_a_gamepad_drives_while_the_dead_mans_button_is_held() -> None:
    held = HeldGamepad(LIMITS)
    held.take(*DRIVE[0])
    assert held.twist() == REST
    for event in DRIVE[1:]:
        held.take(*event)
    forward, left, turn = held.twist()
    # Up is forward, and a stick half to the right turns right: beyond its dead zone (0.5 - 0.1) / 0.9 of the limit.
    assert (forward, left) == (0.4, 0.0)
    assert turn == pytest.approx(-0.8 * 0.4 / 0.9, rel=1e-3)
    held.take("BTN_TL", 0.0)
    assert held.twist() == REST


def test_a_gamepad_that_is_unplugged_is_held_by_nobody() -> None:
    held = HeldGamepad(LIMITS)
    held.follow(iter(DRIVE))
    assert held.gone and held.twist() == REST


def test_axes_of_other_ranges() -> None:
    held = HeldGamepad(LIMITS, Gamepad(lowest=0.0, highest=255.0, dead_man="BTN_TR"))
    for event in [("BTN_TR", 1.0), ("ABS_Y", 0.0), ("ABS_X", 127.0)]:
        held.take(*event)
    assert held.twist() == (0.4, 0.0, 0.0)
    held.take("ABS_Y", 10_000.0)  # beyond its range: no faster than the limit
    assert held.twist() == (-0.4, 0.0, 0.0)


@pytest.mark.parametrize(("speed", "turn"), [(0.0, 1.0), (0.5, -1.0), (float("nan"), 1.0), (0.5, float("inf"))])
def test_limits_that_are_none_are_refused(speed: float, turn: float) -> None:
    with pytest.raises(InvalidArgumentError, match="limits are above 0"):
        Limits(speed, turn)


class Pad:
    """A gamepad of `inputs`, whose events were recorded."""

    def __init__(self, *events: tuple[str, str, int]) -> None:
        """Tell these, and then be unplugged."""
        self.events = list(events)

    def read(self) -> list:
        if not self.events:
            raise OSError("No such device")
        kind, code, state = self.events.pop(0)
        return [type("Event", (), {"ev_type": kind, "code": code, "state": state})()]


def test_events_of_a_gamepad_come_until_it_is_unplugged(monkeypatch: pytest.MonkeyPatch) -> None:
    inputs = pytest.importorskip("inputs", reason="no package inputs: pip install 'virtualrobot[gamepad]'")
    pad = Pad(("Absolute", "ABS_Y", -100), ("Sync", "SYN_REPORT", 0), ("Key", "BTN_TL", 1))
    monkeypatch.setattr(inputs.devices, "gamepads", [pad])
    assert list(module.events()) == [("ABS_Y", -100.0), ("BTN_TL", 1.0)]
    with pytest.raises(WrongStateError, match="no gamepad has the number 1: there are 1"):
        next(module.events(1))
    monkeypatch.setattr(inputs.devices, "gamepads", [])
    with pytest.raises(WrongStateError, match="there is none"):
        next(module.events())
