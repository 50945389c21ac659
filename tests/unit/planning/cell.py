"""A cell with a real arm for tests of planned motions: iiwa with a hand, a bench with a fixture, a belt with a tray."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from virtualrobot_kernel.planning.robots import Arm, world_poses
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import CreateNodes, SelectTool, SetJointPositions
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import (
    Joint,
    JointLimits,
    JointType,
    Kind,
    NodeSpec,
    PartData,
    RobotData,
    ToolData,
)
from virtualrobot_plugins.chain.component import ChainKinematics

from tests.unit.formats.models import ROBOTS, load
from tests.unit.world.builders import after, empty, link, shifted

TICK = 0.004
JOINTS = tuple(f"lbr_iiwa_joint_{i}" for i in range(1, 8))
READY = dict(zip(JOINTS, [0.3, 0.6, -0.2, -1.4, 0.1, 0.9, 0.2], strict=True))


@lru_cache(maxsize=1)
def _iiwa() -> tuple[NodeSpec, ...]:
    model, _ = load(ROBOTS["iiwa"], name="arm", parent_t_node=shifted(y=0.2))
    robot, *links = model.nodes
    return (NodeSpec(robot.name, robot.kind, "stand", robot.parent_t_node, data=robot.data), *links)


def cell() -> Change:
    """Return the cell, the arm at READY, its hand chosen, its posture `ready`."""
    robot, *links = _iiwa()
    assert isinstance(robot.data, RobotData)
    data = RobotData(robot.data.flange, "chain", {"ready": READY}, robot.data.source)
    hand = ToolData({"tip": shifted(z=0.1), "side": shifted(x=0.05, z=0.1)}, {"on": {}, "off": {}})
    belt = JointLimits(-2.0, 2.0, 0.5, 2.0, 20.0)
    change = after(
        empty(),
        CreateNodes(
            (
                NodeSpec("stand", Kind.OBJECT, "world", shifted(z=0.1)),
                NodeSpec(robot.name, robot.kind, "stand", robot.parent_t_node, data=data),
                *links,
                NodeSpec("adapter", Kind.ADAPTER, links[-1].name, shifted(z=0.02)),
                NodeSpec("hand", Kind.TOOL, "adapter", data=hand),
                NodeSpec("bench", Kind.OBJECT, "world", shifted(x=0.4)),
                NodeSpec("fixture", Kind.OBJECT, "bench", shifted(z=0.3)),
                NodeSpec("box", Kind.PART, "bench", shifted(y=0.5), data=PartData(1.0)),
                NodeSpec("belt", Kind.ROBOT, "world", shifted(y=-0.5), data=RobotData()),
                link("belt.tray", "belt", Joint("slide", JointType.PRISMATIC, (1.0, 0.0, 0.0), belt)),
            )
        ),
    )
    return after(change, SetJointPositions("arm", READY), SelectTool("arm", "hand", "tip"))


def pictured(change: Change) -> Snapshot:
    """Return the snapshot of a world."""
    return Snapshot(change.structure, change.state, world_poses(change.structure, change.state), 1, 0.0, TICK)


def chain(snapshot: Snapshot, arm: Arm) -> ChainKinematics:
    """Solve any arm by the chain's component, in this process."""
    return ChainKinematics(arm.serial())


def tcp(change: Change) -> np.ndarray:
    """Return world_t_tcp (4, 4) of the arm's tip."""
    snapshot = pictured(change)
    return snapshot.world_t(snapshot.structure.node("hand").uid) @ shifted(z=0.1)
