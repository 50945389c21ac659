"""The driver keeps the laws of all robot drivers, at the board that is computed."""

import pytest
from board import Board
from virtualrobot_sdk.testing import RobotDriverContract
from virtualrobot_sdk.testing.robot_drivers import DriverFacts


class TestMyRobot(RobotDriverContract):
    component = "my_robot/my_robot"
    settings = {"port": Board().port, "silence_seconds": 1.0}
    # Of a real robot say moves=False first, and name its port: then it is read and never moved.
    facts = DriverFacts(
        joints=3,
        moves=True,
        way=0.1,
        settle_seconds=5.0,
        breaks="board:break_cable",
        silences="board:freeze",
        mends="board:mend",
        complains="board:heat",
        words="motor 2 is hot",
        nobody={"port": "/dev/no_such_port"},
    )


if __name__ == "__main__":
    raise SystemExit(pytest.main([__file__]))
