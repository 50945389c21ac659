"""Index of the world: checks the tree and lays it out as flat arrays.

The order is canonical: rows and siblings are in the order of their uids, however the world came to be what it is. So a
world that was replayed, undone or read from a checkpoint is the same as one that went on.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.world.structure import (
    WORLD_NAME,
    WORLD_UID,
    Forest,
    Joint,
    JointType,
    Kind,
    LinkData,
    Mimic,
    Node,
    RobotData,
    RobotIndex,
    Structure,
    robots_of_tool,
)

FEW = 20
"""Ratio of present to new nodes from which new ones are few: then adding them costs less than building anew."""

SINGLE = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC)


def empty() -> Structure:
    """Return a structure with nothing but the world's root."""
    return build({WORLD_UID: Node(WORLD_UID, WORLD_NAME, Kind.WORLD, 0)}, WORLD_UID + 1, 0)


def build(nodes: Mapping[int, Node], next_uid: int, revision: int) -> Structure:
    """Return the structure of `nodes` (by uid).

    Raise KernelError when names are not unique, a parent is missing or below its own child, a link is on no robot, or
    joints of a robot share a name or follow one that is not there.
    """
    nodes = dict(sorted(nodes.items()))
    rows = {uid: row for row, uid in enumerate(nodes)}
    uid_by_name = _names(nodes.values(), {})
    children: dict[int, list[int]] = {}
    for node in nodes.values():
        if node.parent:
            children.setdefault(node.parent, []).append(node.uid)
    parent = np.array([rows.get(node.parent, -1) for node in nodes.values()], np.int32)
    order = _order(nodes, rows, children)
    robots, counts = _robots(nodes, children, (0, 0))
    tools = _tools(nodes, nodes.values())
    return Structure(
        nodes=nodes,
        next_uid=next_uid,
        revision=revision,
        uid_by_name=uid_by_name,
        rows=rows,
        children={uid: tuple(below) for uid, below in children.items()},
        robots=robots,
        tools=tools,
        forest=Forest(order, parent, *_joint_rows(nodes, robots)),
        q_count=counts[0],
        v_count=counts[1],
    )


def appends(structure: Structure, new: Mapping[int, Node]) -> bool:
    """Return whether `extended` can add these nodes, cheaper than `build`: few, new, and no links of robots there are.

    A link more shifts the coordinates of all robots created after its own, and a node that returns goes where it was.
    """
    few = 0 < FEW * len(new) <= len(structure.nodes)
    later = few and [*new] == sorted(new) and min(new) > max(structure.nodes)
    return later and not any(node.kind is Kind.LINK and node.parent in structure.nodes for node in new.values())


def extended(structure: Structure, new: Mapping[int, Node], next_uid: int) -> Structure:
    """Return what `build` would return for all nodes, those that are there and `new` ones; raise the same errors."""
    rows = {**structure.rows, **{uid: row for row, uid in enumerate(new, len(structure.rows))}}
    uid_by_name = _names(new.values(), structure.uid_by_name)
    order = structure.forest.order
    growing = {node.parent: list(structure.children.get(node.parent, ())) for node in new.values()}
    below = {**structure.children, **growing}
    for uid, node in new.items():
        order = np.insert(order, _place_of(uid, node.parent, order, rows, below), rows[uid])
        growing[node.parent].append(uid)
    children = {**structure.children, **{uid: tuple(more) for uid, more in growing.items()}}
    robots, (q_count, v_count) = _robots(new, children, (structure.q_count, structure.v_count))
    nodes = {**structure.nodes, **new}
    tools = dict(structure.tools)
    for robot, mounted in _tools(nodes, new.values()).items():
        tools[robot] = (*tools.get(robot, ()), *mounted)
    forest = structure.forest
    joint_type, axis, q_index, multiplier, offset = _joint_rows(new, robots)
    return Structure(
        nodes=nodes,
        next_uid=next_uid,
        revision=structure.revision,
        uid_by_name=uid_by_name,
        rows=rows,
        children=children,
        robots={**structure.robots, **robots},
        tools=tools,
        forest=Forest(
            order=order,
            parent=np.append(forest.parent, np.array([rows[node.parent] for node in new.values()], np.int32)),
            joint_type=np.append(forest.joint_type, joint_type),
            axis=np.append(forest.axis, axis, axis=0),
            q_index=np.append(forest.q_index, q_index),
            multiplier=np.append(forest.multiplier, multiplier),
            offset=np.append(forest.offset, offset),
        ),
        q_count=q_count,
        v_count=v_count,
    )


