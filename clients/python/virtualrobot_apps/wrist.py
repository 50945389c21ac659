"""Force and torque sensor of an arm: the one on its flange, or on a tool there."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client, UnknownNameError, WrongStateError
from virtualrobot.robots.robot import Robot
from virtualrobot.sensors.motion_sensors import WrenchReading
from virtualrobot.sensors.readings import Reading


def wrist_of(client: Client, robot: Robot) -> tuple[Reading, NDArray[np.float64]]:
    """Return a reading of the sensor on the flange, or on a tool there, and its pose (4, 4) in its frame.

    Raises WrongStateError where there is none.
    """
    nodes = {node.name: node for node in client.scene.nodes()}
    for name in client.sensors:
        node, pose = nodes[name], np.eye(4)
        while node.name != robot.flange and node.parent in nodes:
            node, pose = nodes[node.parent], node.parent_t_node @ pose
        if node.name == robot.flange:
            with suppress(UnknownNameError):
                reading = client.sensors[name].read()
                if isinstance(reading.value, WrenchReading):
                    return reading, pose
    added = "scene.add_motion_sensor('wrist', virtualrobot.force_torque_sensor(rate=250), parent=robot.flange)"
    raise WrongStateError(f"{robot.name!r} has no force and torque sensor on its flange; {added} adds one")
