"""The reference of plugins tells each law of each suite, in order."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.importers import ImporterContract
from virtualrobot_sdk.testing.mobile_kinematics import MobileKinematicsContract
from virtualrobot_sdk.testing.physics_engines import PhysicsEngineContract
from virtualrobot_sdk.testing.ray_casters import RayCasterContract
from virtualrobot_sdk.testing.robot_drivers import RobotDriverContract
from virtualrobot_sdk.testing.sensor_models import SensorModelContract
from virtualrobot_sdk.testing.vehicle_dynamics import VehicleDynamicsContract

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "plugins.md").read_text("utf-8")


@pytest.mark.parametrize(
    ("title", "contract"),
    [
        ("ray casters", RayCasterContract),
        ("sensor models", SensorModelContract),
        ("robot drivers", RobotDriverContract),
        ("mobile kinematics", MobileKinematicsContract),
        ("physics engines", PhysicsEngineContract),
        ("vehicle dynamics", VehicleDynamicsContract),
        ("importers", ImporterContract),
    ],
)
def test_each_law_is_told(title: str, contract: type[ComponentContract]) -> None:
    told = TEXT.partition(f"\n### Suite for {title}\n")[2].partition("\n### ")[0]
    assert re.findall(r"^\| `(\w+)` \|", told, re.MULTILINE) == list(contract.laws)
    assert all(law.__doc__ for law in contract.laws.values())
