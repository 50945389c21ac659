"""The plugin `drivers`: the bundled drivers of real robots."""

from virtualrobot_sdk.hookspecs import Register, hookimpl

from virtualrobot_plugins.drivers.serial_line import SerialLine, SerialLineSettings

api_version = "1.0"


@hookimpl
def virtualrobot_register_robot_drivers(register: Register) -> None:
    """Offer the drivers, each in a process of its own; the libraries that they need are loaded as they connect."""
    register("serial_line", SerialLine, SerialLineSettings)
