"""Gamepads without hardware: SDL's virtual ones, which programs open and read as any other."""

from __future__ import annotations

import ctypes
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from virtualrobot.cli.gamepad import AXES, BUTTONS

FULL = 32767


def library() -> Any:  # noqa: ANN401  a module without types
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import sdl2
    return sdl2


class VirtualPad:
    """A gamepad whose sticks and buttons a test moves; any thread may."""

    def __init__(self, index: int, handle: Any) -> None:  # noqa: ANN401  SDL's joystick
        """Take a virtual joystick that is open."""
        self._sdl, self._index, self._handle = library(), index, handle
        self._is_there = True
        self.felt: list[tuple[int, int]] = []
        """Strengths of both motors by which it was made to shake, 0 to 65535."""

    def move(self, **axes: float) -> None:
        """Move axes, by name, to values from -1 to 1."""
        for name, value in axes.items():
            self._sdl.SDL_JoystickSetVirtualAxis(self._handle, AXES.index(name), round(value * FULL))

    def press(self, *names: str, down: bool = True) -> None:
        """Press buttons, or let them go."""
        for name in names:
            self._sdl.SDL_JoystickSetVirtualButton(self._handle, BUTTONS.index(name), int(down))

    def unplug(self) -> None:
        """Take it away."""
        if self._is_there:
            self._is_there = False
            self._sdl.SDL_JoystickDetachVirtual(self._index)


@contextmanager
def virtual_pad() -> Iterator[VirtualPad]:
    """Plug in a gamepad, which shakes; it is gone at the end of the block."""
    sdl = library()
    assert sdl.SDL_InitSubSystem(sdl.SDL_INIT_GAMECONTROLLER) == 0, sdl.SDL_GetError()
    kind = sdl.SDL_JOYSTICK_TYPE_GAMECONTROLLER
    felt: list[tuple[int, int]] = []
    shakes = dict(sdl.SDL_VirtualJoystickDesc._fields_)["Rumble"]

    def shake(_: Any, low: int, high: int) -> int:  # noqa: ANN401  what SDL keeps for it
        felt.append((low, high))
        return 0

    about = sdl.SDL_VirtualJoystickDesc(version=sdl.SDL_VIRTUAL_JOYSTICK_DESC_VERSION, type=kind)
    about.naxes, about.nbuttons, about.Rumble = len(AXES), len(BUTTONS), shakes(shake)
    index = sdl.SDL_JoystickAttachVirtualEx(ctypes.byref(about))
    assert index >= 0, sdl.SDL_GetError()
    handle = sdl.SDL_JoystickOpen(index)
    pad = VirtualPad(index, handle)
    pad.felt = felt
    try:
        yield pad
    finally:
        pad.unplug()
        sdl.SDL_JoystickClose(handle)
        sdl.SDL_QuitSubSystem(sdl.SDL_INIT_GAMECONTROLLER)
