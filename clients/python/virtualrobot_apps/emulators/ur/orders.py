"""Orders to an emulated controller, a line each: what a person does at a real one, and what happens to it."""

from __future__ import annotations

from collections.abc import Callable

from virtualrobot_apps.emulators.ur.controller import Controller

ORDERS: dict[str, Callable[[Controller], None]] = {
    "protective stop": lambda controller: controller.protective_stop("Position deviates from path: Shoulder"),
    "safeguard stop": Controller.safeguard_stop,
    "emergency stop": Controller.emergency_stop,
    "release": Controller.release,
    "power off": Controller.power_off,
    "power on": Controller.power_on,
    "brake release": Controller.release_brakes,
    "local": lambda controller: setattr(controller, "remote", False),
    "close popup": lambda controller: setattr(controller, "popup", False),
    "remote": lambda controller: setattr(controller, "remote", True),
}


def _number(text: str, most: float) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if 0.0 <= value <= most else None


def obey(controller: Controller, line: str) -> str:
    """Do what a line orders; return what is wrong with it, empty where nothing is."""
    words = line.split()
    match words:
        case []:
            return ""
        case ["input", number, "on" | "off" as level] if number.isdigit() and int(number) < 18:
            bit = 1 << int(number)
            controller.digital_inputs = controller.digital_inputs & ~bit | (bit if level == "on" else 0)
            return ""
        case ["analog", "0" | "1" as number, voltage]:
            if (value := _number(voltage, 10.0)) is None:
                return f"an analog input is from 0 to 10 V, not {voltage}"
            controller.analog_inputs[int(number)] = value
            return ""
        case ["speed", share]:
            if (value := _number(share, 1.0)) is None:
                return f"speed is a share from 0 to 1, not {share}"
            controller.slider = value
            return ""
    order = ORDERS.get(" ".join(words))
    if order is None:
        return f"{line.strip()!r} is none of {', '.join(ORDERS)}, input 0..17 on|off, analog 0..1 0..10, speed 0..1"
    order(controller)
    return ""
