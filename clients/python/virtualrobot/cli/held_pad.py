"""Wishes of somebody who holds a gamepad or a space mouse: values within limits, none without the dead man's button."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from virtualrobot.cli.gamepad import Pad, PadState
from virtualrobot.cli.gamepad_mapping import Control, GamepadMapping
from virtualrobot.cli.teleoperation import Share, Values

FRESH_SECONDS = 0.2
"""Time (s) for which a state of the gamepad counts; who reads it may hang."""


class HeldPad:
    """A gamepad or a space mouse that is read by one thread, and asked by another one what is wanted."""

    def __init__(
        self,
        pad: Pad,
        mapping: GamepadMapping,
        controls: Sequence[Control | None],
        limits: Sequence[float],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Take for each value its control, None for one that stays 0, and its greatest value."""
        self._pad, self._mapping, self._clock = pad, mapping, clock
        self._controls, self._limits = controls, limits
        self._share = Share()
        self._state, self._at = PadState(), -FRESH_SECONDS

    @property
    def share(self) -> float:
        """Share of the limits that is moved with, 0.1 to 1."""
        return self._share.part

    @property
    def is_held(self) -> bool:
        """True while the dead man's button is held, by a state that is fresh."""
        return self._mapping.hold in self._state.buttons and self._clock() - self._at < FRESH_SECONDS

    def read(self) -> None:
        """Read the gamepad; raises WrongStateError when it has gone, after which nothing is wanted."""
        before = self._state
        try:
            self._state = self._pad.read()
        except BaseException:
            self._state = PadState()
            raise
        self._at = self._clock()
        pressed = self._state.buttons - before.buttons
        self._share.change((self._mapping.faster in pressed) - (self._mapping.slower in pressed))

    def wanted(self) -> Values:
        """Return the values that are wanted now, in the units of the limits."""
        state = self._state
        if not self.is_held:
            return (0.0,) * len(self._limits)
        return tuple(
            0.0 if control is None else self.share * limit * control.value(state, self._mapping.dead_zone)
            for control, limit in zip(self._controls, self._limits, strict=True)
        )
