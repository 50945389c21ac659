"""Space mice of this machine, by hidapi: how their cap is moved and turned, and which buttons are down.

Reports are those of 3Dconnexion's devices (USB HID, usage page 1, usage 8, a multi-axis controller), little-endian
numbers of 16 bits up to about 350 either way: report 1 has the translation x, y, z, of newer devices the rotation after
it, report 2 the rotation, report 3 the buttons as bits. A resting cap is 0; nothing is reported while nothing changes.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from typing import Any

from virtualrobot.cli.gamepad import PadState
from virtualrobot.errors import WrongStateError

AXES = ("x", "y", "z", "rx", "ry", "rz")
"""Axes of the cap, -1 to 1: to the right, towards the hand, down, and the turns about them by the right hand."""

BUTTONS = ("left", "right", *(f"button_{number}" for number in range(3, 33)))
"""Buttons in the order of their bits."""

FULL = 350.0
"""Greatest count of an axis."""

TRANSLATION, ROTATION, PRESSED = 1, 2, 3
"""Numbers of reports."""

_MAKER, _OLD_MAKER = 0x256F, 0x046D
#: Devices that Logitech sold: SpaceMouse Plus and Classic, SpaceBall 5000, SpaceTraveler, SpacePilot, SpaceNavigator,
#: SpaceExplorer, SpaceNavigator for notebooks, SpacePilot Pro (3Dconnexion, list of product ids; as in spacenavd).
_OLD = frozenset({0xC603, 0xC605, 0xC606, 0xC621, 0xC623, 0xC625, 0xC626, 0xC627, 0xC628, 0xC629, 0xC62B})
_MULTI_AXIS = (1, 8)
_LONGEST = 64


class SpaceMouse:
    """The first space mouse that this machine has; a native handle. One thread makes it, reads it and closes it."""

    def __init__(self, library: Any = None) -> None:  # noqa: ANN401  hidapi's module, or what stands for it
        """Open it; raise WrongStateError where there is none or it may not be opened, and without the library."""
        hid = library or _library()
        found = next(filter(_is_space_mouse, hid.enumerate()), None)
        if found is None:
            raise WrongStateError("no space mouse is connected; connect one, and start again")
        self.name = str(found.get("product_string") or "space mouse")
        self._device = hid.device()
        try:
            self._device.open_path(found["path"])
            self._device.set_nonblocking(True)
        except OSError as error:
            raise WrongStateError(
                f"the space mouse {self.name} cannot be opened: {error}; on Linux a rule of udev lets users do that, "
                'such as KERNEL=="hidraw*", ATTRS{idVendor}=="256f", MODE="0666"'
            ) from None
        self._counts = [0] * len(AXES)
        self._pressed = 0

    def read(self) -> PadState:
        """Return how it is now; raise WrongStateError when it has gone."""
        try:
            while report := self._device.read(_LONGEST):
                self._take(bytes(report))
        except (OSError, ValueError):
            raise WrongStateError(f"the space mouse {self.name} has gone") from None
        axes = {name: max(-1.0, min(1.0, count / FULL)) for name, count in zip(AXES, self._counts, strict=True)}
        return PadState(axes, frozenset(name for bit, name in enumerate(BUTTONS) if self._pressed >> bit & 1))

    def close(self) -> None:
        """Let it go."""
        self._device.close()

    def _take(self, report: bytes) -> None:
        """Take what a report tells; one that is too short, or of another kind, tells nothing."""
        kind, data = report[0], report[1:]
        if kind in (TRANSLATION, ROTATION):
            values = struct.unpack(f"<{len(data) // 2}h", data[: len(data) // 2 * 2])
            first = 0 if kind == TRANSLATION else 3
            count = 6 if kind == TRANSLATION and len(values) >= 6 else 3
            if len(values) >= 3:
                self._counts[first : first + count] = values[:count]
        elif kind == PRESSED and data:
            self._pressed = int.from_bytes(data[:4], "little")

    def __enter__(self) -> SpaceMouse:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Let it go."""
        self.close()


def _is_space_mouse(info: Mapping[str, Any]) -> bool:
    """Return whether a device is one; some systems don't tell what it is used for."""
    usage = info.get("usage_page", 0), info.get("usage", 0)
    if info["vendor_id"] == _OLD_MAKER:
        return info["product_id"] in _OLD and usage in (_MULTI_AXIS, (0, 0))
    return info["vendor_id"] == _MAKER and usage == _MULTI_AXIS


def within(values: Iterable[float], speed: float, turn: float) -> tuple[float, ...]:
    """Return a twist (6,) whose velocity and angular velocity are shortened to `speed` (m/s) and `turn` (rad/s)."""
    vx, vy, vz, wx, wy, wz = values
    fast, turning = (vx * vx + vy * vy + vz * vz) ** 0.5, (wx * wx + wy * wy + wz * wz) ** 0.5
    less = min(1.0, speed / fast) if fast else 1.0
    calmer = min(1.0, turn / turning) if turning else 1.0
    return vx * less, vy * less, vz * less, wx * calmer, wy * calmer, wz * calmer


def _library() -> Any:  # noqa: ANN401  a module that may be missing
    try:
        import hid
    except ImportError:
        raise WrongStateError("space mice need the package hidapi: pip install 'virtualrobot[space-mouse]'") from None
    return hid
