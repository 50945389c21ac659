"""The palletizing cell with other arms, whose controllers are emulated: a UR5e and an IRB 1200 with suction cups."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import virtualrobot
from virtualrobot import Client, pose

from virtualrobot_apps.demos.palletizing.cell import HOME, LARGE, SCENE, SMALL, Station

SPEED_FACTOR = 0.35
"""Part of their speed at which arms go; setpoints of a busy computer that come late are then still within its reach."""

MODELS = {"ur": "model://ur5e", "abb": "model://irb1200_5_90"}
HOMES = {"ur": (0.0, -1.57, 1.57, -1.57, -1.57, 0.0), "abb": (0.0, 0.0, 0.0, 0.0, 1.57, 0.0)}
"""Postures (rad) in which the controllers have their arms as they are switched on: above the floor, tool down."""

# Where arms stand so that they look between belt and pallet in these postures.
YAWS = {"ur": np.radians(135.0), "abb": np.radians(-135.0)}

STATIONS = (
    Station("ur", *LARGE, 0.625, 1, np.pi / 2, 0.0, 0.76, ("on", "off"), ("ur-gripper",)),
    Station("abb", *SMALL, -0.625, 1, -np.pi / 2, 0.0, 0.70, ("on", "off"), ("abb-gripper",)),
)

CARTON = "carton"
CARTON_SIZE, CARTON_PLACE = (0.22, 0.22, 0.95), (1.20, 0.17)
"""Of a carton on the floor, between belt and pallet of the first arm, meters."""


def scene_text() -> str:
    """Return the scene file of the palletizing cell with these arms in place of the others."""
    text = SCENE.read_text("utf-8")
    head, rest = text.split("models:\n", 1)
    _, rest = rest.split("\nnodes:\n", 1)
    nodes, rest = rest.split("  # What the robots work with.\n", 1)
    tools, rest = rest.split("\nrobot_states:\n", 1)
    _, rest = rest.split("\nsignals:\n", 1)
    gripper = "  - name: vacuum-gripper\n" + tools.split("  - name: vacuum-gripper\n", 1)[1].split("  - name: ", 1)[0]
    models, mounted, states = [], [], []
    for robot, uri in MODELS.items():
        turn = f"z: {np.sin(YAWS[robot] / 2):.9f}, w: {np.cos(YAWS[robot] / 2):.9f}"
        models.append(f"  - uri: {uri}\n    name: {robot}\n    parent: {robot}-pedestal\n")
        models.append(f"    parent_t_node: {{position: {{z: 0.35}}, orientation: {{{turn}}}}}\n")
        own = gripper.replace("name: vacuum-gripper", f"name: {robot}-gripper")
        mounted.append(own.replace("parent: iiwa-adapter", f"parent: {robot}.flange"))
        states.append(f"  - {{name: {robot}, positions: {list(HOMES[robot])}}}\n")
    for old, new in ("iiwa", "ur"), ("panda", "abb"), ("Panda", "ABB"):
        head, nodes, rest = (part.replace(old, new) for part in (head, nodes, rest))
    return (
        f"{head}models:\n{''.join(models)}\nnodes:\n{nodes}{''.join(mounted)}"
        f"\nrobot_states:\n{''.join(states)}\nsignals:\n{rest}"
    )


def load(client: Client) -> None:
    """Replace the world by the cell, its arms guarded."""
    with TemporaryDirectory() as folder:
        (file := Path(folder) / SCENE.name).write_text(scene_text(), "utf-8")
        client.scene.load_scene(file)
    robots = [station.robot for station in STATIONS]
    for robot in robots:
        client.robot(robot).speed_factor = SPEED_FACTOR
        client.robot(robot).postures.add(HOME, replace=True)
    client.collisions.set(robots={**dict.fromkeys(robots, "guard"), "conveyor": "off"})
    client.view.background = "#e8edf2"
    client.view.grid = False
    client.view.set_camera(position=(0.95, -2.75, 1.85), target=(-0.2, 0.41, 0.43), field_of_view=0.68)


def put_carton(client: Client) -> None:
    """Put a carton onto the floor, where an arm would go."""
    tape = virtualrobot.box(CARTON_SIZE[0] + 0.002, 0.05, CARTON_SIZE[2] + 0.002, color="#e6d3b3", roles=["visual"])
    place = pose(*CARTON_PLACE, 0.5 * CARTON_SIZE[2] + 0.003)
    client.scene.add_part(CARTON, [virtualrobot.box(*CARTON_SIZE, color="#b5854b"), tape], pose=place)
