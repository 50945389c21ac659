"""The dashboard: a line asks, a line answers (Universal Robots, "Dashboard Server e-Series")."""

from __future__ import annotations

from virtualrobot_apps.emulators.ur.controller import Controller, RobotMode, SafetyMode

BANNER = "Connected: Universal Robots Dashboard Server"


def answer(controller: Controller, line: str) -> str:
    """Return what the dashboard answers to a line, having done what it asks for."""
    words = line.strip()
    asked = words.lower()
    runs, paused = controller.program, controller.paused
    if asked == "power on":
        controller.power_on()
        return "Powering on"
    if asked == "power off":
        controller.power_off()
        return "Powering off"
    if asked == "brake release":
        controller.release_brakes()
        return "Brake releasing"
    if asked == "unlock protective stop":
        if controller.safety is SafetyMode.PROTECTIVE_STOP:
            controller.release()
        return "Protective stop releasing"
    if asked == "stop":
        controller.end_program()  # where none runs, that is so already: ur-rtde stops what has just ended
        return "Stopped"
    if asked == "pause":
        return "Pausing program" if controller.pause() else "Failed to execute: pause"
    if asked == "play":  # no program is loaded: it goes on with one that was paused
        return "Starting program" if controller.go_on() else "Failed to execute: play"
    if asked == "close popup":
        controller.popup = False
        return "closing popup"
    if asked == "shutdown":
        controller.shut_down()
        return "Shutting down"
    order, _, rest = words.partition(" ")
    match order.lower():
        case "load":
            return f"File not found: {rest}"
        case "popup":
            controller.log(f"popup: {rest}")
            return "showing popup"
        case "addtolog":
            controller.log(rest)
            return "Added log message"
    major, minor, patch, build = controller.version
    plain = {
        "quit": "Disconnected",
        "close safety popup": "closing safety popup",
        "restart safety": "Restarting safety",
        "running": f"Program running: {'true' if controller.playing else 'false'}",
        "programstate": f"{'PAUSED' if paused else 'PLAYING'} {runs.name}" if runs else "STOPPED <unnamed>",
        "get loaded program": "No program loaded",
        "robotmode": f"Robotmode: {controller.mode.name}",
        "safetymode": f"Safetymode: {controller.safety.name}",
        "safetystatus": f"Safetystatus: {controller.safety.name}",
        "is in remote control": "true" if controller.remote else "false",
        "polyscopeversion": f"URSoftware {major}.{minor}.{patch}.{build} (emulated)",
        "get serial number": controller.serial,
        "get robot model": controller.model.type,
        "getuserrole": "PROGRAMMER",
        "get operational mode": "NONE",
        "isprogramsaved": "true <unnamed>",
    }
    if asked == "restart safety" and controller.stopped:
        controller.release()
        controller.mode = RobotMode.POWER_OFF
    return plain.get(asked, f'could not understand: "{words}"')
