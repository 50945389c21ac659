"""Robot drivers: what an author of one writes, and the process that runs it."""

from virtualrobot_sdk.drivers.driver import About, Driver, DriverFault, Mode, Pace, Reading, Safety, Words

__all__ = [
    "About",
    "Driver",
    "DriverFault",
    "Mode",
    "Pace",
    "Reading",
    "Safety",
    "Words",
]
