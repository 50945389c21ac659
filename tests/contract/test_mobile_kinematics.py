"""The suite for mobile kinematics: two keep it, and each wrong one is found by the law that it breaks."""

from __future__ import annotations

import re

import pytest
from virtualrobot_sdk.testing.mobile_kinematics import CraftFacts, MobileKinematicsContract

from tests.contract.breaking import broken
from tests.contract.components.mobile_kinematics import TRACK, WHEEL_RADIUS

COMPONENTS = "tests.contract.components.mobile_kinematics"

WRONG = {
    "Euler": ("half_steps", r"two steps of \S+ s end \S+ m and \S+ rad from where one of \S+ s does"),
    "WorldFrame": ("anywhere", r"it should be \["),
    "Drifts": ("rest", r"told 0 for \S+ s .* it moved by \S+ m and 0\.0001 rad"),
    "SmallAngles": ("motion", r"a pose that is not rigid: R\^T R is off by"),
    "Backwards": ("drives", r"each must go the same way"),
    "Inertia": ("determinism", r"the same step ends elsewhere"),
    "Unchecked": ("refusals", r"a time of 0 s was answered"),
}


class TestDifferentialDrive(MobileKinematicsContract):
    component = f"{COMPONENTS}:DifferentialDrive"


class TestEuler(MobileKinematicsContract):
    """What is only near keeps the laws when its author says how near."""

    component = f"{COMPONENTS}:Euler"
    # The step is too long by the way times half of the turn at most: each from drives told as much as may be.
    facts = CraftFacts(half_steps=(5.0 * WHEEL_RADIUS * 0.1) * (2.0 * 5.0 * WHEEL_RADIUS / TRACK * 0.1) / 2.0)


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_one_is_found(name: str, seed: int) -> None:
    law, said = WRONG[name]
    found = broken(MobileKinematicsContract, f"{COMPONENTS}:{name}", law, seed)
    assert re.search(said, found), found
