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
    "remote": lambda controller: setattr(controller, "remote", True),
}


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
        case ["speed", share]:
            try:
                value = float(share)
            except ValueError:
                value = -1.0
            if 0.0 <= value <= 1.0:
                controller.slider = value
                return ""
            return f"speed is a share from 0 to 1, not {share}"
    order = ORDERS.get(" ".join(words))
    if order is None:
        return f"{line.strip()!r} is none of {', '.join(ORDERS)}, input 0..17 on|off, speed 0..1"
    order(controller)
    return ""
