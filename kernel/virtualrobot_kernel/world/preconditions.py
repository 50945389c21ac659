"""Preconditions of a plan: facts about the world, read when it is planned and again when it starts. Pure.

A plan that was made a moment ago is right only while the arm, its tool and the frames of its goals are what they were.
Other changes, such as another robot's joints, a signal or a new name, don't make it wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.actuators import coupled_joints
from virtualrobot_kernel.world.change import joint_places
from virtualrobot_kernel.world.groups import WHOLE, Group, chain_links
from virtualrobot_kernel.world.index import moved_links
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import LinkData, Node, RobotData, Structure, ToolData
from virtualrobot_kernel.world.tcp import chosen_tcp

TOLERANCE = 1e-6
"""Greatest change of a joint that carries an arm or a goal since the plan was made, in radians or meters."""


Key = str | Group


class Aspect(Enum):
    """Property of a node that a plan looked at; the value tells it to people."""

    PARENT = "what it hangs on"
    PLACE = "where it is fixed on its parent"
    JOINT = "its joint or its joint's limits"
    POSITION = "where its joint stands"
    FLANGE = "its flange"
    TOOL = "its chosen tool or tool centre point"
    ACTUATORS = "its actuators"
    POSTURE = "its posture"
    STATE = "its state"
    WIDTHS = "its table of widths"
    TCP_SPEED = "the speed limit of its tool centre point"


@dataclass(frozen=True, slots=True, eq=False)
class Precondition:
    """Fact about a node at planning: the aspect that counts (of POSTURE and STATE the one called `key`), and its value.

    `name` is what the node was called then. Of FLANGE and TOOL the key is the group whose chain is meant.
    """

    uid: int
    name: str
    aspect: Aspect
    key: Key
    value: object


Preconditions = tuple[Precondition, ...]


@dataclass(frozen=True, slots=True)
class TcpPath:
    """Tool centre point on its way: that of a robot (a uid), and the nodes (uids) in whose frames its goals are.

    Without such nodes it goes by the frame of the chain's base. The chain is that of a group of the robot.
    """

    robot: int
    references: tuple[int, ...]
    group: Group = WHOLE


def preconditions_of(
    structure: Structure,
    state: State,
    joints: Iterable[tuple[int, str]],
    ways: Sequence[TcpPath] = (),
    postures: Iterable[tuple[int, str]] = (),
    tool_states: Iterable[tuple[int, str]] = (),
) -> Preconditions:
    """Return the preconditions of a plan that was made in this world.

    Args:
        structure: the world's structure when it was planned.
        state: its state then.
        joints: what the plan moves, as (robot uid, joint name). Where these joints start is the plan's own matter.
        ways: whose tool centre points it leads, and in which frames.
        postures: (robot uid, name) of its goals.
        tool_states: (tool uid, name) of its goals; the name is empty for a width.
    """
    joints = tuple(dict.fromkeys(joints))
    wanted: dict[tuple[int, Aspect, Key], None] = {}
    for uid, name in joints:
        robot = structure.robots[uid]
        wanted[moved_links(structure, robot)[robot.coordinates[name].place], Aspect.JOINT, ""] = None
    wanted |= dict.fromkeys((uid, Aspect.ACTUATORS, "") for uid, _ in joints)
    wanted |= dict.fromkeys((uid, Aspect.TCP_SPEED, "") for uid, _ in joints)
    # Where the others are that an actuator moves with them decides how far it may go.
    for uid, name in sorted(coupled_joints(structure, joints) - set(joints)):
        robot = structure.robots[uid]
        wanted[moved_links(structure, robot)[robot.coordinates[name].place], Aspect.POSITION, ""] = None
    moving = {int(place) for motion in state.motions for place in motion.q_index}
    moving |= {int(place) for place in joint_places(structure, joints)[0]}
    for way in ways:
        wanted[way.robot, Aspect.FLANGE, way.group] = wanted[way.robot, Aspect.TOOL, way.group] = None
        base, tip = _ends(structure, structure.nodes[way.robot], way.group)
        tool, _ = chosen_tcp(structure, state, structure.nodes[way.robot], 0 if way.group == WHOLE else tip)
        above = {node.uid for node in structure.ancestors(tool.uid if tool else tip)}
        for reference in way.references or (base,):
            # What carries both the arm and its goal may be moved with both.
            for uid in sorted(above ^ {node.uid for node in structure.ancestors(reference)}):
                wanted[uid, Aspect.PARENT, ""] = wanted[uid, Aspect.PLACE, ""] = None
                if structure.nodes[uid].is_moved:
                    wanted[uid, Aspect.JOINT, ""] = None
                    if moving.isdisjoint(structure.coordinates_at(structure.rows[uid])):
                        wanted[uid, Aspect.POSITION, ""] = None
    wanted |= dict.fromkeys((uid, Aspect.POSTURE, name) for uid, name in postures)
    wanted |= dict.fromkeys((uid, Aspect.STATE if name else Aspect.WIDTHS, name) for uid, name in tool_states)
    facts = ((structure.nodes[uid], aspect, key) for uid, aspect, key in wanted)
    return tuple(
        Precondition(node.uid, node.name, aspect, key, READERS[aspect](structure, state, node, key))
        for node, aspect, key in facts
    )


def holds(fact: Precondition, structure: Structure, state: State) -> bool:
    """Return whether a node is what a fact says of it."""
    node = structure.nodes.get(fact.uid)
    return node is not None and _same(fact.aspect, READERS[fact.aspect](structure, state, node, fact.key), fact.value)


def check(preconditions: Preconditions, structure: Structure, state: State) -> None:
    """Raise KernelError (PLAN_OUTDATED) that names the first node that is no more what the plan assumes."""
    for fact, name, what in broken(preconditions, structure, state):
        raise KernelError(
            f"{name!r} is not what the motion was planned with: {what}; plan again",
            reason=Reason.PLAN_OUTDATED,
            node=name,
            aspect=fact.aspect.name,
        )


def broken(preconditions: Preconditions, structure: Structure, state: State) -> Iterator[tuple[Precondition, str, str]]:
    """Yield each fact that is so no more, what its node is called, and what has become of it in words."""
    for fact in preconditions:
        node = structure.nodes.get(fact.uid)
        if node is None:
            yield fact, fact.name, "it was removed"
        elif not holds(fact, structure, state):
            what = f"{fact.aspect.value} {fact.key!r}" if fact.key and isinstance(fact.key, str) else fact.aspect.value
            yield fact, node.name, f"{what} has changed"


def _same(aspect: Aspect, now: object, then: object) -> bool:
    if aspect is Aspect.POSITION:
        assert isinstance(now, np.ndarray) and isinstance(then, np.ndarray)
        return now.shape == then.shape and bool((np.abs(now - then) <= TOLERANCE).all())
    return now == then


def _joint(structure: Structure, state: State, node: Node, key: Key) -> object:
    return node.data.joint if isinstance(node.data, LinkData) else None


def _position(structure: Structure, state: State, node: Node, key: Key) -> object:
    assert isinstance(node.data, LinkData)
    start = int(structure.forest.q_index[structure.rows[node.uid]])
    return state.q[start : start + node.data.joint.type.coordinate_count]


def _ends(structure: Structure, node: Node, group: Group) -> tuple[int, int]:
    """Return base and tip (uids) of a group's chain; of the whole robot itself and its flange."""
    if group == WHOLE:
        return node.uid, structure.robots[node.uid].flange
    base, links = chain_links(structure, node, group)
    return base, links[0] if links else base


