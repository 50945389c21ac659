"""Targets: what they name of the robots that they were taught with."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.change import coordinate_of
from virtualrobot_kernel.world.structure import Kind, Node, Structure, TargetData


def check_target(structure: Structure, node: Node) -> None:
    """Raise KernelError, which names the target, unless robot, tool and joints that it names are there.

    Values of joints are looked at when a move goes there: limits may change, and a target is a pose all the same.
    """
    target = node.data
    assert isinstance(target, TargetData)
    try:
        if target.robot:
            robot = structure.node(target.robot, Kind.ROBOT)
            for joint in target.joint_positions:
                coordinate_of(structure, robot, joint)
        elif target.joint_positions:
            raise KernelError("joint positions are those of a robot; name it, or give none", field="robot")
        if target.tool:
            structure.node(target.tool, Kind.TOOL)
    except KernelError as error:
        error.metadata["target"] = node.name
        raise error.at(f"the target {node.name!r}") from None


def taught_with(nodes: Iterable[Node], robot: str) -> Iterator[Node]:
    """Yield the targets among nodes that were taught with the robot of this name."""
    return (node for node in nodes if isinstance(node.data, TargetData) and node.data.robot == robot)


def without_gone(nodes: Mapping[int, Node], gone: Iterable[str]) -> dict[int, Node]:
    """Return nodes by uid, in which targets name nothing that is gone; they stay where they are."""
    names = frozenset(gone)
    result = dict(nodes)
    for uid, node in nodes.items():
        data = node.data
        if isinstance(data, TargetData) and not names.isdisjoint((data.robot, data.tool)):
            data = TargetData() if data.robot in names else replace(data, tool="", tool_center_point="")
            result[uid] = replace(node, data=data)
    return result
