"""The suite for sensor models: three keep it, and each wrong one is found by the law that it breaks."""

from __future__ import annotations

import re

import pytest
from virtualrobot_sdk.testing.sensor_models import SensorFacts, SensorModelContract

from tests.contract.breaking import broken
from tests.tiers import every_fifth

COMPONENTS = "tests.contract.components.sensor_models"

WRONG = {
    "HalfBeam": ("beam", r"beam returned ray 1 as \[0\.5, 0\.0, 0\.0\]; it must have unit length"),
    "Backwards": ("beam", r"beam returned ray 0 as \[-1\.0, 0\.0, 0\.0\]; it must have x above 0"),
    "NoBeam": ("beam", r"beam returned shape \(0, 3\); it must be \(k, 3\) with k from 1 to 4096"),
    "Wanders": ("beam", r"beam returns other rays"),
    "OneEach": ("readings", r"apply returned distance of shape \(\d+, 1\); it must be \(\d+,\), one for each beam"),
    "OwnChance": ("purity", r"the same hits and draws give another distance"),
    "Remembers": ("purity", r"the same hits and draws give another distance"),
    "NoisyMisses": ("readings", r"a distance that is NaN or negative: beam \d+ reads nan m"),
    "AlwaysValid": ("misses", r"100\.0% of the beams that hit nothing are valid; it may be 0\.0%"),
    "Folds": ("growth", r"the mean reading is \S+ m, less than \S+ m at"),
    "ChangesHits": ("readings", r"read-only \(sensor_models\.py:\d+ in apply\)"),
    "NeedsRays": ("none", r"ValueError: zero-size array"),
}


class TestIdeal(SensorModelContract):
    component = f"{COMPONENTS}:Ideal"


class TestCone(SensorModelContract):
    component = f"{COMPONENTS}:Cone"


class TestNoisy(SensorModelContract):
    component = f"{COMPONENTS}:Noisy"
    facts = SensorFacts(valid_misses=0.01)


@pytest.mark.parametrize("name", every_fifth(WRONG))
def test_a_wrong_one_is_found(name: str, seed: int) -> None:
    law, said = WRONG[name]
    found = broken(SensorModelContract, f"{COMPONENTS}:{name}", law, seed)
    assert re.search(said, found), found
