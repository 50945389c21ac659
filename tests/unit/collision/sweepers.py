"""Robots whose contacts have formulas: balls on turning levers, balls on slides; and a tool that grows."""

from __future__ import annotations

import numpy as np
from virtualrobot_kernel.world.figures import Box, Figure, Geometry, Pose, Sphere
from virtualrobot_kernel.world.structure import (
    Joint,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    NodeSpec,
    RobotData,
    ToolData,
)

from tests.unit.world.builders import Z, shifted

BALL = 0.1
LEVER = 1.0
X = (1.0, 0.0, 0.0)
LIMITS = JointLimits(-3.0, 3.0, 1.0, 4.0, 40.0)


def turning(angle: float) -> Pose:
    """Return a turn about z, in rad."""
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return pose


def moved_by(name: str, joint: Joint, pose: Pose, figure: Figure) -> tuple[NodeSpec, ...]:
    """Return a robot of one joint, at a pose, whose link `NAME.ball` has a figure."""
    return (
        NodeSpec(name, Kind.ROBOT, parent_t_node=pose, data=RobotData()),
        NodeSpec(f"{name}.ball", Kind.LINK, name, shifted(), figures=(figure,), data=LinkData(joint)),
    )


def sweeper(name: str = "sweeper", pose: Pose | None = None) -> tuple[NodeSpec, ...]:
    """Return a ball of `BALL` m at the end of a lever of `LEVER` m that `turn` turns about z."""
    joint = Joint("turn", JointType.REVOLUTE, Z, LIMITS)
    return moved_by(name, joint, shifted() if pose is None else pose, Figure(Sphere(BALL), shifted(x=LEVER)))


def slider(name: str = "slider", pose: Pose | None = None) -> tuple[NodeSpec, ...]:
    """Return a ball of `BALL` m that `slide` moves along x."""
    joint = Joint("slide", JointType.PRISMATIC, X, LIMITS)
    return moved_by(name, joint, shifted() if pose is None else pose, Figure(Sphere(BALL)))


def growing(name: str, parent: str) -> NodeSpec:
    """Return a tool that reaches 0.1 m when it is `small` and 0.5 m along x when it is `large`, with no joints."""
    figures = (
        Figure(Box((0.1, 0.05, 0.05)), shifted(x=0.05), tool_state="small"),
        Figure(Box((0.5, 0.05, 0.05)), shifted(x=0.25), tool_state="large"),
    )
    data = ToolData({"tip": shifted(x=0.1)}, {"small": {}, "large": {}})
    return NodeSpec(name, Kind.TOOL, parent, shifted(x=BALL), figures=figures, data=data)


def body(name: str, geometry: Geometry, pose: Pose) -> NodeSpec:
    """Return an object of one figure."""
    return NodeSpec(name, Kind.OBJECT, parent_t_node=pose, figures=(Figure(geometry),))


def contact_angle(radius: float) -> float:
    """Return how far (rad) the sweeper's ball and one of `radius` at the same distance are apart when they touch.

    Both centres are `LEVER` from the axis, the sum of the radii apart: 2 asin((BALL + radius) / (2 LEVER)).
    """
    return 2.0 * float(np.arcsin((BALL + radius) / (2.0 * LEVER)))
