"""Nodes whose contacts sensors feel: of what an engine finds, the world is told what touches them, and no more."""

from __future__ import annotations

from collections.abc import Iterator

from virtualrobot_kernel.errors import UnknownNameError
from virtualrobot_kernel.world.sensing import ContactSensor, ForceTorqueSensor, MotionSensor
from virtualrobot_kernel.world.structure import Structure


def felt_nodes(structure: Structure) -> frozenset[int]:
    """Return the nodes (uids) that contact sensors watch, and those whose weight force-torque sensors may carry."""
    return frozenset(node.uid for top in _tops(structure) for node in structure.below(top))


def _tops(structure: Structure) -> Iterator[int]:
    for node in structure.nodes.values():
        if isinstance(node.data, MotionSensor) and isinstance(node.data.kind, ForceTorqueSensor):
            yield node.parent
        elif isinstance(node.data, ContactSensor):
            try:
                yield structure.node(node.data.watched).uid if node.data.watched else node.parent
            except UnknownNameError:
                continue  # the sensor itself says so
