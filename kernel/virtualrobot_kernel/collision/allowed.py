"""Pairs of nodes that may touch, and why: by how they hang together, by robots' files, by clients and imports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum

from virtualrobot_kernel.world.apply_collisions import node_pair
from virtualrobot_kernel.world.collisions import Allowance
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import (
    WORLD_UID,
    Kind,
    LinkData,
    Node,
    RobotData,
    Structure,
    ToolData,
)


class Cause(Enum):
    """Cause for which two nodes may touch; the names equal those of `AllowedCause` in the contract."""

    RIGID = "rigid"
    ADJACENT = "adjacent"
    MOUNTED = "mounted"
    HELD = "held"
    FILE = "file"
    CLIENT = "client"
    BUILT = "built"


Pair = tuple[int, int]
"""Two nodes (uids), the smaller first."""


@dataclass(frozen=True, slots=True, eq=False)
class AllowedPairs:
    """Pairs that may touch in a structure.

    Attributes:
        groups: of each node (uid) the robot that it belongs to (uid; 0: none): its links, adapters and tools, and what
            hangs below them.
        bodies: of each node (uid) the node that its rigid body begins with: no joint is between these two.
        pairs: the pairs that may touch and are not of one body that a joint moves or one group, and why in words.
    """

    groups: Mapping[int, int]
    bodies: Mapping[int, int]
    pairs: Mapping[Pair, tuple[Cause, str]]

    def why(self, one: int, other: int) -> tuple[Cause, str] | None:
        """Return why two nodes may touch, None when they may not."""
        group, body = self.groups[one], self.bodies[one]
        if one == other or (group and group == self.groups[other] and body == self.bodies[other]):
            return Cause.RIGID, ""
        if body == self.bodies[other] != WORLD_UID:
            return Cause.MOUNTED, ""
        return self.pairs.get(ordered(one, other))


def ordered(one: int, other: int) -> Pair:
    """Return two nodes (uids) as a pair."""
    return (one, other) if one < other else (other, one)


def may_touch(snapshot: Snapshot, pairs: Iterable[tuple[str, str]]) -> Snapshot:
    """Return the world in which these pairs of nodes may touch, too.

    Raises UnknownNameError for a node that there is not, and KernelError for a pair of one node.
    """
    allowed = {node_pair(snapshot.structure, *pair): Allowance("it is asked so") for pair in pairs}
    state = replace(snapshot.state, allowed_pairs={**snapshot.state.allowed_pairs, **allowed})
    return replace(snapshot, state=state) if allowed else snapshot


def allowed_pairs(structure: Structure, by_clients: Mapping[Pair, Allowance]) -> AllowedPairs:
    """Return which nodes of a structure may touch.

    Nodes of a robot that no joint moves against each other may (RIGID), and so may links on both sides of a joint, over
    links without figures too (ADJACENT); what a robot begins with and what it stands on, and all that is fixed to one
    link that a joint moves (MOUNTED); a part and what holds it: the tool, what the tool's states move, and what hangs
    on these (HELD); links that the robot's files name (FILE); and pairs that clients have set (CLIENT) or imports have
    found to touch as a model is built (BUILT).

    Args:
        structure: the world's nodes.
        by_clients: pairs that clients have set or imports have found, and why.
    """
    groups, bodies = _groups_and_bodies(structure)
    pairs: dict[Pair, tuple[Cause, str]] = {}
    tools = {uid for mounted in structure.tools.values() for uid in mounted}
    fingers = {uid: _fingers(structure, uid) for uid in tools}
    for node in structure.nodes.values():
        if node.kind is Kind.ROBOT:
            pairs.update((ordered(*pair), (Cause.MOUNTED, "")) for pair in _mounted(structure, node, groups, bodies))
            pairs.update(_by_file(structure, node))
        elif node.kind is Kind.LINK:
            above = _adjacent(structure, node)
            if above is not None:
                pairs[ordered(node.uid, above)] = (Cause.ADJACENT, "")
        elif node.kind is Kind.PART:
            tool = next((one for one in structure.ancestors(node.uid) if one.kind is Kind.TOOL), None)
            if tool is not None:
                pairs.update((ordered(node.uid, finger), (Cause.HELD, "")) for finger in fingers.get(tool.uid, ()))
    for pair, one in by_clients.items():
        pairs[pair] = Cause.BUILT if one.built else Cause.CLIENT, one.reason
    return AllowedPairs(groups, bodies, pairs)


def _groups_and_bodies(structure: Structure) -> tuple[dict[int, int], dict[int, int]]:
    uids = tuple(structure.nodes)
    groups, bodies = {0: 0}, {0: 0}
    for row in structure.forest.order.tolist():
        node = structure.nodes[uids[row]]
        groups[node.uid] = node.uid if node.kind is Kind.ROBOT else groups[node.parent]
        bodies[node.uid] = node.uid if node.is_moved or not node.parent else bodies[node.parent]
    return groups, bodies


def _adjacent(structure: Structure, link: Node) -> int | None:
    """Return the next node with figures above a moving link, when no other moving link is between; else None."""
    crossed = False
    below = link
    while True:
        if below.is_moved:
            if crossed:
                return None
            crossed = True
        if below.kind is Kind.ROBOT:
            return None
        below = structure.nodes[below.parent]
        if any(figure.collision for figure in below.figures):
            return below.uid if crossed and below.kind in (Kind.LINK, Kind.ROBOT, Kind.ADAPTER) else None


def _mounted(
    structure: Structure, robot: Node, groups: Mapping[int, int], bodies: Mapping[int, int]
) -> Iterator[tuple[int, int]]:
    """Yield each pair of what a robot begins with and what it stands on; what stands in the world stands on nothing."""
    if robot.parent == WORLD_UID:
        return
    base = [robot.uid, *(uid for uid in structure.robots[robot.uid].links if bodies[uid] == bodies[robot.uid])]
    for stand in structure.ancestors(robot.parent):
        if stand.uid == WORLD_UID or bodies[stand.uid] != bodies[robot.uid]:
            return
        yield from ((uid, stand.uid) for uid in base)


def _by_file(structure: Structure, robot: Node) -> Iterator[tuple[Pair, tuple[Cause, str]]]:
    if not isinstance(robot.data, RobotData):
        return
    links = {structure.nodes[uid].name.removeprefix(f"{robot.name}."): uid for uid in structure.robots[robot.uid].links}
    for pair in robot.data.allowed_collisions:
        yield ordered(links[pair.first], links[pair.second]), (Cause.FILE, pair.reason)


def _fingers(structure: Structure, tool: int) -> set[int]:
    """Return the nodes of a tool: itself, what its states move, and what hangs on these but parts and robots."""
    node, robot = structure.nodes[tool], structure.robot_of(tool)
    found = {tool}
    if robot is not None and isinstance(node.data, ToolData):
        moved = {joint for positions in node.data.states.values() for joint in positions}
        for uid in structure.robots[robot.uid].links:
            data = structure.nodes[uid].data
            assert isinstance(data, LinkData)
            joint = data.joint
            if joint.name in moved or (joint.mimic is not None and joint.mimic.joint in moved):
                found.add(uid)
    return {one for top in tuple(found) for one in _own(structure, top)}


def _own(structure: Structure, top: int) -> Iterable[int]:
    waiting = [top]
    while waiting:
        uid = waiting.pop()
        yield uid
        below = (structure.nodes[child] for child in structure.children.get(uid, ()))
        waiting.extend(node.uid for node in below if node.kind not in (Kind.PART, Kind.ROBOT))