def ends_with(structure: Structure, gone: Collection[int]) -> bool:
    """Return whether `shortened` can take these nodes (uids) away: the last ones, and no part of a robot that stays."""
    if {*islice(reversed(structure.rows), len(gone))} != {*gone}:
        return False
    whole = (structure.nodes[uid].kind is not Kind.LINK or structure.nodes[uid].parent in gone for uid in gone)
    return all(whole) and all(child in gone for uid in gone for child in structure.children.get(uid, ()))


def shortened(structure: Structure, gone: Collection[int]) -> Structure:
    """Return what `build` would return without the last nodes (uids); see `ends_with`."""
    left = len(structure.nodes) - len(gone)
    nodes, rows, names = dict(structure.nodes), dict(structure.rows), dict(structure.uid_by_name)
    children = dict(structure.children)
    for uid in gone:
        del rows[uid], names[nodes.pop(uid).name]
        children.pop(uid, None)
        parent = structure.nodes[uid].parent
        if below := tuple(child for child in children.get(parent, ()) if child not in gone):
            children[parent] = below
        else:
            children.pop(parent, None)
    robots = {uid: robot for uid, robot in structure.robots.items() if uid not in gone}
    ended = [robot for uid, robot in structure.robots.items() if uid in gone and robot.joints]
    tools = {uid: tuple(tool for tool in mounted if tool not in gone) for uid, mounted in structure.tools.items()}
    forest = structure.forest
    return Structure(
        nodes=nodes,
        next_uid=structure.next_uid,
        revision=structure.revision,
        uid_by_name=names,
        rows=rows,
        children=children,
        robots=robots,
        tools={uid: mounted for uid, mounted in tools.items() if mounted and uid in robots},
        forest=Forest(
            order=forest.order[forest.order < left],
            parent=forest.parent[:left],
            joint_type=forest.joint_type[:left],
            axis=forest.axis[:left],
            q_index=forest.q_index[:left],
            multiplier=forest.multiplier[:left],
            offset=forest.offset[:left],
        ),
        q_count=min((robot.q_start[0] for robot in ended), default=structure.q_count),
        v_count=min((robot.v_start[0] for robot in ended), default=structure.v_count),
    )


def reparented(structure: Structure, uid: int, parent: int) -> Structure:
    """Return the structure with one node under another parent; cheap, because rows and joints stay as they are."""
    if any(node.uid == uid for node in structure.ancestors(parent)):
        names = structure.nodes[uid].name, structure.nodes[parent].name
        raise KernelError(
            f"cannot attach {names[0]!r} to {names[1]!r}, which hangs below it", node=names[0], parent=names[1]
        )
    nodes = dict(structure.nodes)
    nodes[uid] = replace(structure.nodes[uid], parent=parent)
    children = dict(structure.children)
    before = structure.nodes[uid].parent
    children[before] = tuple(child for child in children[before] if child != uid)
    if not children[before]:
        del children[before]
    rows, below = structure.rows, tuple(structure.below(uid))
    start = _place(rows[uid], structure.forest.order)
    order = np.delete(structure.forest.order, slice(start, start + len(below)))
    moved = structure.forest.order[start : start + len(below)]
    order = np.insert(order, _place_of(uid, parent, order, rows, children), moved)
    children[parent] = tuple(sorted((*children.get(parent, ()), uid)))
    parents = structure.forest.parent.copy()
    parents[rows[uid]] = rows[parent]
    forest = replace(structure.forest, parent=parents, order=order)
    tools = _tools(nodes, nodes.values()) if any(node.kind is Kind.TOOL for node in below) else structure.tools
    return replace(structure, nodes=nodes, children=children, forest=forest, tools=tools)


def replaced(structure: Structure, node: Node) -> Structure:
    """Return the structure with one node changed in anything but its parent and its data of joints."""
    nodes = {**structure.nodes, node.uid: node}
    return replace(structure, nodes=nodes)


def moved_links(structure: Structure, robot: RobotIndex) -> tuple[int, ...]:
    """Return the links (uids) that the robot's joints move, in the order of these joints."""
    return tuple(uid for uid in robot.links if _has_coordinates(_link_data(structure.nodes[uid]).joint))


