"""Difference of two worlds in what undo covers. What is the same object in both is not looked at."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from itertools import compress, filterfalse
from operator import is_not
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.records import EVERYWHERE, Difference, Key, Presence, Values
from virtualrobot_kernel.world.state import Signal, State
from virtualrobot_kernel.world.structure import JointType, LinkData, Node, Structure

FIELDS = {
    **{"names": "name", "parents": "parent", "hidden": "hidden", "figures": "figures", "data": "data"},
    "about": "about",
}
"""Fields of nodes by the table of their values."""

MAPS = ("signals", "tool_states", "selections", "allowed_pairs")
"""Tables that are maps of the state under the same name."""


class Record(NamedTuple):
    """One value before and after a change: the name of its table, what it is of, and the two values."""

    table: str
    key: Key
    old: Any
    new: Any


def difference(before: Change, after: Change) -> Difference:
    """Return the values that differ between two worlds."""
    old: dict[str, dict[Key, Any]] = {}
    new: dict[str, dict[Key, Any]] = {}
    for record in records(before, after):
        old.setdefault(record.table, {})[record.key] = record.old
        new.setdefault(record.table, {})[record.key] = record.new
    return Difference(Values(**old), Values(**new))  # pyright: ignore[reportArgumentType] tables by name


def records(before: Change, after: Change) -> Iterator[Record]:
    """Yield what differs between two worlds, value by value."""
    old, new = before.structure, after.structure
    if old.nodes is not new.nodes:
        for uid in filterfalse(new.nodes.__contains__, old.nodes):
            yield Record("nodes", uid, presence(before, uid), None)
        # Most nodes are the same objects: these are passed over without a turn of this loop.
        others = map(is_not, map(old.nodes.get, new.nodes), new.nodes.values())
        for uid in compress(new.nodes, others):
            if (was := old.nodes.get(uid)) is None:
                yield Record("nodes", uid, None, presence(after, uid))
            else:
                yield from _fields(was, new.nodes[uid])
    yield from _poses(before, after)
    for table in MAPS:
        yield from _entries(table, getattr(before.state, table), getattr(after.state, table))
    if any(getattr(before.state, one) is not getattr(after.state, one) for one in SETTINGS):
        for table, settings in settings_of(before.state).items():
            yield from _entries(table, settings, settings_of(after.state)[table])


def value(change: Change, table: str, key: Any) -> Any:  # noqa: ANN401 what the table holds
    """Return a value of the world as it is; None where what it is of is not there."""
    structure, state = change.structure, change.state
    if table == "poses":
        return state.parent_t_node[structure.rows[key]] if key in structure.rows else None
    if table == "nodes":
        return presence(change, key) if key in structure.nodes else None
    if table in FIELDS:
        return getattr(structure.nodes[key], FIELDS[table]) if key in structure.nodes else None
    return (getattr(state, table) if table in MAPS else settings_of(state)[table]).get(key)


def alike(table: str, one: Any, other: Any) -> bool:  # noqa: ANN401 what the table holds
    """Return whether two values of a table are the same to undo: bit for bit, but for what it doesn't cover.

    That are the values of signals, the states that tools are in, where joints are and whether sensors run.
    """
    if one is None or other is None:
        return one is other
    if table == "tool_states":
        return True
    if table == "signals":
        return type(one.value) is type(other.value) and _declared(one) == _declared(other)
    if table == "nodes":
        return same(one.node, other.node) and same(one.parent_t_node, other.parent_t_node)
    return same(one, other)


def same(one: Any, other: Any) -> bool:  # noqa: ANN401 any values of the world
    """Return whether two values are equal bit for bit: -0.0 is not 0.0, and NaN is NaN."""
    if one is other:
        return True
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, float) and isinstance(other, float):
        return np.float64(one).tobytes() == np.float64(other).tobytes()
    if type(one) is not type(other):
        return isinstance(one, Mapping) and isinstance(other, Mapping) and _same_maps(one, other)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, Mapping):
        return _same_maps(one, other)
    if is_dataclass(one):
        return all(same(getattr(one, each.name), getattr(other, each.name)) for each in fields(one) if each.init)
    return bool(one == other)


SETTINGS = ("speed_factors", "speed_factor", "collisions")
"""Fields of the state that `settings_of` reads."""


def settings_of(state: State) -> dict[str, dict[int, Any]]:
    """Return the settings of robots and nodes by table and uid; those of all robots are at `EVERYWHERE`."""
    collisions = state.collisions
    return {
        "paddings": {**collisions.paddings},
        "speed_factors": {EVERYWHERE: state.speed_factor, **state.speed_factors},
        "modes": {EVERYWHERE: collisions.mode, **collisions.modes},
        "look_ahead_seconds": {EVERYWHERE: collisions.look_ahead_seconds},
    }


def with_settings(state: State, values: Mapping[str, Mapping[Any, Any]]) -> State:
    """Return a state with other settings: some of the tables of `settings_of`, None for what is not set any more."""
    before = settings_of(state)
    tables = {name: _changed(before[name], given) for name, given in values.items()}
    changes: dict[str, Any] = {}
    if "speed_factors" in tables:
        speeds = tables["speed_factors"]
        changes |= {"speed_factor": speeds.pop(EVERYWHERE), "speed_factors": speeds}
    # What doesn't change stays the same object: collision scenes look whether it is.
    collisions: dict[str, Any] = {}
    if "modes" in tables:
        modes = tables["modes"]
        collisions |= {"mode": modes.pop(EVERYWHERE), "modes": modes}
    if "look_ahead_seconds" in tables:
        collisions["look_ahead_seconds"] = tables["look_ahead_seconds"][EVERYWHERE]
    if "paddings" in tables:
        collisions["paddings"] = tables["paddings"]
    if collisions:
        changes["collisions"] = replace(state.collisions, **collisions)
    return replace(state, **changes)


def with_values(table: str, now: Mapping[Any, Any], values: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return a map of the state with some of its values; what undo doesn't cover of them stays as it is."""
    return _changed(now, {key: _kept(table, one, now.get(key)) for key, one in values.items()})


