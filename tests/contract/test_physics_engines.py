"""The suite for physics engines: two keep it, and each wrong one is found by the law that it breaks."""

from __future__ import annotations

import re

import pytest
from virtualrobot_sdk.testing.physics_engines import EngineFacts, PhysicsEngineContract

from tests.contract.breaking import broken

COMPONENTS = "tests.contract.components.physics_engines"

WRONG = {
    "Light": ("free_fall", r"its center is at .*; it must be at"),
    "Rough": ("sliding", r"a box on a slope of 30 degrees changes its speed by \S+ m/s\^2; it must be 0\.65715"),
    "Turned": ("heights", r"a box rests at \S+ m; heights say 0\.328675 m"),
    "Dead": ("restitution", r"0\.\d+ of its speed; its restitution is 0\.3"),
    "Slow": ("pendulum", r"has a period of \S+ s, not|still swings to \S+ rad, not as far"),
    "Remembers": ("forgetting", r"set_state must forget"),
    "Still": ("carrying", r"has carried a box by \S+ m in 1\.0 s, not 0\.197"),
    "Halves": ("stack", r"'floor' carries .* what is above it weighs 98\.1 N"),
    "Strong": ("motors", r"a motor told a limited effort turns its joint by"),
    "Loose": ("couplings", r"a joint that leads another one by \S+, pushed by \S+ N at the leader"),
    "Trusting": ("refusals", r"step of no substeps was answered"),
    "Pulls": ("wrenches", r"pushed by \S+ N for 0\.1 s, it has the velocities"),
}


class TestMujoco(PhysicsEngineContract):
    component = "virtualrobot_plugins.physics/mujoco"
    # What slides hops by tenths of a millimeter.
    facts = EngineFacts(sliding=0.05)


@pytest.mark.long
class TestBullet(PhysicsEngineContract):
    component = "virtualrobot_plugins.physics/bullet"
    facts = EngineFacts(mixing="geometric mean")


@pytest.mark.long
@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_one_is_found(name: str, seed: int) -> None:
    law, said = WRONG[name]
    found = broken(PhysicsEngineContract, f"{COMPONENTS}:{name}", law, seed)
    assert re.search(said, found), found
