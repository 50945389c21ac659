"""Gamepads of this machine, by SDL: their sticks and buttons, and whether they are still there."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from virtualrobot.errors import WrongStateError

AXES = ("left_x", "left_y", "right_x", "right_y", "left_trigger", "right_trigger")
"""Axes in SDL's order: sticks from -1 to 1, to the right and down, triggers from 0 to 1."""

BUTTONS = (
    *("a", "b", "x", "y", "back", "guide", "start", "left_stick", "right_stick", "left_shoulder", "right_shoulder"),
    *("dpad_up", "dpad_down", "dpad_left", "dpad_right"),
)
"""Buttons in SDL's order; a to y are those of an Xbox controller: below, right, left, above."""

FELT_SECONDS = 0.2
"""Longest time (s) for which a gamepad shakes without being told so again."""

_FULL = 32767.0
_HINTS = {
    # Nothing here has a window: it hears the gamepad all the same.
    b"SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS": b"1",
    # A program is ended by signals as any other.
    b"SDL_NO_SIGNAL_HANDLERS": b"1",
}


@dataclass(frozen=True)
class PadState:
    """State of a gamepad: values of axes, 0 where there is none, and the buttons that are down."""

    axes: Mapping[str, float] = field(default_factory=dict)
    buttons: frozenset[str] = frozenset()


class Pad(Protocol):
    """A gamepad or a space mouse."""

    name: str

    def read(self) -> PadState:
        """Return how it is now; raise WrongStateError when it has gone."""
        ...


@runtime_checkable
class FeelingPad(Pad, Protocol):
    """A device that lets a hand feel."""

    def feel(self, strength: float) -> None:
        """Shake, from 0 to 1, until told otherwise, at most FELT_SECONDS; raise WrongStateError without motors."""
        ...


class Gamepad:
    """The first gamepad that this machine has; a native handle. One thread makes it, reads it and closes it."""

    def __init__(self) -> None:
        """Open it; raise WrongStateError where there is none, and where the library is missing."""
        self._sdl = sdl = _library()
        for hint, value in _HINTS.items():
            sdl.SDL_SetHint(hint, value)
        if sdl.SDL_InitSubSystem(sdl.SDL_INIT_GAMECONTROLLER):
            raise WrongStateError(f"SDL finds no gamepads: {sdl.SDL_GetError().decode()}")
        number = next((n for n in range(sdl.SDL_NumJoysticks()) if sdl.SDL_IsGameController(n)), None)
        self._handle = None if number is None else sdl.SDL_GameControllerOpen(number)
        if not self._handle:
            sdl.SDL_QuitSubSystem(sdl.SDL_INIT_GAMECONTROLLER)
            raise WrongStateError("no gamepad is connected; connect one, and start again")
        self.name = (sdl.SDL_GameControllerName(self._handle) or b"gamepad").decode()

    def read(self) -> PadState:
        """Return how it is now; raise WrongStateError when it has gone."""
        sdl = self._sdl
        sdl.SDL_GameControllerUpdate()
        if not sdl.SDL_GameControllerGetAttached(self._handle):
            raise WrongStateError(f"the gamepad {self.name} has gone")
        axes = {
            name: max(-1.0, sdl.SDL_GameControllerGetAxis(self._handle, number) / _FULL)
            for number, name in enumerate(AXES)
        }
        down = (name for n, name in enumerate(BUTTONS) if sdl.SDL_GameControllerGetButton(self._handle, n))
        return PadState(axes, frozenset(down))

    def feel(self, strength: float) -> None:
        """Shake, from 0 to 1, until told otherwise, at most FELT_SECONDS; raise WrongStateError without motors."""
        level = round(strength * 0xFFFF)
        if self._sdl.SDL_GameControllerRumble(self._handle, level, level, round(1000 * FELT_SECONDS)):
            raise WrongStateError(
                f"the gamepad {self.name} has no motors to feel a force by; leave `force` out of the mapping"
            )

    def close(self) -> None:
        """Let it go."""
        self._sdl.SDL_GameControllerClose(self._handle)
        self._sdl.SDL_QuitSubSystem(self._sdl.SDL_INIT_GAMECONTROLLER)

    def __enter__(self) -> Gamepad:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Let it go."""
        self.close()


def _library() -> Any:  # noqa: ANN401  a module that may be missing
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it tells where its library is from
            import sdl2
    except ImportError:
        raise WrongStateError("gamepads need the package pysdl2: pip install 'virtualrobot[gamepad]'") from None
    return sdl2
