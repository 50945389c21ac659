"""The plugin `drivers`: the words of real robots' controllers."""

from virtualrobot_sdk.hookspecs import Register, hookimpl

from virtualrobot_plugins.drivers.abb_egm import AbbEgm, AbbEgmSettings

api_version = "1.0"


@hookimpl
def virtualrobot_register_robot_drivers(register: Register) -> None:
    """Offer the drivers; each runs in a process of its own."""
    register("abb_egm", AbbEgm, AbbEgmSettings)
