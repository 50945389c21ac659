"""Robot drivers: what an author of one writes, and the process that runs it."""

from virtualrobot_sdk.drivers.driver import About, Driver, DriverFault, Mode, Pace, Reading, Safety
from virtualrobot_sdk.drivers.life_cycle import TRANSITIONS, DriverState, Measured, RobotDriver

__all__ = [
    "TRANSITIONS",
    "About",
    "Driver",
    "DriverFault",
    "DriverState",
    "Measured",
    "Mode",
    "Pace",
    "Reading",
    "RobotDriver",
    "Safety",
]
