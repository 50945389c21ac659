"""Room with a shelf and a table, and a Husky with a lidar, on whose deck an arm with two fingers and a laser stands."""

from __future__ import annotations

import numpy as np
import virtualrobot
from virtualrobot import Client

from virtualrobot_apps.demos.carry import cell as arm_cell
from virtualrobot_apps.demos.carry.cell import ARM, HOME, JAW, LASER, SIZE
from virtualrobot_apps.demos.patrol.room import pose_of, walls
from virtualrobot_apps.seeing.navigation import floors
from virtualrobot_apps.seeing.navigation.floors import Box
from virtualrobot_apps.seeing.navigation.poses import Floats
from virtualrobot_apps.seeing.tabletop import Setup

VEHICLE, THING = "husky", "prism"
ROOM = (7.0, 5.0)
"""Size of the room, inside (m)."""
HIGH = 0.64
"""Height of shelf and table (m)."""
START = (1.2, 1.0, 0.0)
"""Pose of the vehicle at the start: x, y (m) and heading (rad)."""
SHELF, TABLE = (6.75, 3.4), (0.25, 3.4)
"""Middles of shelf and table: x, y (m)."""
PLAN = [
    *walls(*ROOM),
    Box(*SHELF, 0.5, 1.2, HIGH, "#8d99a6"),
    Box(*TABLE, 0.5, 1.2, HIGH, "#a9784a"),
    Box(3.4, 2.5, 0.8, 1.0, 0.9, "#6c7f94"),
    Box(5.6, 0.4, 1.2, 0.7, 1.1, "#8a6f9c"),
]
"""Walls and furniture, as the plan of the building has them."""
PLACES = {"shelf": (6.6, 3.4), "table": (0.4, 3.4)}
"""Places on shelf and table that the operator names: x, y (m). What is fetched stands about the first one."""
AHEAD = {"shelf": 0.0, "table": np.pi}
"""Headings (rad) with which the vehicle stands before them."""
AWAY, NEAR = 1.7, 0.8
"""Distances (m) of the base from a place: where it turns to it, and where it stands before it."""
MOUNT = virtualrobot.pose(0.2, 0.0, 0.391)
"""Pose (4, 4) of the arm's base in the frame of the vehicle's."""
DECK = (-0.7, 0.3, 0.35)
"""Reach of the deck behind and ahead of the arm, and to each side of it (m)."""
LIDAR = virtualrobot.pose(0.45, 0.0, 0.42)
"""Pose (4, 4) of the lidar in the frame of the vehicle's base: it looks about ahead of the arm."""
FIELD = np.radians(240.0)
DEVIATION = 0.01
"""Of a distance that the lidar tells (m, 1 sigma)."""
LOOKS = tuple((turn, *HOME[1:5], tilt, HOME[6]) for turn in (-0.4, 0.0, 0.4) for tilt in (0.9, 1.3))
SETUP = Setup(ARM, LASER, JAW, HOME, LOOKS, 0.14)


def build(client: Client, seed: int) -> None:
    """Replace the world by the room; where the prism stands, about its place on the shelf, is by seed."""
    floors.build(client, PLAN, ROOM)
    vehicle = client.load_robot(f"model://{VEHICLE}", name=VEHICLE, base="planar", pose=pose_of(np.array(START)))
    base = f"{VEHICLE}.base_footprint"
    arm_cell.load_arm(client, parent=base, pose=MOUNT)
    lidar = virtualrobot.range_sensor(
        pattern=virtualrobot.fan(481, -0.5 * FIELD, 0.5 * FIELD),
        rate=10.0,
        max_range=10.0,
        sensor_model="laser",
        sensor_model_settings={"deviation_meters": DEVIATION},
    )
    client.scene.add_range_sensor(f"{VEHICLE}.lidar", lidar, parent=base, pose=LIDAR)
    client.scene.add_motion_sensor(f"{VEHICLE}.encoders", virtualrobot.encoders(rate=50.0), parent=vehicle.name)
    rng = np.random.default_rng(seed)
    x, y = PLACES["shelf"] + rng.uniform(-0.03, 0.03, 2)
    prism = virtualrobot.box(*SIZE, color="#c0392b")
    pose = virtualrobot.pose(float(x), float(y), HIGH + 0.5 * SIZE[2], yaw=float(rng.uniform(-np.pi, np.pi)))
    client.scene.add_part(THING, prism, pose=pose)


def base_t_place(base: Floats, name: str) -> Floats:
    """Return a place (2,) in the frame of the arm with the vehicle's base at a pose (3,)."""
    world_t_arm = pose_of(base) @ MOUNT
    return (np.array([*PLACES[name], 0.0]) - world_t_arm[:3, 3]) @ world_t_arm[:3, :2]


def before(name: str, away: float) -> Floats:
    """Return the pose (3,) of the vehicle so far away from a place (m), headed for it."""
    heading = AHEAD[name]
    x, y = PLACES[name]
    return np.array([x - away * np.cos(heading), y - away * np.sin(heading), heading])
