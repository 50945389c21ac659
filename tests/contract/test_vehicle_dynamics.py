"""The suite for vehicle dynamics: three keep it, and each wrong one is found by the law that it breaks."""

from __future__ import annotations

import re
from typing import ClassVar

import pytest
from virtualrobot_sdk.testing.vehicle_dynamics import VehicleDynamicsContract, VehicleFacts

from tests.contract.breaking import broken

COMPONENTS = "tests.contract.components.vehicle_dynamics"
BUOY = VehicleFacts(half_steps=1e-6, settling=20.0)

WRONG = {
    "unlike_names": ("drives", r"drives are called thruster, thruster; each needs a name of its own"),
    "Overshoots": ("drives", r"each must be between state and command"),
    "Coarse": ("half_steps", r"two of half the time end \S+ m and \S+ rad from where it does"),
    "Idle": ("motion", r"none of 30 random commands changed the twist"),
    "NorthernDrag": ("anywhere", r"if it is shifted and turned afterwards, but at"),
    "StillWater": ("current", r"in a current of .* carried along it would be at"),
    "Restless": ("settling", r"told nothing for 20 s, it moves by"),
    "SmallAngles": ("long_way", r"a pose that is not rigid: R\^T R is off by"),
    "Inertia": ("determinism", r"the same step ends elsewhere"),
    "Unchecked": ("refusals", r"a command beyond its range was answered"),
}


@pytest.mark.long
class TestBuoy(VehicleDynamicsContract):
    component = f"{COMPONENTS}:Buoy"
    facts = BUOY


@pytest.mark.long
class TestBlueRov(VehicleDynamicsContract):
    """Where a propeller passes an entry of its table the thrust has a kink, which costs the integrator its order."""

    component = "fossen"
    facts = VehicleFacts(half_steps=1e-3)


@pytest.mark.long
class TestRemus(VehicleDynamicsContract):
    """It has no damping of surge but that of the square, which slows it as 1 / t."""

    component = "fossen"
    settings: ClassVar = {"vehicle": "remus100"}
    facts = VehicleFacts(density=1026.0, half_steps=1e-3, settled=0.3)


@pytest.mark.long
class TestHummingbird(VehicleDynamicsContract):
    """Told nothing it falls, at 33 m/s in the end, and nothing damps its turning."""

    component = "free_body"
    facts = VehicleFacts(density=1.225, half_steps=1e-3, greatest_speed=5.0, settled=40.0)


@pytest.mark.long
@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_one_is_found(name: str, seed: int) -> None:
    law, said = WRONG[name]
    found = broken(VehicleDynamicsContract, f"{COMPONENTS}:{name}", law, seed, BUOY)
    assert re.search(said, found), found
