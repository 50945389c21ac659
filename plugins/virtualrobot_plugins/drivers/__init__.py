"""The plugin `drivers`: connections to real robots, and to one that is computed."""

from virtualrobot_sdk.hookspecs import Register, hookimpl

from virtualrobot_plugins.drivers.abb_egm.driver import AbbEgm, AbbEgmSettings
from virtualrobot_plugins.drivers.crs import Crs, CrsSettings
from virtualrobot_plugins.drivers.dynamixel.driver import Dynamixel, DynamixelSettings
from virtualrobot_plugins.drivers.kuka_rsi.driver import KukaRsi, KukaRsiSettings
from virtualrobot_plugins.drivers.loopback.driver import Loopback
from virtualrobot_plugins.drivers.loopback.settings import LoopbackSettings
from virtualrobot_plugins.drivers.serial_line import SerialLine, SerialLineSettings
from virtualrobot_plugins.drivers.ur_rtde.driver import UrRtde, UrRtdeSettings

api_version = "1.0"


@hookimpl
def virtualrobot_register_robot_drivers(register: Register) -> None:
    """Offer the drivers; each runs in a process of its own, and loads the library that it needs as it connects."""
    register("abb_egm", AbbEgm, AbbEgmSettings)
    register("crs", Crs, CrsSettings)
    register("dynamixel", Dynamixel, DynamixelSettings)
    register("kuka_rsi", KukaRsi, KukaRsiSettings)
    register("loopback", Loopback, LoopbackSettings)
    register("serial_line", SerialLine, SerialLineSettings)
    register("ur_rtde", UrRtde, UrRtdeSettings)
