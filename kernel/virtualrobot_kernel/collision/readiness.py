"""Preparation of what a guard will need, before its world thread does: a mesh of a million triangles takes seconds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import Command, CreateNodes, SetCollisionSettings, UpdateNode
from virtualrobot_kernel.world.figures import Figure
from virtualrobot_kernel.world.state import Snapshot


def is_to_be_ready(snapshot: Snapshot, commands: Sequence[Command]) -> bool:
    """Return whether commands bring figures to a guard, or a guard to figures."""
    settings = [command for command in commands if isinstance(command, SetCollisionSettings)]
    if any(CollisionMode.GUARD in (one.mode, *(mode for _, mode in one.modes)) for one in settings):
        return True
    now = snapshot.state.collisions
    guarded = CollisionMode.GUARD in (now.mode, *now.modes.values())
    return guarded and any(isinstance(command, CreateNodes | UpdateNode) for command in commands)


def make_ready(shapes: CollisionShapes, snapshot: Snapshot, commands: Sequence[Command]) -> None:
    """Make what figures of a world and of commands collide as, so that the world thread finds it made."""
    for figure in _figures(snapshot, commands):
        if figure.collision:
            shapes.get(figure.geometry)


def _figures(snapshot: Snapshot, commands: Sequence[Command]) -> Iterator[Figure]:
    for node in snapshot.structure.nodes.values():
        yield from node.figures
    for command in commands:
        if isinstance(command, CreateNodes):
            yield from (figure for spec in command.specs for figure in spec.figures)
        elif isinstance(command, UpdateNode):
            yield from command.figures or ()
