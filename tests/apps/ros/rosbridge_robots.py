"""The driver `ros_trajectory` for the contract suite, with its robot in the driver's own process."""

from __future__ import annotations

import dataclasses
import threading

from virtualrobot_apps.bridges.ros.driver import RosTrajectory, RosTrajectorySettings
from virtualrobot_sdk.drivers import Driver
from virtualrobot_sdk.hookspecs import Register, hookimpl
from websockets.sync.server import serve

from tests.apps.ros.sham_rosbridge import ShamRobot

api_version = "1.0"
JOINTS, STANDS_AT = ("shoulder", "elbow"), (-0.25, 0.5)
NOBODY = "ws://127.0.0.1:1"

ROBOT: list[tuple[ShamRobot, str]] = []
"""The robot of this process and its address, once there is one."""


def ros(settings: RosTrajectorySettings) -> Driver:
    """Return a driver of a robot that the test plays, slow enough to be stopped on its way."""
    if settings.url == NOBODY:
        return RosTrajectory(settings)
    if not ROBOT:
        robot = ShamRobot(at_once=False)
        server = serve(robot.handle, "127.0.0.1", 0)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        ROBOT.append((robot, f"ws://127.0.0.1:{server.socket.getsockname()[1]}"))
    return RosTrajectory(dataclasses.replace(settings, url=ROBOT[0][1], joints=JOINTS, speed=0.1))


@hookimpl
def virtualrobot_register_robot_drivers(register: Register) -> None:
    """Register it."""
    register("ros", ros, RosTrajectorySettings)


def breaks(driver: Driver) -> None:
    """Close the connection, and let nobody in."""
    robot, _ = ROBOT[0]
    robot.is_plugged = False
    robot.unplug()


def silences(driver: Driver) -> None:
    """Tell the joints no more."""
    ROBOT[0][0].talks = False


def mends(driver: Driver) -> None:
    """Make either good."""
    robot, _ = ROBOT[0]
    robot.is_plugged = robot.talks = True