def renamed(structure: Structure, node: Node) -> Structure:
    """Return the structure with another name of a node that nothing else names: neither robot nor link."""
    names = {name: uid for name, uid in structure.uid_by_name.items() if uid != node.uid}
    return replace(replaced(structure, node), uid_by_name=_names([node], names))


def _has_coordinates(joint: Joint) -> bool:
    return joint.mimic is None and joint.type is not JointType.FIXED


def _names(nodes: Iterable[Node], taken: Mapping[str, int]) -> dict[str, int]:
    names = dict(taken)
    for node in nodes:
        if not node.name or node.name != node.name.strip() or not node.name.isprintable():
            raise KernelError(
                "a node's name may not be empty, begin or end with a space, or hold signs that cannot be printed; "
                f"this one is {node.name!r}",
                name=node.name,
            )
        if node.name in names:
            raise KernelError(
                f"the name {node.name!r} is taken by another node; choose another one",
                reason=Reason.NAME_TAKEN,
                name=node.name,
            )
        names[node.name] = node.uid
    return names


def _order(
    nodes: Mapping[int, Node], rows: Mapping[int, int], children: Mapping[int, Iterable[int]]
) -> NDArray[np.int32]:
    order, stack = [], [WORLD_UID]
    while stack:
        uid = stack.pop()
        order.append(rows[uid])
        stack.extend(reversed(tuple(children.get(uid, ()))))
    if len(order) != len(nodes):
        lost = next(node for node in nodes.values() if rows[node.uid] not in set(order))
        raise KernelError(f"the node {lost.name!r} hangs on no parent that leads to the world", node=lost.name)
    return np.array(order, np.int32)


def _place_of(
    uid: int,
    parent: int,
    order: NDArray[np.int32],
    rows: Mapping[int, int],
    children: Mapping[int, Sequence[int]],
) -> int:
    """Return the place in `order` of a node that a parent gets: after all below its elder siblings."""
    elder = [sibling for sibling in children.get(parent, ()) if sibling < uid]
    return _end_of(elder[-1], order, rows, children) if elder else _place(rows[parent], order) + 1


def _end_of(uid: int, order: NDArray[np.int32], rows: Mapping[int, int], children: Mapping[int, Sequence[int]]) -> int:
    """Return the place in `order` after a node and all below it."""
    while below := children.get(uid):
        uid = below[-1]
    return _place(rows[uid], order) + 1


def _place(row: int, order: NDArray[np.int32]) -> int:
    return int((order == row).argmax())


def _robots(
    nodes: Mapping[int, Node], children: Mapping[int, Iterable[int]], counts: tuple[int, int]
) -> tuple[dict[int, RobotIndex], tuple[int, int]]:
    """Return the robots among `nodes`, and how many coordinates and velocities there are with them."""
    links = _links_by_robot(nodes)
    robots: dict[int, RobotIndex] = {}
    q, v = counts
    for uid, node in nodes.items():
        if node.kind is not Kind.ROBOT:
            continue
        joints, q_start, v_start = [], [], []
        for joint in _checked_joints(node, [nodes[link] for link in links.get(uid, ())]):
            if not _has_coordinates(joint):
                continue
            joints.append(joint)
            q_start.append(q)
            v_start.append(v)
            q += joint.type.coordinate_count
            v += joint.type.velocity_count
        below = tuple(links.get(uid, ()))
        flange = _flange(node, [nodes[link] for link in below], children)
        robots[uid] = RobotIndex(uid, flange, below, tuple(joints), tuple(q_start), tuple(v_start))
    return robots, (q, v)


def _flange(robot: Node, links: list[Node], children: Mapping[int, Iterable[int]]) -> int:
    """Return the link that tools are mounted on: the named one, or the last before the tree branches into moving parts.

    Without links it is the robot itself.
    """
    named = robot.data.flange if isinstance(robot.data, RobotData) else ""
    if named:
        for link in links:
            if link.name in (named, f"{robot.name}.{named}"):
                return link.uid
        raise UnknownNameError(f"link of {robot.name!r} for its flange", named, (link.name for link in links))
    parents = {link.uid: link.parent for link in links}
    moves = set()
    for link in links:
        at = link.uid
        if _link_data(link).joint.type is not JointType.FIXED:
            while at in parents and at not in moves:
                moves.add(at)
                at = parents[at]
    flange = robot.uid
    while below := [uid for uid in children.get(flange, ()) if uid in parents]:
        candidates = [uid for uid in below if uid in moves] or below
        if len(candidates) > 1:
            break
        flange = candidates[0]
    return flange


