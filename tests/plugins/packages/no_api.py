"""A plugin that does not say what it was written for."""

from arm_for_tests import Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("no_api", Arm, Settings)
