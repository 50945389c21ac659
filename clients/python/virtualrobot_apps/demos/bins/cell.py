"""Cell of two bins: a conveyor lets boxes fall into the first, an arm with two fingers reaches both."""

from __future__ import annotations

import numpy as np
import virtualrobot
from virtualrobot import Client, JointMotor

from virtualrobot_apps.seeing.grasping.jaw import Jaw

ARM, HAND, CONVEYOR, SCANNER = "arm", "hand", "conveyor", "scanner"
HOME = (0.0, 0.3, 0.0, -1.5, 0.0, 1.3, 0.0)
"""Posture (rad) above the bins, tool down."""

EDGE, MASS, FRICTION = 0.04, 0.1, 0.6
"""Of a box: its edges (m), mass (kg), and coefficient of friction with all that it touches."""
EFFORT = 20.0
"""Greatest effort of the gripper's motor (N): an arm that holds a box by friction needs m g / mu, here 1.6 N."""

TOP = 0.5
"""Height of the table (m)."""
INSIDE, DEEP, WALL = 0.28, 0.1, 0.01
"""Inner length and width of a bin, its depth, and the thickness of its walls (m)."""
HALVES = 0.5 * INSIDE, 0.5 * INSIDE + WALL
"""Half the lengths of a bin, inner and outer (m)."""
FROM, TO = (0.52, 0.24), (0.52, -0.24)
"""Middles of the bin that boxes fall into, and of that to which they go: x, y (m)."""
BELT_END = 0.42
"""Place (m) along y at which the belt ends, beside the first bin."""
BELT_LENGTH = 2.0
JAW = Jaw(0.056, wide=0.025, thick=0.01, long=0.06, tip=0.02)
"""Fingers of the hand, open."""


def load(client: Client, engine: str, effort: float = EFFORT) -> None:
    """Replace the world by the cell, its bins empty; the arm and its hand move by forces of that engine."""
    scene = client.scene
    scene.clear()
    client.physics.set("none")
    scene.add_object("floor", virtualrobot.box(6.0, 6.0, 0.1, color="#b8bcc0"), pose=virtualrobot.pose(z=-0.05))
    table = virtualrobot.box(1.1, 1.2, TOP, color="#d8d4cc").with_surface(friction=FRICTION)
    scene.add_object("table", table, pose=virtualrobot.pose(0.35, 0.0, 0.5 * TOP))
    for name, (x, y), color in (("bin_from", FROM, "#3a6ea5"), ("bin_to", TO, "#4f8a4b")):
        scene.add_object(name, walls(color), pose=virtualrobot.pose(x, y, TOP))
    # Its belt runs towards the first bin, and ends beside it.
    client.load_robot(
        "model://conveyor", name=CONVEYOR, pose=virtualrobot.pose(FROM[0], BELT_END + BELT_LENGTH, 0, 0, 0, -np.pi / 2)
    )
    arm = client.load_robot("model://iiwa", name=ARM, pose=virtualrobot.pose(z=TOP))
    arm.set_positions(HOME)
    arm.mount("model://parallel_gripper", name=HAND)
    client.robot(HAND).set_positions([0.5 * JAW.opening])
    client.physics.set(engine)
    client.physics.set_motors(HAND, {"left_finger": JointMotor("position", max_effort=effort)})
    client.physics.enable(ARM, HAND)
    # It looks down on the first bin, and is off by 1 mm (1 sigma).
    scanner = virtualrobot.range_sensor(
        pattern=virtualrobot.raster(160, 160, 0.36, 0.36),
        sensor_model="laser",
        sensor_model_settings={"deviation_meters": 0.001},
        max_range=1.5,
    )
    above = virtualrobot.pose(*FROM, TOP + 1.0, pitch=np.pi / 2)
    scene.add_range_sensor(SCANNER, scanner, pose=above)
    client.view.grid = False
    client.view.background = "#e8edf2"
    client.view.set_camera(position=(1.65, -0.75, 1.4), target=(0.38, 0.12, 0.62))


def walls(color: str) -> list[virtualrobot.Figure]:
    """Return the floor and the four walls of a bin, about the middle of its bottom."""
    outside, middle = INSIDE + 2.0 * WALL, 0.5 * (INSIDE + WALL)
    long, across = (outside, WALL, DEEP), (WALL, outside, DEEP)
    sides = [((outside, outside, WALL), (0.0, 0.0, 0.5 * WALL))]
    sides += [(long, (0.0, at, 0.5 * DEEP)) for at in (-middle, middle)]
    sides += [(across, (at, 0.0, 0.5 * DEEP)) for at in (-middle, middle)]
    boxes = [virtualrobot.box(*size, color=color, pose=virtualrobot.pose(*where)) for size, where in sides]
    return [one.with_surface(friction=FRICTION) for one in boxes]


def holds(bin_at: tuple[float, float], place: np.ndarray) -> bool:
    """Return whether a place (3,) is in the bin whose middle is there; a heap may be as high again as its walls."""
    return bool(np.abs(place[:2] - bin_at).max() < 0.5 * INSIDE and TOP < place[2] < TOP + 2.0 * DEEP)
