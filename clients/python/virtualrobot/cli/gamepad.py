"""Events of a gamepad of this machine, by the package `inputs`."""

from __future__ import annotations

from collections.abc import Iterator

from virtualrobot.errors import WrongStateError


def events(number: int = 0) -> Iterator[tuple[str, float]]:
    """Yield axes and buttons of a gamepad as they change, until it is unplugged: their code and value.

    Raises:
        WrongStateError: when `inputs` is not installed, or there is no such gamepad.
    """
    try:
        import inputs
    except ImportError as error:
        raise WrongStateError("a gamepad needs the package inputs: pip install 'virtualrobot[gamepad]'") from error
    pads = inputs.devices.gamepads
    if number >= len(pads):
        there = f"there are {len(pads)}" if pads else "there is none"
        raise WrongStateError(f"no gamepad has the number {number}: {there}; plug it in before, and begin with 0")
    return _read(pads[number])


def _read(pad: object) -> Iterator[tuple[str, float]]:
    try:
        while True:
            for event in pad.read():  # pyright: ignore[reportAttributeAccessIssue] inputs has no types
                if event.ev_type in ("Absolute", "Key"):
                    yield str(event.code), float(event.state)
    except OSError:  # it was unplugged
        return
