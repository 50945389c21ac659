"""The palletizing cell of the demo: its scene file, its boxes and stations, and where people look from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import virtualrobot
from numpy.typing import ArrayLike
from virtualrobot import Client
from virtualrobot.scene.figures import Figure
from virtualrobot.v1 import scene_pb2

SCENE = Path(__file__).parent / "cell.yaml"

RTB = "package://rtbdata/xacro"
FRANKIE = f"{RTB}/qut_frankie_description/robots"
WITHOUT_PYBULLET = {
    "package://pybullet_data/kuka_iiwa/model.urdf": f"{RTB}/kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.xacro",
    "package://pybullet_data/franka_panda/panda.urdf": f"{FRANKIE}/panda_arm_hand.urdf.xacro",
    "iiwa.lbr_iiwa_link_7\n    adapter: {}\n    parent_t_node: {position: {z: 0.045}}": "iiwa.tool0\n    adapter: {}",
    "{robot: conveyor, mode: COLLISION_MODE_OFF}": "{robot: conveyor, mode: COLLISION_MODE_OFF}\n"
    "    - {robot: panda, mode: COLLISION_MODE_OFF}",
}
"""Words of the scene file about the arms, and those for the same arms of rtb-data.

Its Panda collides as cylinders and spheres that are larger than its hand, so that it could hold nothing.
"""

IIWA_SPEEDS = np.radians([98, 98, 100, 130, 140, 180, 180])
"""Speeds of joints A1 to A7 (rad/s). Source: KUKA, LBR iiwa 7 R800, data sheet; the model file says 10 for all."""


@dataclass(frozen=True)
class Station:
    """An arm, the boxes that it stacks, and where it takes them; meters and radians."""

    robot: str
    box: tuple[float, float, float]
    gap: float  # between boxes on the pallet
    color: str
    tape: str
    pick_x: float  # in the world: where a box waits for the arm,
    moves: int  # after so many moves of the belt,
    belt_yaw: float  # turned so
    grip_depth: float  # of the tool centre point below the top of a box
    travel_height: float  # of the tool centre point in the world
    tool_states: tuple[str, str]  # to hold and to let go
    fingers: tuple[str, ...]  # what touches a box to hold it

    def figures(self) -> list[Figure]:
        """Return the shapes of a box: itself, and a band of tape around it that only the eye sees."""
        length, _, height = self.box
        tape = virtualrobot.box(1.002 * length, 0.02, 1.002 * height, color=self.tape, roles=["visual"])
        return [virtualrobot.box(*self.box, color=self.color), tape]

    def touches(self, number: int) -> Iterator[tuple[str, str, str]]:
        """Yield what a box may touch on its way, and why; an arm that touches anything else, or with it, stops."""
        box = f"{self.robot}-box-{number}"
        yield box, "conveyor-frame", "it is taken from the belt"
        yield box, f"pallet-{self.robot}", "it is put onto the pallet"
        yield from ((box, finger, "it is held") for finger in self.fingers)
        # Those beside it and below it: two layers of six have no more.
        yield from ((box, f"{self.robot}-box-{other}", "it is stacked") for other in range(max(1, number - 11), number))


# Twice the length is three times the width and a gap: a layer and the turned one above it are flush.
LARGE = ((0.155, 0.10, 0.11), 0.01, "#c99a62", "#e6d3b3")
SMALL = ((0.105, 0.06, 0.07), 0.03, "#2f7fb8", "#dfe9f2")  # the gap leaves room for fingers
FINGERS = ("panda.panda_leftfinger", "panda.panda_rightfinger")
STATIONS = (
    Station("iiwa", *LARGE, 0.625, 4, np.pi / 2, 0.0, 0.84, ("on", "off"), ("vacuum-gripper",)),
    Station("panda", *SMALL, -0.625, 2, -np.pi / 2, 0.02, 0.70, ("closed", "open"), FINGERS),
)

HOME = "home"
"""Posture of an arm in which it begins and ends."""


def load(client: Client) -> None:
    """Replace the world by the cell; without PyBullet, which has no wheel from Python 3.12 on, with arms of rtb-data.

    The Panda keeps the limits of its model file, which are those of Franka Emika, Franka Control Interface
    Documentation, Robot and interface specifications: 2.175 rad/s for joints 1 to 4, 2.61 rad/s for joints 5 to 7.
    """
    text = SCENE.read_text("utf-8")
    if not find_spec("pybullet_data"):
        for theirs, others in WITHOUT_PYBULLET.items():
            text = text.replace(theirs, others)
    with TemporaryDirectory() as folder:
        (file := Path(folder) / SCENE.name).write_text(text, "utf-8")
        client.scene.load_scene(file)
    limit_speeds(client, "iiwa", IIWA_SPEEDS)
    client.view.background = "#e8edf2"
    client.view.grid = False
    client.view.set_camera(position=(0.95, -2.75, 1.85), target=(-0.2, 0.41, 0.43), field_of_view=0.68)
    for station in STATIONS:  # so that an arm that was stopped anywhere finds back
        client.robot(station.robot).postures.add(HOME, replace=True)


def limit_speeds(client: Client, robot: str, speeds: ArrayLike) -> None:
    """Give the joints of an arm other speed limits, (k,) in rad/s, reached in a quarter of a second like its own."""
    limit = dict(zip(client.robot(robot).chain_joint_names, np.asarray(speeds, float), strict=True))
    read = scene_pb2.GetSceneRequest(names=client.robot(robot).links, read_mask={"paths": ["name", "link"]})
    commands = []
    for node in client.services.scene.GetScene(read).nodes:
        if node.link.joint.name in limit:
            speed, limits = limit[node.link.joint.name], node.link.joint.limits
            limits.velocity, limits.acceleration, limits.jerk = speed, 4 * speed, 40 * speed
            update = scene_pb2.UpdateNode(name=node.name, node=node, update_mask={"paths": ["link"]})
            commands.append(scene_pb2.Command(update_node=update))
    client.services.apply(commands)
