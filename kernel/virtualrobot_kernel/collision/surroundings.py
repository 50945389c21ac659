"""Surroundings of a motion: what a check of it uses of the world, and what of that has changed. Pure."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from virtualrobot_kernel.collision.allowed import allowed_pairs
from virtualrobot_kernel.collision.bodies import collision_figures
from virtualrobot_kernel.world.change import joint_places
from virtualrobot_kernel.world.difference import same
from virtualrobot_kernel.world.preconditions import TOLERANCE
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import LinkData


class Aspect(Enum):
    """Property of a node that a check uses; the value tells it to people."""

    SHAPE = "its shape"
    PARENT = "what it hangs on"
    PLACE = "where it is fixed on its parent"
    JOINT = "its joint"
    POSITION = "where its joint stands"
    PADDING = "by how much it counts as thicker"
    ALLOWED = "what it may touch"
    LOAD = "its mass, or where that is"


class Difference(NamedTuple):
    """Node that is not what it was: its name, which property, and the words for people."""

    node: str
    aspect: str
    words: str


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """World around a motion as it was when that was checked.

    Attributes:
        seen: the world in which that was so.
        joints: what the motion moves, as (robot uid, joint name): where these are is its own matter.
        facts: the values of the nodes (uids) that can collide, of all that carries them, and of loads.
    """

    seen: Snapshot
    joints: tuple[tuple[int, str], ...]
    facts: Mapping[tuple[int, Aspect], Any]

    def differences(self, now: Snapshot) -> list[Difference]:
        """Return what is not as it was, in the order of the nodes: what is gone, what has changed, what is new.

        Where things are that move now doesn't count: a moment later that is another place, and the guard looks at it.
        """
        if _unchanged(self.seen, now, _own_places(now, self.joints)):
            return []
        facts, found, moving = facts_of(now, self.joints), [], _moving(now)
        told: set[int] = set()
        for (uid, aspect), value in self.facts.items():
            if uid not in now.structure.nodes:
                if uid not in told:
                    name = self.seen.structure.nodes[uid].name
                    found.append(Difference(name, "NODE", f"{name!r} was removed"))
                told.add(uid)
            elif (uid, aspect) not in moving and not _alike(aspect, value, facts.get((uid, aspect))):
                found.append(_changed(now, uid, aspect))
        told.update(uid for uid, _ in self.facts)
        for uid, aspect in facts:
            if uid not in self.seen.structure.nodes:
                if uid not in told:
                    name = now.structure.nodes[uid].name
                    found.append(Difference(name, "NODE", f"{name!r} is new"))
                told.add(uid)
            elif (uid, aspect) not in self.facts:
                found.append(_changed(now, uid, aspect))
        return found


def surroundings_of(snapshot: Snapshot, joints: Collection[tuple[int, str]]) -> Surroundings:
    """Return what stands around a motion of some joints (robot uid, name)."""
    return Surroundings(snapshot, tuple(joints), facts_of(snapshot, joints))


def facts_of(snapshot: Snapshot, joints: Collection[tuple[int, str]]) -> dict[tuple[int, Aspect], Any]:
    """Return what a check of a motion of some joints (robot uid, name) uses, by node (uid) and aspect.

    Of what can collide the figures, how thick it counts and what it may touch; of that and of all that carries it, on
    what it hangs and where, its joint, and where that stands unless the motion moves it. Of what the robots carry,
    their own links included, the mass.
    """
    structure, state = snapshot.structure, snapshot.state
    own = _own_places(snapshot, joints)
    figures: dict[int, list[Any]] = {}
    for uid, figure in collision_figures(snapshot):
        figures.setdefault(uid, []).append((figure.geometry, figure.node_t_figure))
    allowed: dict[int, set[int]] = {}
    for pair in allowed_pairs(structure, state.allowed_pairs).pairs:
        for uid, other in (pair, pair[::-1]):
            if other in figures:
                allowed.setdefault(uid, set()).add(other)
    facts: dict[tuple[int, Aspect], Any] = {}
    carriers: dict[int, None] = {}
    for uid, shapes in figures.items():
        facts[uid, Aspect.SHAPE] = tuple(shapes)
        facts[uid, Aspect.PADDING] = state.collisions.paddings.get(uid, 0.0)
        facts[uid, Aspect.ALLOWED] = tuple(sorted(allowed.get(uid, ())))
        carriers |= dict.fromkeys(node.uid for node in structure.ancestors(uid))
    for uid in carriers:
        node, row = structure.nodes[uid], structure.rows[uid]
        facts[uid, Aspect.PARENT] = node.parent
        facts[uid, Aspect.PLACE] = state.parent_t_node[row]
        if node.is_moved and isinstance(node.data, LinkData):
            joint = node.data.joint
            facts[uid, Aspect.JOINT] = (joint.type, joint.axis, joint.mimic)
            places = structure.coordinates_at(row)
            if own.isdisjoint(places):
                facts[uid, Aspect.POSITION] = state.q[places.start : places.stop]
    for robot in dict.fromkeys(uid for uid, _ in joints if uid in structure.nodes):
        for node in structure.below(robot):
            if (inertial := getattr(node.data, "inertial", None)) is not None:
                facts[node.uid, Aspect.LOAD] = inertial
            elif mass := getattr(node.data, "mass", 0.0):
                facts[node.uid, Aspect.LOAD] = mass
    return facts


def _moving(now: Snapshot) -> set[tuple[int, Aspect]]:
    """Return where which nodes are is on the move: joints that have a velocity, and parts that forces move."""
    structure, state = now.structure, now.state
    places = {
        one.q
        for robot in structure.robots.values()
        for one in robot.coordinates.values()
        if one.v >= 0 and state.v[one.v]
    }
    joints = (uid for uid, row in structure.rows.items() if not places.isdisjoint(structure.coordinates_at(row)))
    return {(uid, Aspect.POSITION) for uid in joints} | {(uid, Aspect.PLACE) for uid in state.twists}


def _own_places(snapshot: Snapshot, joints: Collection[tuple[int, str]]) -> set[int]:
    """Return the places in q of those joints that there are."""
    robots = snapshot.structure.robots
    there = [(uid, name) for uid, name in joints if uid in robots and name in robots[uid].coordinates]
    return set(joint_places(snapshot.structure, there)[0].tolist())


def _unchanged(seen: Snapshot, now: Snapshot, own: set[int]) -> bool:
    """Return whether nothing was touched of all that counts, which is what a start finds as a rule."""
    then, state = seen.state, now.state
    if seen.structure is not now.structure or then.parent_t_node is not state.parent_t_node:
        return False
    if then.tool_states is not state.tool_states or then.allowed_pairs is not state.allowed_pairs:
        return False
    if then.collisions is not state.collisions:
        return False
    moved = np.flatnonzero(np.abs(state.q - then.q) > TOLERANCE)
    return own.issuperset(moved.tolist())


def _alike(aspect: Aspect, then: Any, now: Any) -> bool:  # noqa: ANN401 what the aspect is of
    if aspect in (Aspect.PLACE, Aspect.POSITION) and then is not None and now is not None:
        return np.shape(then) == np.shape(now) and bool((np.abs(then - now) <= TOLERANCE).all())
    return same(then, now)


def _changed(now: Snapshot, uid: int, aspect: Aspect) -> Difference:
    name = now.structure.nodes[uid].name
    return Difference(name, aspect.name, f"{aspect.value} has changed of {name!r}")
