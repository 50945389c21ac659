"""A plugin that calls its component as the bundled one is called."""

from arm_for_tests import Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl

api_version = "1.0"


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it under a name that is taken."""
    register("chain", Arm, Settings)
