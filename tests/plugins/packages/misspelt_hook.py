"""A plugin whose hook is spelt wrongly."""

from arm_for_tests import Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl

api_version = "1.0"


@hookimpl
def virtualrobot_register_kinematic(register: Register) -> None:
    """Register nothing, since nobody calls this."""
    register("misspelt", Arm, Settings)
