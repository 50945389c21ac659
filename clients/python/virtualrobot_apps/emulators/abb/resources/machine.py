"""The machine: panel, robots, signals."""

from __future__ import annotations

import math
from collections.abc import Callable

from virtualrobot.errors import UnknownNameError
from virtualrobot.signals import Signal

from virtualrobot_apps.emulators.abb.answers import Item
from virtualrobot_apps.emulators.abb.controller import Controller
from virtualrobot_apps.emulators.abb.refused import Refused, unknown
from virtualrobot_apps.emulators.abb.table import Call, resource

EXTERNAL = tuple("abcdef")
_NO_AXIS = "9E+09"


def controller_state(controller: Controller) -> str:
    """Return motoron or motoroff."""
    return "motoron" if controller.motors_on else "motoroff"


@resource("GET", "/rw/panel/ctrlstate", second="/rw/panel/ctrl-state")
def _state(call: Call) -> list[Item]:
    """`ctrlstate`: motoron or motoroff."""
    title = "ctrl-state" if call.second else "ctrlstate"
    return [Item("pnl-ctrlstate", title, {"ctrlstate": controller_state(call.controller)})]


@resource("POST", "/rw/panel/ctrlstate", "setctrlstate", second="/rw/panel/ctrl-state")
def _set_state(call: Call) -> None:
    """Gives the motors power or takes it, by `ctrl-state`; a program is stopped before."""
    wanted = call.needs("ctrl-state")
    if wanted not in ("motoron", "motoroff"):
        raise unknown("controller state that can be set", wanted, ("motoron", "motoroff"))
    call.controller.set_motors(wanted == "motoron")


@resource("GET", "/rw/panel/opmode")
def _mode(call: Call) -> list[Item]:
    """`opmode`: always AUTO."""
    return [Item("pnl-opmode", "opmode", {"opmode": "AUTO"})]


@resource("GET", "/rw/panel/speedratio")
def _speed(call: Call) -> list[Item]:
    """`speedratio`: the factor by which the kernel slows the controller's robots, in percent."""
    return [Item("pnl-speedratio", "speedratio", {"speedratio": round(100.0 * call.controller.speed)})]


@resource("POST", "/rw/panel/speedratio", "setspeedratio", second="/rw/panel/speedratio?action=setspeedratio")
def _set_speed(call: Call) -> None:
    """Sets it by `speed-ratio`, above 0 and up to 100."""
    percent = _number(call.needs("speed-ratio"))
    if not 0.0 < percent <= 100.0:
        raise Refused("INVALIDARG", f"speed-ratio is above 0 and at most 100, not {percent:g}")
    call.controller.speed = percent / 100.0


@resource("GET", "/rw/motionsystem/mechunits")
def _units(call: Call) -> list[Item]:
    """The robots, ROB_1 and so on."""
    return [
        Item("ms-mechunit-li", one.mechanical_unit, {"mode": "Activated", "type": "TCPRobot", "task": one.name})
        for one in call.controller.units.values()
    ]


@resource("GET", "/rw/motionsystem/mechunits/{unit}/jointtarget")
def _joints(call: Call) -> list[Item]:
    """Joints of a robot, in degrees."""
    joints = call.controller.joints(call.path["unit"])
    values = {f"rax_{number}": f"{value:.9g}" for number, value in enumerate(joints, 1)}
    return [Item("ms-jointtarget", call.path["unit"], values | {f"eax_{name}": _NO_AXIS for name in EXTERNAL})]


@resource("GET", "/rw/motionsystem/mechunits/{unit}/robtarget")
def _target(call: Call) -> list[Item]:
    """Pose of `tool` (tool0), in the frame `coordinate` (Base, World, Wobj with `wobj`), and the configuration."""
    asked = call.query
    names = asked.get("tool", "tool0"), asked.get("wobj", "wobj0"), asked.get("coordinate", "Base")
    (place, turn), conf = call.controller.target(call.path["unit"], *names)
    values = dict(zip(("x", "y", "z", "q1", "q2", "q3", "q4"), (f"{one:.9g}" for one in (*place, *turn)), strict=True))
    values |= dict(zip(("cf1", "cf4", "cf6", "cfx"), (f"{one:g}" for one in conf), strict=True))
    return [Item("ms-robtargets", call.path["unit"], values | {f"eax{name}": _NO_AXIS for name in EXTERNAL})]


@resource("GET", "/rw/iosystem/signals")
def _signals(call: Call) -> list[Item]:
    """The kernel's signals that are truths or numbers."""
    return [_signal_item(one, "ios-signal-li") for one in call.controller.client.signals.read() if _is_told(one)]


@resource("GET", "/rw/iosystem/signals/{path*}")
def _signal(call: Call) -> list[Item]:
    """A signal: its type and value. Network and unit before its name may be any."""
    return [_signal_item(signal(call.controller, call.path["path"]), "ios-signal")]


@resource("POST", "/rw/iosystem/signals/{path*}", "set", second="/rw/iosystem/signals/{path*}/set-value")
def _set_signal(call: Call) -> None:
    """Gives a signal the value `lvalue`."""
    one = signal(call.controller, call.path["path"])
    value = _number(call.needs("lvalue"))
    kind: Callable[[float], bool | int | float] = type(one.value)  # pyright: ignore[reportAssignmentType] a number's
    if kind is not float and value not in ((0.0, 1.0) if kind is bool else (round(value),)):
        wanted = "0 or 1" if kind is bool else "a whole number"
        raise Refused("INVALIDARG", f"the signal {one.name!r} takes {wanted}, not {value:g}")
    call.controller.client.signals[one.name] = kind(value)


def signal(controller: Controller, path: str) -> Signal:
    """Return the signal of a path, which is network, unit and name, or its name alone."""
    name = path.rstrip("/").rpartition("/")[2]
    if not name:
        raise Refused("UNRESOLVED_URL", "a signal has a name", 404)
    try:
        found = controller.client.signals.read([name])[0]
    except UnknownNameError:
        alike = [one for one in controller.client.signals.read() if one.name.lower() == name.lower()]
        if not alike:
            raise Refused("UNRESOLVED_URL", f"there is no signal {name!r}", 404) from None
        found = alike[0]
    if not _is_told(found):
        raise Refused("UNRESOLVED_URL", f"the signal {name!r} is a text or a group, which a controller has not", 404)
    return found


def logical(value: bool | int | float) -> str:
    """Return the value of a signal as it is told."""
    return f"{value:.9g}" if isinstance(value, float) else str(int(value))


def _is_told(one: Signal) -> bool:
    return isinstance(one.value, bool | int | float)


def _signal_item(one: Signal, kind: str) -> Item:
    assert isinstance(one.value, bool | int | float)
    letters = {bool: "D", int: "G", float: "A"}[type(one.value)] + ("I" if one.direction == "input" else "O")
    values = {"name": one.name, "type": letters, "lvalue": logical(one.value), "lstate": "not simulated"}
    return Item(kind, f"Local/DRV_1/{one.name}", values, f"signals/Local/DRV_1/{one.name}")


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise Refused("INVALIDARG", f"{text!r} is no number")
    return value
