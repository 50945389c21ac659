"""The reader of contact sensors: what is near the watched node or touches it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.pairs import Pair, near_pairs
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.collision.touching import spread
from virtualrobot_kernel.sensing.contact_content import Contact, ContactContent
from virtualrobot_kernel.sensing.contact_sides import ContactSide, contact_sides
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.world.sensing import ContactSensor
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node, Structure

DEADLINE_SECONDS = 10.0
"""Solids of meshes that are new are made within a reading."""


@dataclass(frozen=True, slots=True, eq=False)
class _Sides:
    """The watched figures and the others, and the structure and tool states that they were made of."""

    made_of: tuple[Structure, Mapping[int, str]]
    felt: tuple[ContactSide, ContactSide]
    placed: tuple[Placed, Placed]


class ContactReader:
    """Reads one contact sensor; used by one thread, which owns its collision objects."""

    history_seconds = 0.0
    deadline_seconds = DEADLINE_SECONDS
    takes_turns = True

    def __init__(self, snapshot: Snapshot, node: Node, shapes: CollisionShapes) -> None:
        """Read the sensor `node`; raises UnknownNameError when it names a node that there is not."""
        assert isinstance(node.data, ContactSensor)
        self._uid, self._settings, self._shapes = node.uid, node.data, shapes
        self._sides = self._made(snapshot, None)

    def read(self, moment: Moment, kinds: object | None = None) -> ContactContent:
        """Return what the sensor says; raises UnknownNameError when a node that it names is gone."""
        snapshot = moment.snapshot
        made_of = self._sides.made_of
        if made_of[0] is not snapshot.structure or made_of[1] is not snapshot.state.tool_states:
            self._sides = self._made(snapshot, self._sides)
        for felt, placed in zip(self._sides.felt, self._sides.placed, strict=True):
            placed.move(felt.world_t_element(snapshot.world_t_node))
        pairs = near_pairs(*self._sides.placed, self._settings.range_meters)
        region = _Region(snapshot.world_t(self._uid), self._settings.region_size)
        touched = _under_physics(snapshot, self._sides.felt, region)
        ours, theirs = self._sides.felt
        pairs = [pair for pair in pairs if (ours.uids[pair.first], theirs.uids[pair.second]) not in touched]
        contacts = [contact for pair in pairs for contact in self._contacts(snapshot.structure, pair, region)]
        return ContactContent((*(contact for found in touched.values() for contact in found), *contacts))

    def close(self) -> None:
        """Nothing was started."""

    def _made(self, snapshot: Snapshot, before: _Sides | None) -> _Sides:
        structure, tool_states = snapshot.structure, snapshot.state.tool_states
        felt = contact_sides(structure, tool_states, structure.nodes[self._uid], self._settings, self._shapes)
        ours, theirs = (
            Placed(side.solids, side.world_t_element(snapshot.world_t_node), old)
            for side, old in zip(felt, before.placed if before else (None, None), strict=True)
        )
        return _Sides((structure, tool_states), felt, (ours, theirs))

    def _contacts(self, structure: Structure, pair: Pair, region: _Region) -> Iterator[Contact]:
        ours, theirs = self._sides.felt
        element, other = (structure.nodes[uid].name for uid in (ours.uids[pair.first], theirs.uids[pair.second]))
        if pair.normal is None:
            if region.holds(pair.points[:1]).all():
                yield Contact(element, other, pair.distance, pair.points[0], pair.points[1], None)
            return
        points = pair.contacts[region.holds(pair.contacts)]
        yield from (Contact(element, other, 0.0, point, point, pair.normal) for point in points[spread(len(points))])


def _under_physics(
    snapshot: Snapshot, felt: tuple[ContactSide, ContactSide], region: _Region
) -> Mapping[tuple[int, int], Sequence[Contact]]:
    """Return what touches under physics, by watched and other node (uids): the engine's points and their forces."""
    found: dict[tuple[int, int], list[Contact]] = {}
    if (told := snapshot.state.contacts) is None:
        return found
    ours, theirs = ({*side.uids} for side in felt)
    nodes, inside = snapshot.structure.nodes, region.holds(told.positions)
    for row, (first, second) in enumerate(told.nodes.tolist()):
        for ours_uid, theirs_uid, sign in ((first, second, 1.0), (second, first, -1.0)):
            if ours_uid not in ours or theirs_uid not in theirs:
                continue
            contacts = found.setdefault((ours_uid, theirs_uid), [])
            if inside[row]:
                names, point = (nodes[ours_uid].name, nodes[theirs_uid].name), told.positions[row]
                contacts.append(Contact(*names, 0.0, point, point, sign * told.normals[row], -sign * told.forces[row]))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Region:
    """A box about a frame with edges along it; without a size it is everywhere."""

    world_t_sensor: NDArray[np.float64]
    size: tuple[float, float, float] | None

    def holds(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which points (n, 3) in the world are inside."""
        if self.size is None:
            return np.ones(len(points), np.bool_)
        local = (points - self.world_t_sensor[:3, 3]) @ self.world_t_sensor[:3, :3]
        return np.all(np.abs(local) <= 0.5 * np.array(self.size), axis=1)
