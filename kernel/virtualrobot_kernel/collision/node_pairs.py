"""Pairs of nodes: their names, which robots can move them, and whether they move against each other."""

from __future__ import annotations

import numpy as np

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Structure

ROUNDING = 1e-9
"""Poses that differ by no more than this are the same."""


def names_of(pair: Pair, structure: Structure) -> tuple[str, str]:
    """Return the names of two nodes."""
    return structure.nodes[pair[0]].name, structure.nodes[pair[1]].name


def movers(pair: Pair, structure: Structure) -> frozenset[int]:
    """Return the robots (uids) whose joints can move one of two nodes."""
    return frozenset(node.uid for uid in pair for node in structure.ancestors(uid) if node.kind is Kind.ROBOT)


def coordinates_between(pair: Pair, structure: Structure) -> frozenset[int]:
    """Return the coordinates (places in q) of the joints that move two nodes against each other."""
    first, second = ({node.uid for node in structure.ancestors(uid)} for uid in pair)
    return frozenset(place for uid in first ^ second for place in structure.coordinates_at(structure.rows[uid]))


def moves(before: Snapshot, after: Snapshot, pair: Pair) -> bool:
    """Return whether two nodes are elsewhere, seen from each other, than they were."""
    was, now = (np.linalg.solve(world.world_t(pair[0]), world.world_t(pair[1])) for world in (before, after))
    return bool(np.abs(was - now).max() > ROUNDING)
