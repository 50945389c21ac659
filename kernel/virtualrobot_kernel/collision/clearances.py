"""Least distances that people want to see, between the surfaces that can collide."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from virtualrobot_kernel.collision.pool import ScenePool
from virtualrobot_kernel.collision.scene import Nearest
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Structure


@dataclass(frozen=True, slots=True)
class Clearance:
    """A least distance that is shown.

    Attributes:
        name: unique among the clearances of a view.
        first: nodes (uids), each with all below it.
        second: the other nodes; none means all but the first ones.
    """

    name: str
    first: tuple[int, ...]
    second: tuple[int, ...] = ()


Measured = Mapping[Clearance, Nearest]
Measure = Callable[[Snapshot, tuple[Clearance, ...]], Measured]
"""Measures clearances in a snapshot; one of which there is nothing to measure is left out."""


def is_there(structure: Structure, clearance: Clearance) -> bool:
    """Return whether there is something left to measure between."""
    return any(uid in structure.nodes for uid in clearance.first) and (
        not clearance.second or any(uid in structure.nodes for uid in clearance.second)
    )


def measured(pool: ScenePool, snapshot: Snapshot, wanted: tuple[Clearance, ...]) -> Measured:
    """Return the nearest pair of nodes that may not touch for each clearance; see `CollisionScene.distances`."""
    structure, found = snapshot.structure, {}
    with pool.scene() as scene:
        scene.place(snapshot)
        for one in wanted:
            if not is_there(structure, one):
                continue
            first = _below(structure, one.first)
            second = _below(structure, one.second) if one.second else structure.nodes.keys() - first
            for nearest in scene.distances(first, second, 0.0):
                found[one] = nearest
    return found


def _below(structure: Structure, uids: tuple[int, ...]) -> set[int]:
    return {node.uid for uid in uids if uid in structure.nodes for node in structure.below(uid)}
