"""The driver `ros_trajectory` keeps the laws of drivers."""

from __future__ import annotations

import pytest
from virtualrobot_sdk.testing.robot_drivers import DriverFacts, RobotDriverContract

from tests.apps.ros import rosbridge_robots

HERE = rosbridge_robots.__name__


@pytest.mark.long
class TestRos(RobotDriverContract):
    component = f"{HERE}/ros"
    facts = DriverFacts(
        joints=2,
        moves=True,
        settle_seconds=10.0,
        stands_at=rosbridge_robots.STANDS_AT,
        breaks=f"{HERE}:breaks",
        silences=f"{HERE}:silences",
        mends=f"{HERE}:mends",
        nobody={"url": rosbridge_robots.NOBODY},
    )
