"""A plugin that was written for another kernel."""

from arm_for_tests import Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl

api_version = "2.0"


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("other_api", Arm, Settings)
