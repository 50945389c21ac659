"""Robots of files as the crafts that a table of models tells: what drives them, and which joints turn or stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from virtualrobot_sdk.models import ModelCraft, ModelWheel

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.craft_data import Craft, CraftDrive
from virtualrobot_kernel.world.figures import Cylinder, Figure, Material
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, LinkData, NodeSpec, RobotData

JERKS = 10.0
"""Greatest jerk of a wheel, by its greatest acceleration in a second."""

TIRE = (0.1, 0.1, 0.1, 1.0)
"""Colour of wheels that a file has none of."""


def with_craft(robot: NodeSpec, craft: ModelCraft) -> NodeSpec:
    """Return a robot as the craft that a table of models tells."""
    assert isinstance(robot.data, RobotData)
    drives = tuple(CraftDrive(drive, joint, ratio) for drive, (joint, ratio) in craft.drives.items())
    return replace(
        robot,
        data=replace(
            robot.data,
            craft=Craft(craft.kinematics, dict(craft.settings), drives, "", *craft.center, craft.heading),
        ),
    )


def as_craft(nodes: Sequence[NodeSpec], craft: ModelCraft) -> tuple[NodeSpec, ...]:
    """Return a robot and its links as the craft of a table; its wheels turn, and what stands for driving is fixed.

    Raises KernelError for a joint of the table that the file has not.
    """
    robot, *links = nodes
    found: list[NodeSpec] = []
    there: set[str] = set()
    for spec in links:
        if isinstance(spec.data, LinkData):
            joint = spec.data.joint
            there.add(joint.name)
            if joint.name in craft.fixed:
                joint = replace(joint, type=JointType.FIXED)
            elif joint.name in craft.wheels:
                joint = _turning(joint.name, craft.wheels[joint.name])
            spec = replace(spec, data=replace(spec.data, joint=joint))
        found.append(spec)
    names = {spec.name for spec in links}
    for name, wheel in craft.wheels.items():
        if name in there:
            continue
        parent = f"{robot.name}.{wheel.link}"
        if parent not in names:
            raise KernelError(f"the table of models puts the wheel {name!r} on {parent!r}, which the file has not")
        found.append(_wheel(robot.name, name, parent, wheel))
    if missing := next((name for name in craft.fixed if name not in there), None):
        raise KernelError(f"the table of models fixes the joint {missing!r}, which the file has not")
    if craft.flange:
        assert isinstance(robot.data, RobotData)
        robot = replace(robot, data=replace(robot.data, flange=f"{robot.name}.{craft.flange}"))
    return (with_craft(robot, craft), *found)


def _turning(name: str, wheel: ModelWheel) -> Joint:
    limits = JointLimits(velocity=wheel.velocity, acceleration=wheel.acceleration, jerk=JERKS * wheel.acceleration)
    return Joint(name, JointType.CONTINUOUS, (0.0, 1.0, 0.0), limits)


def _wheel(robot: str, name: str, parent: str, wheel: ModelWheel) -> NodeSpec:
    """Return a link that is a wheel to look at: it touches nothing, since the link that it is on is as wide."""
    place, lying = np.eye(4), np.eye(4)
    place[:3, 3] = wheel.position
    lying[1:3, 1:3] = [[0.0, -1.0], [1.0, 0.0]]
    tire = Figure(Cylinder(wheel.radius, wheel.width), lying, Material(color=TIRE), collision=False)
    data = LinkData(_turning(name, wheel))
    return NodeSpec(f"{robot}.{name}", Kind.LINK, parent, place, figures=(tire,), data=data)
