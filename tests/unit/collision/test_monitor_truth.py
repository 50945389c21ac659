"""Whatever is done to a world, the monitor's report is what a new scene finds in it, and its events lead there."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from virtualrobot_kernel.collision.report import Ended, Touch
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.collision.transitions import watched
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.commands import (
    AttachNode,
    Command,
    CreateNodes,
    RemoveNode,
    SetAllowedPairs,
    SetCollisionSettings,
    SetJointPositions,
    UpdateNode,
)
from virtualrobot_kernel.world.structure import Kind

from tests.pybullet_models import pybullet_data as pybullet_data  # skips where there is none
from tests.unit.collision.carts import block, mode
from tests.unit.collision.test_monitor import Cell
from tests.unit.collision.worlds import ROBOTS, SHAPES, robot_nodes
from tests.unit.world.builders import random_pose

Pairs = set[tuple[int, int]]
ROUNDS = 150
HANDS = {"iiwa": "iiwa.lbr_iiwa_link_7", "panda": "panda.panda_hand"}


def touching(cell: Cell) -> Pairs:
    """Return what a new scene finds, of robots that are watched."""
    scene, snapshot = CollisionScene(SHAPES), cell.world.snapshot
    modes = watched(snapshot)
    if not modes:
        return set()
    scene.place(snapshot)
    return {(pair.first, pair.second) for pair in scene.collisions(Detail.PAIRS, modes.keys())}


def some(cell: Cell, rng: np.random.Generator) -> Sequence[Command]:
    """Return something to do."""
    nodes = [node for node in cell.world.snapshot.structure.nodes.values() if node.parent]
    one, other = (nodes[int(rng.integers(len(nodes)))] for _ in range(2))
    parts = [node.name for node in nodes if node.kind is Kind.PART] or ["none"]
    part, robot = str(rng.choice(parts)), str(rng.choice(["iiwa", "panda"]))
    index = cell.world.snapshot.structure.robots[cell.world.snapshot.structure.node(robot).uid]
    jump = {joint.name: rng.uniform(joint.limits.lower, joint.limits.upper) for joint in index.joints}
    choices: list[Callable[[], Command]] = [
        lambda: SetJointPositions(robot, jump),
        lambda: SetJointPositions(robot, jump),
        lambda: UpdateNode(part, parent_t_node=random_pose(rng)),
        lambda: AttachNode(part, str(rng.choice(["world", HANDS[robot]]))),
        lambda: mode(**{robot: str(rng.choice(["off", "monitor", "stop", ""]))}),
        lambda: mode(str(rng.choice(["off", "monitor", "stop"]))),
        lambda: SetAllowedPairs(allow=((one.name, other.name, ""),)),
        lambda: SetAllowedPairs(forbid=((one.name, other.name),)),
        lambda: SetCollisionSettings(paddings=((one.name, float(rng.choice([0.0, 0.05]))),)),
        lambda: UpdateNode(robot, parent_t_node=random_pose(rng)),
        lambda: block(f"part {int(rng.integers(1000))}", *rng.uniform(-0.7, 0.7, 2), kind=Kind.PART),
        lambda: RemoveNode(part),
    ]
    return [choices[int(rng.integers(len(choices)))]() for _ in range(int(rng.integers(1, 3)))]


def test_reports_are_what_a_new_scene_finds(rng: np.random.Generator) -> None:
    cell = Cell()
    followed: Pairs = set()
    told = 0
    try:
        cell.do(*(CreateNodes(robot_nodes(ROBOTS[kind], kind)) for kind in ("iiwa", "panda")), mode("monitor"))
        for _ in range(ROUNDS):
            try:
                cell.do(*some(cell, rng))
            except KernelError:
                continue  # a name that is gone, a pair that was not allowed: nothing has happened
            report = cell.monitor.latest
            assert report.fault == ""
            assert {(one.pair.first, one.pair.second) for one in report.touching} == touching(cell)
            events, missed = report.after(told)
            told = report.event_count
            assert not missed
            for event in events:
                touch = event.what.touch if isinstance(event.what, Ended) else event.what
                assert isinstance(touch, Touch)
                pair = touch.pair.first, touch.pair.second
                assert (pair in followed) == isinstance(event.what, Ended)
                followed ^= {pair}
            assert followed == touching(cell)
        assert told > 5
    finally:
        cell.close()
