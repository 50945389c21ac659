"""Small worlds for tests: a two-joint arm with a mimic finger, a floating body, parts and a tool."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import Command, CreateNodes
from virtualrobot_kernel.world.figures import Box, Figure, Pose
from virtualrobot_kernel.world.state import empty_state
from virtualrobot_kernel.world.structure import (
    Joint,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    Mimic,
    NodeSpec,
    PartData,
    RobotData,
    ToolData,
)
from virtualrobot_kernel.world.tick import advance

TICK = 0.004
LIMITS = JointLimits(-2.0, 2.0, 1.0, 4.0, 40.0)
Z = (0.0, 0.0, 1.0)


def shifted(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Pose:
    """Return a pose that only shifts, in meters."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def unit(rng: np.random.Generator) -> np.ndarray:
    """Return a random unit vector (3,)."""
    axis = rng.normal(size=3)
    return axis / np.linalg.norm(axis)


def random_pose(rng: np.random.Generator) -> Pose:
    """Return a random rigid transform; the rotation is the Q of a random matrix's QR decomposition."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    pose = np.eye(4)
    pose[:3, :3] = q * np.linalg.det(q)
    pose[:3, 3] = rng.uniform(-1, 1, 3)
    return pose


def link(name: str, parent: str, joint: Joint, pose: Pose | None = None) -> NodeSpec:
    """Return a link."""
    return NodeSpec(name, Kind.LINK, parent, shifted() if pose is None else pose, data=LinkData(joint))


def arm(name: str = "arm") -> CreateNodes:
    """Return an arm of two revolute joints, with a gripper whose second finger follows the first one backwards."""
    finger = JointLimits(0.0, 0.04, 0.2, 1.0, 10.0)
    return CreateNodes(
        (
            NodeSpec(name, Kind.ROBOT, data=RobotData(flange="hand", postures={"bent": {"a": 0.5, "b": -0.5}})),
            link(f"{name}.one", name, Joint("a", JointType.REVOLUTE, Z, LIMITS), shifted(z=0.3)),
            link(f"{name}.two", f"{name}.one", Joint("b", JointType.REVOLUTE, Z, LIMITS), shifted(x=0.5)),
            link(f"{name}.hand", f"{name}.two", Joint("fixed"), shifted(x=0.5)),
            link(f"{name}.left", f"{name}.hand", Joint("f", JointType.PRISMATIC, Z, finger)),
            link(
                f"{name}.right",
                f"{name}.hand",
                Joint("g", JointType.PRISMATIC, Z, finger, Mimic("f", multiplier=-1.0, offset=0.01)),
            ),
            NodeSpec(
                f"{name}_gripper",
                Kind.TOOL,
                f"{name}.hand",
                data=ToolData(
                    {"tip": shifted(x=0.1), "side": shifted(y=0.1)}, {"open": {"f": 0.04}, "closed": {"f": 0.0}}
                ),
            ),
        )
    )


def part(name: str, pose: Pose, parent: str = "world") -> NodeSpec:
    """Return a part of 1 kg."""
    return NodeSpec(name, Kind.PART, parent, pose, figures=(Figure(Box((0.1, 0.1, 0.1))),), data=PartData(1.0))


def empty() -> Change:
    """Return a world with nothing in it."""
    return Change(index.empty(), empty_state())


def after(change: Change, *commands: Command) -> Change:
    """Return the world after commands, applied as one batch."""
    return apply(change.structure, change.state, commands, world_poses)


def world_t(change: Change, name: str) -> Pose:
    """Return where a node is in the world, shape (4, 4)."""
    structure = change.structure
    return world_poses(structure, change.state)[structure.rows[structure.node(name).uid]]


def ticked(change: Change, ticks: int = 1) -> Change:
    """Return the world some ticks of 4 ms later."""
    state = change.state
    for _ in range(ticks):
        state = advance(change.structure, state, TICK, world_poses)
    return replace(change, state=state)