def _flange(structure: Structure, state: State, node: Node, key: Key) -> object:
    assert isinstance(key, Group)
    try:
        return _ends(structure, node, key)
    except KernelError:
        return None  # the group is gone


def _tool(structure: Structure, state: State, node: Node, key: Key) -> object:
    ends = _flange(structure, state, node, key)
    tip = ends[1] if isinstance(ends, tuple) and key != WHOLE else 0
    tool, point = chosen_tcp(structure, state, node, tip)
    return tool.uid if tool else 0, point.tolist()


def _actuators(structure: Structure, state: State, node: Node, key: Key) -> object:
    return node.data.actuators if isinstance(node.data, RobotData) else ()


def _posture(structure: Structure, state: State, node: Node, key: Key) -> object:
    return node.data.postures.get(str(key)) if isinstance(node.data, RobotData) else None


def _state(structure: Structure, state: State, node: Node, key: Key) -> object:
    return node.data.states.get(str(key)) if isinstance(node.data, ToolData) else None


READERS: dict[Aspect, Callable[[Structure, State, Node, Key], object]] = {
    Aspect.PARENT: lambda structure, state, node, key: node.parent,
    Aspect.PLACE: lambda structure, state, node, key: state.parent_t_node[structure.rows[node.uid]].tolist(),
    Aspect.JOINT: _joint,
    Aspect.POSITION: _position,
    Aspect.FLANGE: _flange,
    Aspect.TOOL: _tool,
    Aspect.ACTUATORS: _actuators,
    Aspect.POSTURE: _posture,
    Aspect.STATE: _state,
    Aspect.TCP_SPEED: lambda structure, state, node, key: state.tcp_speed_limits.get(node.uid, 0.0),
    Aspect.WIDTHS: lambda structure, state, node, key: node.data.widths if isinstance(node.data, ToolData) else (),
}
"""Reader of each aspect of a node: equal values mean that it is as it was."""