def presence(change: Change, uid: int) -> Presence:
    """Return a node with all that comes and goes with it."""
    structure, state = change.structure, change.state
    node = structure.nodes[uid]
    # Copies: a view would keep the poses of all nodes as long as a step is remembered.
    pose, q = state.parent_t_node[structure.rows[uid]].copy(), state.q[_coordinates(structure, node)].copy()
    return Presence(node, pose, q, uid in state.running_sensors)


def _coordinates(structure: Structure, node: Node) -> slice:
    """Return the places in q of the joint before a link, none for other nodes and for joints that follow others."""
    data = node.data
    if not isinstance(data, LinkData) or data.joint.mimic or data.joint.type is JointType.FIXED:
        return slice(0, 0)
    at = structure.coordinates_at(structure.rows[node.uid])
    return slice(at.start, at.stop)


def with_coordinates(change: Change, nodes: Iterable[Presence]) -> Change:
    """Return the world with the joints of some links where they were."""
    q = change.state.q.copy()
    for one in nodes:
        q[_coordinates(change.structure, one.node)] = one.q
    return replace(change, state=replace(change.state, q=q))


def _fields(was: Node, node: Node) -> Iterator[Record]:
    for table, name in FIELDS.items():
        old, new = getattr(was, name), getattr(node, name)
        if not same(old, new):
            yield Record(table, node.uid, old, new)


def _poses(before: Change, after: Change) -> Iterator[Record]:
    old, new = before.state.parent_t_node, after.state.parent_t_node
    rows, later = before.structure.rows, after.structure.rows
    if old is new and rows is later:
        return
    uids = list(rows)
    if rows is not later:
        now = list(later)
        few = min(len(uids), len(now))
        if uids[:few] == now[:few]:  # nodes came or went at the end alone
            uids, old, new = uids[:few], old[:few], new[:few]
        else:
            uids = [uid for uid in now if uid in rows]
            old, new = old[[rows[uid] for uid in uids]], new[[later[uid] for uid in uids]]
    for at in np.unique(np.flatnonzero(_bits(old) != _bits(new)) // 16).tolist():
        yield Record("poses", uids[at], old[at].copy(), new[at].copy())


def _bits(poses: NDArray[np.float64]) -> NDArray[np.uint64]:
    """Return the bits of poses (n, 4, 4) one after another, (16 n,)."""
    return np.ascontiguousarray(poses).view(np.uint64).reshape(-1)


def _entries(table: str, old: Mapping[Any, Any], new: Mapping[Any, Any]) -> Iterator[Record]:
    if old is new:
        return
    for key in dict.fromkeys((*old, *new)):
        one, other = old.get(key), new.get(key)
        if not alike(table, one, other):
            yield Record(table, key, one, other)


def _declared(signal: Signal) -> tuple[object, ...]:
    return signal.name, signal.description, signal.unit, signal.direction, signal.owner


def _kept(table: str, value: Any, now: Any) -> Any:  # noqa: ANN401 what the table holds
    if value is None or now is None:
        return value
    if table == "signals" and type(value.value) is type(now.value):
        return replace(value, value=now.value)
    return now if table == "tool_states" else value


def _changed(now: Mapping[Any, Any], values: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return a map with other values, without those that are None."""
    return {key: value for key, value in {**now, **values}.items() if value is not None}


def _same_maps(one: Mapping[Any, Any], other: Mapping[Any, Any]) -> bool:
    return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