def _tools(nodes: Mapping[int, Node], among: Iterable[Node]) -> dict[int, tuple[int, ...]]:
    """Return the tools (uids) among some nodes that are mounted on each robot."""
    tools: dict[int, tuple[int, ...]] = {}
    for node in among:
        if node.kind is Kind.TOOL:
            for robot in robots_of_tool(nodes, node.uid):
                tools[robot] = (*tools.get(robot, ()), node.uid)
    return tools


def _links_by_robot(nodes: Mapping[int, Node]) -> dict[int, list[int]]:
    """Return the links (uids) of each robot; a link's parent is created before it, and never changes."""
    links: dict[int, list[int]] = {}
    owner: dict[int, int] = {}
    for uid, node in nodes.items():
        if node.kind is Kind.ROBOT:
            owner[uid] = uid
        if node.kind is not Kind.LINK:
            continue
        if node.parent not in owner:
            raise KernelError(
                f"the link {node.name!r} hangs on no robot; its parent must be a robot or one of its links",
                node=node.name,
            )
        owner[uid] = owner[node.parent]
        links.setdefault(owner[uid], []).append(uid)
    return links


def _link_data(node: Node) -> LinkData:
    if not isinstance(node.data, LinkData):
        raise KernelError(f"the link {node.name!r} has no joint", node=node.name)
    return node.data


def _checked_joints(robot: Node, links: list[Node]) -> list[Joint]:
    joints = [_link_data(link).joint for link in links]
    by_name: dict[str, Joint] = {}
    for joint in joints:
        if joint.name in by_name and joint.type is not JointType.FIXED:
            raise KernelError(
                f"the robot {robot.name!r} has two joints named {joint.name!r}",
                reason=Reason.NAME_TAKEN,
                robot=robot.name,
                joint=joint.name,
            )
        by_name[joint.name] = joint
    for joint in joints:
        if joint.mimic:
            _mimic_source(robot, joint, by_name)
    return joints


def _mimic_source(robot: Node, joint: Joint, by_name: Mapping[str, Joint]) -> tuple[str, float, float]:
    """Return the joint at the end of a chain of mimics, with multiplier and offset multiplied out."""
    multiplier, offset, seen, at = 1.0, 0.0, [joint.name], joint
    while at.mimic:
        mimic: Mimic = at.mimic
        if mimic.joint in seen:
            raise KernelError(
                f"joints of {robot.name!r} mimic each other in a circle: {' -> '.join([*seen, mimic.joint])}",
                robot=robot.name,
            )
        if mimic.joint not in by_name:
            raise UnknownNameError(f"joint of {robot.name!r} to mimic", mimic.joint, by_name)
        offset += multiplier * mimic.offset
        multiplier *= mimic.multiplier
        at = by_name[mimic.joint]
        seen.append(at.name)
    if at.type not in SINGLE or joint.type not in SINGLE:
        raise KernelError(
            f"the joint {joint.name!r} of {robot.name!r} mimics {at.name!r}; "
            "both must be revolute, continuous or prismatic",
            robot=robot.name,
            joint=joint.name,
        )
    return at.name, multiplier, offset


def _joint_rows(
    nodes: Mapping[int, Node], robots: Mapping[int, RobotIndex]
) -> tuple[NDArray[np.int8], NDArray[np.float64], NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
    """Return joint_type, axis, q_index, multiplier and offset of the forest, a row for each of `nodes`."""
    count = len(nodes)
    rows = {uid: row for row, uid in enumerate(nodes)}
    joint_type = np.zeros(count, np.int8)
    axis = np.tile([1.0, 0.0, 0.0], (count, 1))
    q_index = np.full(count, -1, np.int32)
    multiplier, offset = np.ones(count), np.zeros(count)
    for robot in robots.values():
        start = dict(zip(robot.joint_names, robot.q_start, strict=True))
        joints = {uid: _link_data(nodes[uid]).joint for uid in robot.links}
        by_name = {joint.name: joint for joint in joints.values()}
        for uid, joint in joints.items():
            if joint.type is JointType.FIXED:
                continue
            row = rows[uid]
            joint_type[row] = joint.type.code
            axis[row] = joint.axis
            if joint.mimic:
                source, multiplier[row], offset[row] = _mimic_source(nodes[robot.uid], joint, by_name)
                q_index[row] = start[source]
            else:
                q_index[row] = start[joint.name]
    return joint_type, axis, q_index, multiplier, offset
