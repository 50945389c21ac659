"""The suite for mobile kinematics: two and the bundled crafts keep it, and each wrong one is found by its law."""

from __future__ import annotations

import re
from typing import Any, ClassVar

import pytest
from virtualrobot_sdk.testing.mobile_kinematics import CraftFacts, MobileKinematicsContract

from tests.contract.breaking import broken
from tests.contract.components.mobile_kinematics import TRACK, WHEEL_RADIUS
from tests.tiers import every_fifth

COMPONENTS = "tests.contract.components.mobile_kinematics"

WRONG = {
    "Euler": ("half_steps", r"two steps of \S+ s end \S+ m and \S+ rad from where one of \S+ s does"),
    "WorldFrame": ("anywhere", r"it should be \["),
    "Drifts": ("rest", r"told 0 for \S+ s .* it moved by \S+ m and 0\.0001 rad"),
    "SmallAngles": ("motion", r"a pose that is not rigid: R\^T R is off by"),
    "Backwards": ("drives", r"each must go the same way"),
    "Inertia": ("determinism", r"the same step ends elsewhere"),
    "Skates": ("commands", r"what it cannot do it must refuse by ArgumentError"),
    "Degrees": ("twists", r"base_twist is \S+ \S+ \S+, and in 1e-05 s it moves at"),
    "Flutters": ("passives", r"and at rest then to"),
    "Unchecked": ("refusals", r"a time of 0 s was answered"),
}


class TestDifferentialDrive(MobileKinematicsContract):
    component = f"{COMPONENTS}:DifferentialDrive"


@pytest.mark.long
class TestEuler(MobileKinematicsContract):
    """What is only near keeps the laws when its author says how near."""

    component = f"{COMPONENTS}:Euler"
    # The step is too long by the way times half of the turn at most: each from drives told as much as may be.
    facts = CraftFacts(half_steps=(5.0 * WHEEL_RADIUS * 0.1) * (2.0 * 5.0 * WHEEL_RADIUS / TRACK * 0.1) / 2.0)


BUNDLED = "virtualrobot_plugins.mobile"
STEERED = CraftFacts(greatest_state=0.55, seconds=0.05)


@pytest.mark.long
class TestBundledDifferential(MobileKinematicsContract):
    component = f"{BUNDLED}/differential"
    settings: ClassVar[dict[str, Any]] = {"track_meters": 0.4, "wheel_radius_meters": 0.08}


@pytest.mark.long
class TestBundledSkidSteer(MobileKinematicsContract):
    component = f"{BUNDLED}/skid_steer"
    settings: ClassVar[dict[str, Any]] = {"track_meters": 0.57, "wheel_radius_meters": 0.165, "slip": 1.8}


@pytest.mark.long
class TestBundledMecanum(MobileKinematicsContract):
    component = f"{BUNDLED}/mecanum"
    settings: ClassVar[dict[str, Any]] = {"wheelbase_meters": 0.6, "track_meters": 0.5, "wheel_radius_meters": 0.1}


@pytest.mark.long
class TestBundledSwerve(MobileKinematicsContract):
    component = f"{BUNDLED}/swerve"
    settings: ClassVar[dict[str, Any]] = {"wheelbase_meters": 0.6, "track_meters": 0.5, "wheel_radius_meters": 0.1}


@pytest.mark.long
class TestBundledThreeWheels(MobileKinematicsContract):
    component = f"{BUNDLED}/omnidirectional"
    settings: ClassVar[dict[str, Any]] = {"radius_meters": 0.2, "wheel_radius_meters": 0.05}


@pytest.mark.long
class TestBundledFourWheels(MobileKinematicsContract):
    component = f"{BUNDLED}/omnidirectional"
    settings: ClassVar[dict[str, Any]] = {
        "radius_meters": 0.2,
        "wheel_radius_meters": 0.05,
        "wheels": 4,
        "first_angle_radians": 0.785,
    }


@pytest.mark.long
class TestBundledBicycle(MobileKinematicsContract):
    component = f"{BUNDLED}/bicycle"
    settings: ClassVar[dict[str, Any]] = {"wheelbase_meters": 1.0, "wheel_radius_meters": 0.3}
    facts = STEERED


@pytest.mark.long
class TestBundledBicycleDrivenInFront(MobileKinematicsContract):
    component = f"{BUNDLED}/bicycle"
    settings: ClassVar[dict[str, Any]] = {"wheelbase_meters": 1.0, "wheel_radius_meters": 0.3, "driven": "front"}
    facts = STEERED


@pytest.mark.long
class TestBundledTricycle(MobileKinematicsContract):
    component = f"{BUNDLED}/tricycle"
    settings: ClassVar[dict[str, Any]] = {"wheelbase_meters": 1.2, "track_meters": 0.8, "wheel_radius_meters": 0.15}
    facts = STEERED


@pytest.mark.long
class TestBundledAckermann(MobileKinematicsContract):
    component = f"{BUNDLED}/ackermann"
    settings: ClassVar[dict[str, Any]] = {"wheelbase_meters": 0.33, "track_meters": 0.2, "wheel_radius_meters": 0.05}
    facts = STEERED


@pytest.mark.parametrize("name", every_fifth(WRONG))
def test_a_wrong_one_is_found(name: str, seed: int) -> None:
    law, said = WRONG[name]
    found = broken(MobileKinematicsContract, f"{COMPONENTS}:{name}", law, seed)
    assert re.search(said, found), found
