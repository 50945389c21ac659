"""The plugin `marine`: dynamics of vehicles under water, and of crafts in air and space."""

from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.registration import Isolation

from virtualrobot_plugins.marine.component import (
    FossenDynamics,
    FossenSettings,
    FreeBodyDynamics,
    FreeBodySettings,
)

api_version = "1.0"


@hookimpl
def virtualrobot_register_vehicle_dynamics(register: Register) -> None:
    """Offer both models; they are compiled and free of the GIL, so they may run in the kernel's process."""
    register("fossen", FossenDynamics, FossenSettings, isolation=Isolation.IN_PROCESS)
    register("free_body", FreeBodyDynamics, FreeBodySettings, isolation=Isolation.IN_PROCESS)
