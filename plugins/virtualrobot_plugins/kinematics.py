"""The plugin `kinematics`: the bundled solvers of robots."""

from virtualrobot_sdk.denavit_hartenberg import Table
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.registration import Isolation

from virtualrobot_plugins.arm_angle.component import ArmAngleKinematics
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_plugins.closed_form.component import ClosedFormKinematics
from virtualrobot_plugins.dh import DhKinematics

api_version = "1.0"


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Offer the solvers; they are compiled and free of the GIL, so they may run in the kernel's process."""
    register("arm_angle", ArmAngleKinematics, isolation=Isolation.IN_PROCESS)
    register("chain", ChainKinematics, isolation=Isolation.IN_PROCESS)
    register("closed_form", ClosedFormKinematics, isolation=Isolation.IN_PROCESS)
    register("dh", DhKinematics, Table, isolation=Isolation.IN_PROCESS)
