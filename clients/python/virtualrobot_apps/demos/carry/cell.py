"""Cell of two tables, a pillar and pipes, an arm with two fingers and a laser scanner, and a red prism."""

from __future__ import annotations

import numpy as np
import virtualrobot
from virtualrobot import Client

from virtualrobot_apps.seeing.grasping.jaw import Jaw
from virtualrobot_apps.seeing.tabletop import Floats, Setup

ARM, HAND, LASER, OBSTACLES, PRISM = "arm", "hand", "laser", "platform", "prism"
FINGERS = ("left", "right")
"""Contact sensors, one on each finger."""
HOME = (0.0, -0.3, 0.0, -1.7, 0.0, 1.4, 0.0)
"""Posture (rad) that the task begins and ends at."""
TABLES = {"table_from": (0.55, 0.36), "table_to": (0.55, -0.36)}
"""Middles of the tables: x, y (m)."""
FROM, TO = TABLES.values()
HALF, TOP = 0.16, 0.25
"""Half the edge of a table and its height (m)."""
PILLARS = {"pillar": (0.62, 0.02, 0.05, 0.52), "pipe": (0.05, 0.5, 0.04, 1.1), "riser": (0.275, -0.39, 0.03, 1.0)}
"""Round things that stand about: x, y, radius and height (m)."""
SIZE = (0.04, 0.06, 0.12)
"""Of the prism (m)."""
PLACE = (0.53, 0.38, 2.0)
"""Of the prism: x, y (m) and turn (rad)."""
JAW = Jaw(0.056, wide=0.025, thick=0.01, long=0.06, tip=0.02)
OPEN = 0.056
"""Width (m) of the open fingers."""
LOOKS = tuple(
    (turn, *HOME[1:4], swing, tilt, HOME[6])
    for turn in (-0.7, 0.0, 0.7)
    for swing in (-1.2, 0.0, 1.2)
    for tilt in (0.9, 1.3)
)
"""Postures (rad) about home that the arm looks about with."""
SETUP = Setup(ARM, LASER, JAW, HOME, LOOKS, HALF)
DEVIATION = 0.001
"""Of a distance that the laser tells (m, 1 sigma)."""


def build(client: Client) -> None:
    """Replace the world by the cell."""
    scene = client.scene
    scene.clear()
    load_arm(client)
    scene.add_object(OBSTACLES, ())
    for name, (x, y) in TABLES.items():
        table = virtualrobot.box(2.0 * HALF, 2.0 * HALF, TOP, color="#8d99a6")
        scene.add_object(name, table, parent=OBSTACLES, pose=virtualrobot.pose(x, y, 0.5 * TOP))
    for name, (x, y, radius, high) in PILLARS.items():
        figure = virtualrobot.cylinder(radius, high, color="#d9b13b")
        scene.add_object(name, figure, parent=OBSTACLES, pose=virtualrobot.pose(x, y, 0.5 * high))
    x, y, turn = PLACE
    prism = virtualrobot.box(*SIZE, color="#c0392b")
    scene.add_part(PRISM, prism, pose=virtualrobot.pose(x, y, TOP + 0.5 * SIZE[2], yaw=turn))
    client.view.set_camera(position=(1.7, -1.2, 1.4), target=(0.35, 0.0, 0.35))


def load_arm(client: Client, parent: str = "world", pose: Floats | None = None) -> None:
    """Add the arm with its open hand, whose fingers feel, and its laser, at home, at a pose (4, 4) on a node."""
    arm = client.load_robot("model://iiwa", name=ARM, parent=parent, pose=virtualrobot.pose() if pose is None else pose)
    arm.set_positions(HOME)
    arm.mount("model://parallel_gripper", name=HAND)
    client.robot(HAND).set_positions([0.5 * OPEN])
    laser = virtualrobot.range_sensor(
        pattern=virtualrobot.raster(120, 100, 0.9, 0.75),
        sensor_model="laser",
        sensor_model_settings={"deviation_meters": DEVIATION},
        max_range=1.5,
    )
    mount = virtualrobot.pose(x=0.1, z=0.03, pitch=-np.pi / 2)
    client.scene.add_range_sensor(LASER, laser, parent=arm.flange, pose=mount)
    for finger in FINGERS:
        client.scene.add_contact_sensor(
            finger, virtualrobot.contact_sensor(max_range=0.002), parent=f"{HAND}.{finger}_finger"
        )
