"""The driver `ur_rtde` keeps the laws of drivers against an emulated controller in a process of its own."""

from __future__ import annotations

from typing import ClassVar

import pytest
from virtualrobot_apps.emulators.ur.command import HOME
from virtualrobot_sdk.testing.robot_drivers import DriverFacts, RobotDriverContract

from tests.drivers import ur_controllers

HERE = ur_controllers.__name__


@pytest.mark.long
class TestUr(RobotDriverContract):
    component = f"{HERE}/ur_rtde"
    settings: ClassVar = {"host": "beside"}
    facts = DriverFacts(
        joints=6,
        moves=True,
        settle_seconds=10.0,
        stands_at=HOME,
        breaks=f"{HERE}:breaks",
        silences=f"{HERE}:silences",
        mends=f"{HERE}:mends",
        complains=f"{HERE}:meets",
        words="C153A0: Position deviates from path",
        nobody={"host": ur_controllers.NOBODY},
    )
