"""Drivers of robots on serial ports keep the laws of drivers."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import pytest
from virtualrobot_sdk.testing.robot_drivers import DriverFacts, RobotDriverContract

from tests.drivers import robots_on_cables

HERE = robots_on_cables.__name__
FACTS = DriverFacts(
    joints=6,
    moves=True,
    settle_seconds=10.0,
    stands_at=(0.0,) * 6,
    breaks=f"{HERE}:breaks",
    silences=f"{HERE}:silences",
    mends=f"{HERE}:mends",
    nobody={"port": robots_on_cables.NOBODY},
)


@pytest.mark.long
class TestBoard(RobotDriverContract):
    component = f"{HERE}/board"
    settings: ClassVar = {"port": "cable"}
    facts = FACTS


@pytest.mark.long
class TestBoardOfJobs(RobotDriverContract):
    component = f"{HERE}/jobs"
    settings: ClassVar = {"port": "cable"}
    facts = FACTS


@pytest.mark.long
class TestServos(RobotDriverContract):
    component = f"{HERE}/servos"
    settings: ClassVar = {"port": "cable", "ids": [1, 2], "baud": 1_000_000, "rate": 50}
    # A pulse is 1.5 mrad.
    facts = dataclasses.replace(
        FACTS,
        joints=2,
        way=0.1,
        tolerance=2e-3,
        stands_at=(-48 / 2048 * 3.14159265, 52 / 2048 * 3.14159265),
        complains=f"{HERE}:overload",
        words="servo 2: overload",
        nobody={"port": robots_on_cables.NOBODY, "ids": [1, 2]},
    )


@pytest.mark.long
class TestArm(RobotDriverContract):
    component = f"{HERE}/arm"
    settings: ClassVar = {"port": "cable", "baud": 115200}
    facts = FACTS
