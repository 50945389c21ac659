"""The test kit for authors: laws that components must keep, as pytest classes and, for kinematics, as a grade.

The classes need pytest; `virtualrobot grade` (`virtualrobot_sdk.testing.grade`) does not.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from virtualrobot_sdk.testing.chains import chain_of, kit_chains

if TYPE_CHECKING:
    from virtualrobot_sdk.testing.contract import KinematicsContract
    from virtualrobot_sdk.testing.importers import ImporterContract
    from virtualrobot_sdk.testing.mobile_kinematics import MobileKinematicsContract
    from virtualrobot_sdk.testing.physics_engines import PhysicsEngineContract
    from virtualrobot_sdk.testing.ray_casters import RayCasterContract
    from virtualrobot_sdk.testing.robot_drivers import RobotDriverContract
    from virtualrobot_sdk.testing.sensor_models import SensorModelContract
    from virtualrobot_sdk.testing.vehicle_dynamics import VehicleDynamicsContract

__all__ = [
    "ImporterContract",
    "KinematicsContract",
    "MobileKinematicsContract",
    "PhysicsEngineContract",
    "RayCasterContract",
    "RobotDriverContract",
    "SensorModelContract",
    "VehicleDynamicsContract",
    "chain_of",
    "kit_chains",
]

_MODULES = {
    "ImporterContract": "importers",
    "KinematicsContract": "contract",
    "MobileKinematicsContract": "mobile_kinematics",
    "PhysicsEngineContract": "physics_engines",
    "RayCasterContract": "ray_casters",
    "RobotDriverContract": "robot_drivers",
    "SensorModelContract": "sensor_models",
    "VehicleDynamicsContract": "vehicle_dynamics",
}


def __getattr__(name: str) -> object:
    """Import what needs pytest only when it is asked for: who runs a grade may not have it."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
