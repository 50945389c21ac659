"""Groups of joints: the links between which the chain of a robot leads that is solved and moved. Pure."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.world.index import moved_links
from virtualrobot_kernel.world.structure import JointGroup, JointType, LinkData, Node, RobotData, Structure


@dataclass(frozen=True, slots=True)
class Group:
    """Choice of a robot's joints: those of its group called `name`, or the chain from the link `base` to `tip`.

    An empty base is the robot's own base (or its last floating or planar link), an empty tip its flange. All empty: the
    chain between these two.
    """

    name: str = ""
    base: str = ""
    tip: str = ""

    def __str__(self) -> str:
        """Return the group in words, after the name of its robot; empty for the robot's own chain."""
        if self.name:
            return f", group {self.name!r}"
        ends = (f"from {self.base!r}" if self.base else "", f"to {self.tip!r}" if self.tip else "")
        return f", chain {' '.join(filter(None, ends))}" if self.base or self.tip else ""

    @property
    def is_ad_hoc(self) -> bool:
        """True if it is chosen by links instead of by a name."""
        return bool(self.base or self.tip)


_FREE = (JointType.FLOATING, JointType.PLANAR)

WHOLE = Group()
"""Group of a robot's own chain, from its base to its flange."""


def chain_links(structure: Structure, robot: Node, group: Group) -> tuple[int, list[int]]:
    """Return the base (uid) of a group's chain and the links (uids) below it, the tip first.

    Raises UnknownNameError for a group or link that the robot has not, and KernelError where no chain leads from base
    to tip: INVALID_ARGUMENT for links of the caller, WRONG_STATE for a group whose joints are no chain.
    """
    if group.name:
        base, path = _named_chain(structure, robot, named_group(robot, group.name))
    else:
        base = link_named(structure, robot, group.base) if group.base else 0
        tip = link_named(structure, robot, group.tip) if group.tip else structure.robots[robot.uid].flange
        base, path = _between(structure, robot, base, tip)
    for uid in path if group != WHOLE else ():
        data = structure.nodes[uid].data
        if isinstance(data, LinkData) and data.joint.type in _FREE:
            raise KernelError(
                f"the joint {data.joint.name!r} of {robot.name!r}{group} is {data.joint.type.value[0]}, and a chain "
                "has only joints of one coordinate; let the chain begin below it",
                robot=robot.name,
                joint=data.joint.name,
            )
    return base, path


def joints_of(structure: Structure, robot: Node, group: Group) -> tuple[str, ...]:
    """Return the names of a group's joints in the robot's order, whether they are a chain or not."""
    if group.name:
        named = named_group(robot, group.name)
        if named.joint_names or not (named.base_link or named.tip_link):
            return named.joint_names
    index = structure.robots[robot.uid]
    chain = {structure.forest.q_index[structure.rows[uid]] for uid in chain_links(structure, robot, group)[1]}
    links = moved_links(structure, index)
    places = (structure.forest.q_index[structure.rows[uid]] for uid in links)
    return tuple(name for name, place in zip(index.joint_names, places, strict=True) if place in chain)


def named_group(robot: Node, name: str) -> JointGroup:
    """Return a robot's group; raise UnknownNameError when it has none of that name."""
    groups = {group.name: group for group in robot.data.groups} if isinstance(robot.data, RobotData) else {}
    if name not in groups:
        raise UnknownNameError(f"group of {robot.name!r}", name, groups)
    return groups[name]


def link_named(structure: Structure, robot: Node, name: str) -> int:
    """Return the uid of a robot's link, named with or without the robot; raise UnknownNameError without one."""
    links = structure.robots[robot.uid].links
    for full in (f"{robot.name}.{name}", name):
        uid = structure.uid_by_name.get(full, 0)
        if uid in links:
            return uid
    prefix = robot.name + "."
    names = (structure.nodes[uid].name.removeprefix(prefix) for uid in links)
    raise UnknownNameError(f"link of {robot.name!r}", name, names)


def _between(structure: Structure, robot: Node, base: int, tip: int) -> tuple[int, list[int]]:
    """Return the links from `tip` up to the `base` (0: the robot's base), which is the first of both."""
    path: list[int] = []
    at = tip
    while at not in (base, robot.uid):
        data = structure.nodes[at].data
        if not base and isinstance(data, LinkData) and data.joint.type in _FREE:
            break
        path.append(at)
        at = structure.nodes[at].parent
    if base and at != base:
        above = [structure.nodes[uid].name.removeprefix(robot.name + ".") for uid in reversed(path[1:])]
        base_name, tip_name = (structure.nodes[uid].name for uid in (base, tip))
        raise KernelError(
            f"the link {tip_name!r} is not below {base_name!r}, so no chain leads from one to the other; above it are "
            f"{', '.join(map(repr, above)) or 'no links'}",
            robot=robot.name,
            base_link=base_name,
            tip_link=tip_name,
        )
    return at, path


def _named_chain(structure: Structure, robot: Node, group: JointGroup) -> tuple[int, list[int]]:
    """Return the chain of a group: between its links, or the one that its joints are."""
    index = structure.robots[robot.uid]
    base = link_named(structure, robot, group.base_link) if group.base_link else 0
    tip = link_named(structure, robot, group.tip_link) if group.tip_link else 0
    if base and tip:
        return _between(structure, robot, base, tip)
    moved = dict(zip(index.joint_names, moved_links(structure, index), strict=True))
    own = [moved[name] for name in group.joint_names]
    if not own:
        raise _no_chain(robot, group, "it has no joint")
    depth = {uid: sum(1 for _ in structure.ancestors(uid)) for uid in own}
    # Without links of its own the group ends at the last of its joints, and begins before the first.
    tip = tip or max(own, key=depth.__getitem__)
    base = base or structure.nodes[min(own, key=depth.__getitem__)].parent
    above = {node.uid for node in structure.ancestors(tip)}
    for name, uid in zip(group.joint_names, own, strict=True):
        if uid not in above:
            raise _no_chain(robot, group, f"its joint {name!r} does not lead to {structure.nodes[tip].name!r}")
    _, path = _between(structure, robot, base, tip)
    places = {structure.forest.q_index[structure.rows[uid]] for uid in own}
    for uid in path:
        data = structure.nodes[uid].data
        if structure.nodes[uid].is_moved and structure.forest.q_index[structure.rows[uid]] not in places:
            assert isinstance(data, LinkData)
            raise _no_chain(robot, group, f"the joint {data.joint.name!r}, which is not in it, lies between its joints")
    return base, path


def _no_chain(robot: Node, group: JointGroup, why: str) -> KernelError:
    return KernelError(
        f"the group {group.name!r} of {robot.name!r} is no chain: {why}; it can be moved by its joints, but not be "
        "solved",
        reason=Reason.WRONG_STATE,
        robot=robot.name,
        group=group.name,
    )
