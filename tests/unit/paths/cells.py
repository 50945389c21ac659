"""Arms with something in their way, a job's site without a process, and whether a way touches anything by coal."""

from __future__ import annotations

import threading
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.paths.query import PathOptions, PathQuery, path_query
from virtualrobot_kernel.planning.robots import Arm, standing_at
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.collision.worlds import after, asked, coal_touches, scene_of, with_robots
from tests.unit.world.builders import shifted

Floats = NDArray[np.float64]

LEFT = {"lbr_iiwa_joint_1": 0.9, "lbr_iiwa_joint_2": 0.9, "lbr_iiwa_joint_4": -1.2}
RIGHT = {**LEFT, "lbr_iiwa_joint_1": -0.9}

PANDA_LEFT = {
    "panda_joint1": 0.9,
    "panda_joint2": 0.6,
    "panda_joint4": -1.6,
    "panda_joint6": 2.2,
}
PANDA_RIGHT = {**PANDA_LEFT, "panda_joint1": -0.9}

OPTIONS = PathOptions("RRTConnect", 0, 20.0, 1.0, 50.0)


class HereSite:
    """What a job is given, in this process."""

    def __init__(self, snapshot: Snapshot, scene: CollisionScene | None = None) -> None:
        """Place a scene, or take one."""
        self.snapshot, self.scene = snapshot, scene or scene_of(snapshot)
        self.reports: list[object] = []
        self.gone = threading.Event()

    def told(self, value: object) -> None:
        """Keep a report."""
        self.reports.append(value)

    def given_up(self) -> bool:
        """Return whether the test has given up."""
        return self.gone.is_set()

    def go_on(self) -> None:
        """Raise when the test has given up."""
        if self.gone.is_set():
            raise InterruptedError


def wall(height: float = 0.8, distance: float = 0.5) -> CreateNodes:
    """Return a wall before a robot, 5 cm thick, between its left and its right."""
    figure = Figure(Box((0.6, 0.05, height)))
    pose = shifted(x=distance + 0.3, z=height / 2.0)
    return CreateNodes((NodeSpec("wall", Kind.OBJECT, "world", pose, figures=(figure,)),))


def standing(snapshot: Snapshot, robot: str, joints: Mapping[str, float]) -> Snapshot:
    """Return a world with joints of a robot elsewhere."""
    index = next(one for one in snapshot.structure.robots.values() if snapshot.structure.nodes[one.uid].name == robot)
    places = {joint.name: start for joint, start in zip(index.joints, index.q_start, strict=True)}
    q_index = np.array([places[name] for name in joints], np.int32)
    return standing_at(snapshot, q_index, np.array(list(joints.values())))


def walled(kind: str = "iiwa", **sizes: float) -> Snapshot:
    """Return an arm left of a wall."""
    left = {"iiwa": LEFT, "panda": PANDA_LEFT}[kind]
    return standing(after(with_robots(kind), wall(**sizes)), kind, left)


def unsolved(_: Snapshot, arm: Arm) -> None:
    """Fail: joint goals need no solver."""
    raise AssertionError(arm.robot.name)


def query(snapshot: Snapshot, robot: str, goal: Mapping[str, float], options: PathOptions = OPTIONS) -> PathQuery:
    """Return the question for a path to joint values."""
    return path_query(snapshot, robot, goal, unsolved, options)  # pyright: ignore[reportArgumentType]


def touched_on(snapshot: Snapshot, q_index: NDArray[np.int32], configurations: Floats) -> list[int]:
    """Return which of some configurations (n, k) touch anything, by coal, pair by pair."""
    scene = scene_of(snapshot)
    pairs = asked(scene)
    before = coal_touches(scene, pairs)
    found = []
    for row, q in enumerate(configurations):
        scene.place(standing_at(snapshot, q_index, q))
        if coal_touches(scene, pairs) - before:
            found.append(row)
    return found
