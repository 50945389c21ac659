"""The plugin `marine`: dynamics of vehicles under water."""

from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.registration import Isolation

from virtualrobot_plugins.marine.component import FossenDynamics, FossenSettings

api_version = "1.0"


@hookimpl
def virtualrobot_register_vehicle_dynamics(register: Register) -> None:
    """Offer the model; it is compiled and free of the GIL, so it may run in the kernel's process."""
    register("fossen", FossenDynamics, FossenSettings, isolation=Isolation.IN_PROCESS)
