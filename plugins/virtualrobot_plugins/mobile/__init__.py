"""The plugin `mobile`: the bundled kinematics of crafts on wheels."""

from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.registration import Isolation

from virtualrobot_plugins.mobile.ackermann import Ackermann, AckermannSettings
from virtualrobot_plugins.mobile.bicycle import Bicycle, BicycleSettings
from virtualrobot_plugins.mobile.differential import Differential, DifferentialSettings
from virtualrobot_plugins.mobile.mecanum import Mecanum, MecanumSettings
from virtualrobot_plugins.mobile.omnidirectional import Omnidirectional, OmnidirectionalSettings
from virtualrobot_plugins.mobile.skid_steer import SkidSteer, SkidSteerSettings
from virtualrobot_plugins.mobile.swerve import Swerve, SwerveSettings
from virtualrobot_plugins.mobile.tricycle import Tricycle, TricycleSettings

api_version = "1.0"


@hookimpl
def virtualrobot_register_mobile_kinematics(register: Register) -> None:
    """Offer the crafts; a step takes some microseconds, so they may run in the kernel's process."""
    register("ackermann", Ackermann, AckermannSettings, isolation=Isolation.IN_PROCESS)
    register("bicycle", Bicycle, BicycleSettings, isolation=Isolation.IN_PROCESS)
    register("differential", Differential, DifferentialSettings, isolation=Isolation.IN_PROCESS)
    register("mecanum", Mecanum, MecanumSettings, isolation=Isolation.IN_PROCESS)
    register("omnidirectional", Omnidirectional, OmnidirectionalSettings, isolation=Isolation.IN_PROCESS)
    register("skid_steer", SkidSteer, SkidSteerSettings, isolation=Isolation.IN_PROCESS)
    register("swerve", Swerve, SwerveSettings, isolation=Isolation.IN_PROCESS)
    register("tricycle", Tricycle, TricycleSettings, isolation=Isolation.IN_PROCESS)
