"""Crafts: robots whose base is moved by their drives, as data. Which way is the matter of a component, outside."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.change import Change, Forward, refuse_while_moving, single_joint
from virtualrobot_kernel.world.commands import SetCraft
from virtualrobot_kernel.world.craft_data import Craft
from virtualrobot_kernel.world.state import Motion
from virtualrobot_kernel.world.structure import Joint, JointType, Node, RobotData, RobotIndex, Structure


def set_craft(change: Change, command: SetCraft, forward: Forward) -> Change:
    """Make a robot a craft, another one, or none; refused while it moves, and where names or joints don't fit."""
    structure = change.structure
    node, robot = structure.robot(command.robot)
    refuse_while_moving(change, node, {(node.uid, name) for name in robot.coordinates})
    assert isinstance(node.data, RobotData)
    node = replace(node, data=replace(node.data, craft=command.craft))
    structure = index.replaced(structure, node)
    check_craft(structure, node)
    return replace(change, structure=structure)


def check_craft(structure: Structure, node: Node) -> None:
    """Raise KernelError unless a craft has a base that can be moved, and the joints that its drives name."""
    craft = craft_of(node)
    if craft is None:
        return
    base_joint(structure, node)
    drives: set[str] = set()
    moved: set[str] = set()
    for one in craft.drives:
        try:
            joint = single_joint(structure, node, one.joint)[0]
        except KernelError as error:
            error.args = (f"the drive {one.drive!r} of {node.name!r}: {error}",)
            raise
        wrong = (
            "is named twice"
            if one.drive in drives
            else f"moves {joint.name!r}, which another drive moves already"
            if joint.name in moved
            else "has the ratio 0"
            if not one.ratio
            else ""
        )
        if wrong:
            raise KernelError(f"the drive {one.drive!r} of {node.name!r} {wrong}", robot=node.name, drive=one.drive)
        drives.add(one.drive)
        moved.add(joint.name)


def craft_of(node: Node) -> Craft | None:
    """Return what makes a robot a craft, or None."""
    return node.data.craft if isinstance(node.data, RobotData) else None


def base_joint(structure: Structure, node: Node) -> tuple[Joint, int, int]:
    """Return the joint by which a craft's base moves, and where it begins in q and v.

    Raises KernelError where it has none that is floating, or planar about the z axis.
    """
    robot, craft = structure.robots[node.uid], craft_of(node)
    wanted = craft.base_joint if craft else ""
    several = {
        joint.name: place
        for place, joint in enumerate(robot.joints)
        if joint.type in (JointType.PLANAR, JointType.FLOATING)
    }
    if wanted and wanted not in several:
        raise UnknownNameError(f"planar or floating joint of {node.name!r}", wanted, several)
    if not several:
        raise KernelError(
            f"{node.name!r} has no planar or floating joint that its drives could move; load it with the base planar",
            robot=node.name,
        )
    place = several[wanted] if wanted else next(iter(several.values()))
    joint = robot.joints[place]
    if joint.type is JointType.PLANAR and joint.axis[2] < 1.0 - 1e-9:
        raise KernelError(
            f"the joint {joint.name!r} of {node.name!r} is planar about {joint.axis}; drives move a base about 0, 0, 1",
            robot=node.name,
            joint=joint.name,
        )
    return joint, robot.q_start[place], robot.v_start[place]


def base_coordinates(structure: Structure, node: Node) -> tuple[str, ...]:
    """Return the names of the coordinates by which a craft's base moves; none of a robot that is no craft."""
    return base_joint(structure, node)[0].coordinate_names if craft_of(node) else ()


def refuse_base(structure: Structure, joints: Iterable[tuple[int, str]]) -> None:
    """Raise KernelError (WRONG_STATE) for motions, by joints (robot uid, name), of what drives move."""
    for uid in dict.fromkeys(uid for uid, _ in joints):
        node = structure.nodes[uid]
        moved = {name for robot, name in joints if robot == uid}.intersection(base_coordinates(structure, node))
        if moved:
            drives = (craft_of(node) or Craft()).drives
            names = f" ({', '.join(repr(one.joint) for one in drives)})" if drives else ""
            raise KernelError(
                f"{min(moved)!r} is moved by the drives of the craft {node.name!r}; move these{names}, put it "
                "elsewhere with set_joint_positions, or make it a craft no more with set_craft",
                reason=Reason.WRONG_STATE,
                robot=node.name,
                joint=min(moved),
            )


def moves_craft(structure: Structure, motion: Motion) -> bool:
    """Return whether a motion moves joints of a craft, so that its path may not tell where the base goes.

    Which of them are drives only the component knows: a drive that nobody has named is the joint of its own name.
    """
    robots = {uid for uid, _ in motion.joints if uid in structure.nodes}
    return any(craft_of(structure.nodes[uid]) is not None for uid in robots)


def crafts(structure: Structure) -> Iterable[tuple[Node, RobotIndex, Craft]]:
    """Yield the crafts of a world."""
    for uid, robot in structure.robots.items():
        node = structure.nodes[uid]
        if (craft := craft_of(node)) is not None:
            yield node, robot, craft
