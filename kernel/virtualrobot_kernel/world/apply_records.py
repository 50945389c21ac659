"""Command of undo: what a change has changed gets its former values back, where nobody has changed it since."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.affected_robots import robots_of_records
from virtualrobot_kernel.world.apply_nodes import refuse_while_named
from virtualrobot_kernel.world.apply_sensors import with_sensors_running
from virtualrobot_kernel.world.apply_signals import refuse_while_signal_named
from virtualrobot_kernel.world.change import Change, Forward, rebuilt, shortened
from virtualrobot_kernel.world.consistency import (
    check_count,
    check_figures,
    check_names,
    check_robot,
    check_tool_in_use,
    refuse_while_tools_move,
)
from virtualrobot_kernel.world.difference import (
    FIELDS,
    MAPS,
    alike,
    records,
    value,
    with_coordinates,
    with_settings,
    with_values,
)
from virtualrobot_kernel.world.history_commands import RestoreRecords
from virtualrobot_kernel.world.motored import is_dynamic, left
from virtualrobot_kernel.world.records import EVERYWHERE, Key, Presence, Values
from virtualrobot_kernel.world.state import Signal
from virtualrobot_kernel.world.structure import Kind, Node, Structure, ToolData

SAID = {
    "names": "the name of {}",
    "parents": "what {} hangs on",
    "hidden": "whether {} is hidden",
    "figures": "the figures of {}",
    "data": "the settings of {}",
    "about": "what is said of {}",
    "poses": "the pose of {}",
    "signals": "the signal {}",
    "tool_states": "the state of {}",
    "selections": "the tool that {} works with",
    "allowed_pairs": "whether {} may touch",
    "paddings": "the padding of {}",
    "speed_factors": "the speed factor of {}",
    "modes": "the collision mode of {}",
    "look_ahead_seconds": "how far ahead collisions are looked for",
}
"""Words for a value of each table but that of the nodes themselves."""


class Conflict(KernelError):
    """Refusal of an undo: something is not as it was left. `table` and `key` say what; "" where that is not known."""

    reason = Reason.CONFLICT

    def __init__(self, message: str, table: str, key: Key) -> None:
        """Say what stands in the way."""
        super().__init__(message)
        if table:
            self.metadata["aspect"] = table
        self.table, self.key = table, key


def restore_records(change: Change, command: RestoreRecords, forward: Forward) -> Change:
    """Return the world with the restored values, and nothing else changed.

    Raises Conflict, which names what stands in the way, and KernelError while a robot of it moves (ROBOT_BUSY) or a
    program runs that names what would go (WRONG_STATE).
    """
    _refuse_while_moving(change, command)
    for table, key, found in command.found.items():
        _check_found(change, table, key, found, getattr(command.restored, table)[key])
    after = _with_nodes(change, command.restored)
    state = after.state
    for table in MAPS:
        if given := getattr(command.restored, table):
            state = replace(state, **{table: with_values(table, getattr(state, table), given)})
    tables = ("paddings", "speed_factors", "modes", "look_ahead_seconds")
    if settings := {table: given for table in tables if (given := getattr(command.restored, table))}:
        state = with_settings(state, settings)
    after = replace(after, state=state)
    _check_nothing_else(change, after, command)
    _check_consistent(after, command.restored)
    return left(after, [uid for uid in after.state.motored if not is_dynamic(after.structure.nodes[uid])])


def words(structure: Structure, table: str, key: Key, *values: object) -> str:
    """Return what a value is, for people; `values` are some that it has had, for the names of nodes that are gone."""
    if table == "look_ahead_seconds":
        return SAID[table]
    told = next((one.node.name for one in values if isinstance(one, Presence)), "")
    names = [_name(structure, one, told) for one in (key if isinstance(key, tuple) else [key])]
    return SAID.get(table, "{}").format(" and ".join(names))


def _name(structure: Structure, key: int | str, told: str) -> str:
    if isinstance(key, str):
        return repr(key)
    if key == EVERYWHERE:
        return "all robots"
    return repr(structure.nodes[key].name) if key in structure.nodes else repr(told) if told else "a node that is gone"


def _refuse_while_moving(change: Change, command: RestoreRecords) -> None:
    structure, state = change.structure, change.state
    found = set(structure.with_holders(robots_of_records(structure, state, command))) if state.motions else set[int]()
    for motion in state.motions:
        for uid in motion.robots:
            if uid in found:
                name = structure.nodes[uid].name
                raise KernelError(
                    f"the robot {name!r} moves in {motion.id!r}; wait for its end or cancel it",
                    reason=Reason.ROBOT_BUSY,
                    robot=name,
                    motion=motion.id,
                )
    restored = command.restored
    gone = [structure.nodes[uid] for uid, one in restored.nodes.items() if one is None and uid in structure.nodes]
    refuse_while_tools_move(change, gone)
    refuse_while_named(state, (*gone, *(structure.nodes[uid] for uid in restored.names if uid in structure.nodes)))
    for name in (name for name, one in restored.signals.items() if one is None):
        refuse_while_signal_named(state, name)


def _check_found(change: Change, table: str, key: Key, found: object, restored: object) -> None:
    """Raise Conflict unless a value is as it was left."""
    structure = change.structure
    now = value(change, table, key)
    if alike(table, now, found):
        return
    if isinstance(key, int) and table in (*FIELDS, "poses", "nodes") and key not in structure.nodes:
        gone = f"the node {found.node.name!r}" if isinstance(found, Presence) else "a node that it changed"
        raise Conflict(f"{gone} is gone", "nodes", key)
    if isinstance(now, Presence) and isinstance(found, Presence):
        table = _changed_of(now, found)
    if isinstance(now, Presence) and found is None:
        raise Conflict(f"the node {now.node.name!r} is there already", table, key)
    raise Conflict(f"{words(structure, table, key, now, found, restored)} has been changed since", table, key)


def _changed_of(now: Presence, found: Presence) -> str:
    """Return the table of the first field in which a node differs from what it was."""
    for table, name in FIELDS.items():
        if not alike(table, getattr(now.node, name), getattr(found.node, name)):
            return table
    return "poses"


def _with_nodes(change: Change, restored: Values) -> Change:
    """Return the world with other nodes and poses; raise Conflict where they do not fit."""
    structure, state = change.structure, change.state
    changed: dict[int, dict[str, Any]] = {}
    for table, name in FIELDS.items():
        for uid, one in getattr(restored, table).items():
            changed.setdefault(uid, {})[name] = one
    poses = dict(restored.poses)
    gone = restored.nodes.keys()
    simple = len(restored.parents) < 2 and all(
        _is_simple(structure, structure.nodes[uid], given) for uid, given in changed.items()
    )
    if gone and not changed and not poses and not any(restored.nodes.values()) and index.ends_with(structure, gone):
        return shortened(change, gone)  # what was created last goes again
    if restored.nodes or not simple:
        nodes = dict(structure.nodes)
        for uid, given in changed.items():
            nodes[uid] = replace(nodes[uid], **given)
        coming = [one for one in restored.nodes.values() if one is not None]
        for uid in restored.nodes.keys() & nodes.keys():
            del nodes[uid]
        for one in coming:
            nodes[one.node.uid], poses[one.node.uid] = one.node, one.parent_t_node
        _check_tree(structure, nodes, (*changed, *restored.nodes))
        with _inconsistent():
            after = rebuilt(change, nodes, structure.next_uid, poses)
        after = with_coordinates(after, coming)
        return with_sensors_running(after, (one.node.uid for one in coming if one.running), True)
    for uid, given in changed.items():
        parent = given.pop("parent", None)
        if parent is not None:
            structure = index.reparented(structure, uid, parent)
        if given:
            renewed = replace(structure.nodes[uid], **given)
            structure = (index.renamed if "name" in given else index.replaced)(structure, renewed)
    if poses:
        table = state.parent_t_node.copy()
        for uid, pose in poses.items():
            table[structure.rows[uid]] = pose
        state = replace(state, parent_t_node=table)
    return replace(change, structure=structure, state=state)


def _is_simple(structure: Structure, node: Node, given: Mapping[str, Any]) -> bool:
    """Return whether a node can be changed so without building the structure anew."""
    if "name" in given and (node.kind in (Kind.ROBOT, Kind.LINK) or given["name"] in structure.uid_by_name):
        return False
    if "data" in given and node.kind in (Kind.ROBOT, Kind.LINK, Kind.TOOL):
        return False
    if (parent := given.get("parent")) is None:
        return True
    fits = parent in structure.nodes and node.uid not in {above.uid for above in structure.ancestors(parent)}
    return fits and all(one.kind is not Kind.TOOL for one in structure.below(node.uid))


def _check_tree(structure: Structure, nodes: Mapping[int, Node], touched: Iterable[int]) -> None:
    """Raise Conflict unless nodes, of which some were touched, are a tree with names of their own."""
    for uid in touched:
        node = nodes.get(uid)
        if node is None:
            for child in structure.children.get(uid, ()):
                if child in nodes and nodes[child].parent == uid:
                    names = structure.nodes[child].name, structure.nodes[uid].name
                    raise Conflict(f"{names[0]!r} hangs on {names[1]!r}, which would go", "parents", child)
            continue
        other = structure.uid_by_name.get(node.name, uid)
        if other != uid and other in nodes and nodes[other].name == node.name:
            raise Conflict(f"another node has the name {node.name!r}", "names", other)
        if node.parent and node.parent not in nodes:
            raise Conflict(f"what {node.name!r} hung on is gone", "nodes", node.parent)
        above, at = set[int](), node
        while at.parent in nodes and at.uid not in above:
            above.add(at.uid)
            at = nodes[at.parent]
        if at.uid in above:
            names = node.name, nodes[node.parent].name
            raise Conflict(f"{names[1]!r} hangs below {names[0]!r}", "parents", node.parent)


def _check_nothing_else(before: Change, after: Change, command: RestoreRecords) -> None:
    """Raise Conflict when anything else would change: it was set since, by whomever."""
    for table, key, old, new in records(before, after):
        if key not in getattr(command.restored, table):
            raise Conflict(
                f"{words(before.structure, table, key, old, new)} was set since and would be lost", table, key
            )


@contextmanager
def _inconsistent() -> Iterator[None]:
    """Make a conflict of what is wrong with a world; of which change it comes is not known."""
    try:
        yield
    except KernelError as error:
        raise Conflict(str(error), "", EVERYWHERE) from None


def _check_named(structure: Structure, restored: Values) -> None:
    """Raise Conflict when a value would be set for a node that is gone."""
    for table, key, one in restored.items():
        if one is None or table == "nodes":
            continue
        uids = [one.owner] if isinstance(one, Signal) else key if isinstance(key, tuple) else [key]
        for uid in uids:
            if uid != EVERYWHERE and isinstance(uid, int) and uid not in structure.nodes:
                raise Conflict(f"{words(structure, table, key, one)} was set for a node that is gone", "nodes", uid)


def _check_consistent(after: Change, restored: Values) -> None:
    """Raise Conflict unless what has changed names only what is there, and joints are within limits."""
    structure = after.structure
    _check_named(structure, restored)
    uids = {uid for table in ("nodes", *FIELDS) for uid in getattr(restored, table)} & structure.nodes.keys()
    moved = (one for uid in restored.parents for one in structure.below(uid) if one.kind is Kind.TOOL)
    touched = {node.uid: node for node in (*(structure.nodes[uid] for uid in uids), *moved)}
    if restored.names or restored.nodes:
        touched |= {uid: node for uid, node in structure.nodes.items() if node.kind is Kind.TARGET}
    robots = {
        robot.uid
        for node in touched.values()
        if node.kind in (Kind.ROBOT, Kind.LINK, Kind.TOOL) and (robot := structure.robot_of(node.uid))
    }
    with _inconsistent():
        check_count(len(structure.nodes))
        for node in touched.values():
            check_figures(node.name, node.data, node.figures)
            check_names(structure, node)
            if node.kind is Kind.TOOL:
                check_tool_in_use(after, node)
        for robot in robots:
            check_robot(after, robot)
    for robot, selection in restored.selections.items():
        if selection is not None and selection.tool:
            tool = structure.nodes.get(selection.tool) if selection.tool in structure.tools.get(robot, ()) else None
            points = tool.data.tool_center_points if tool and isinstance(tool.data, ToolData) else {}
            if selection.tool_center_point not in points:
                name = structure.nodes[robot].name
                raise Conflict(f"the tool that {name!r} worked with is not there", "nodes", selection.tool)
