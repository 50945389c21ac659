"""Drivers whose controllers speak first keep the laws of drivers, against emulated ones at their own rate."""

from __future__ import annotations

import dataclasses

import pytest
from virtualrobot_sdk.testing.robot_drivers import DriverFacts, RobotDriverContract

from tests.drivers import guided_robots

HERE = guided_robots.__name__
FACTS = DriverFacts(
    joints=6,
    moves=True,
    settle_seconds=10.0,
    stands_at=guided_robots.START,
    breaks=f"{HERE}:falls_silent",
    silences=f"{HERE}:falls_silent",
    mends=f"{HERE}:speaks_again",
    nobody={"port": guided_robots.NOBODY},
)


@pytest.mark.long
class TestAbb(RobotDriverContract):
    component = f"{HERE}/abb"
    facts = dataclasses.replace(FACTS, complains=f"{HERE}:meets", words="has seen a collision", heals=f"{HERE}:is_free")


@pytest.mark.long
class TestKuka(RobotDriverContract):
    component = f"{HERE}/kuka"
    facts = FACTS
