"""Preparation of what a guard will need, before its world thread does: a mesh of a million triangles takes seconds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import Command, CreateNodes, SetCollisionSettings, UpdateNode
from virtualrobot_kernel.world.figures import Figure
from virtualrobot_kernel.world.history_commands import RestoreRecords, RestoreWorld
from virtualrobot_kernel.world.state import Snapshot


def is_to_be_ready(snapshot: Snapshot, commands: Sequence[Command]) -> bool:
    """Return whether commands bring figures to a guard, or a guard to figures."""
    if any(CollisionMode.GUARD in _modes(command) for command in commands):
        return True
    now = snapshot.state.collisions
    guarded = CollisionMode.GUARD in (now.mode, *now.modes.values())
    return guarded and any(isinstance(command, CreateNodes | UpdateNode | RestoreRecords) for command in commands)


def _modes(command: Command) -> Iterator[CollisionMode | None]:
    """Yield the modes of collision handling that a command sets."""
    if isinstance(command, SetCollisionSettings):
        yield from (command.mode, *(mode for _, mode in command.modes))
    elif isinstance(command, RestoreRecords):
        yield from command.restored.modes.values()
    elif isinstance(command, RestoreWorld):
        yield from (command.state.collisions.mode, *command.state.collisions.modes.values())


def make_ready(shapes: CollisionShapes, snapshot: Snapshot, commands: Sequence[Command]) -> None:
    """Make what figures of a world and of commands collide as, so that the world thread finds it made."""
    for figure in _figures(snapshot, commands):
        if figure.collision and (solid := shapes.get(figure.geometry)):
            _ = solid.tree


def _figures(snapshot: Snapshot, commands: Sequence[Command]) -> Iterator[Figure]:
    for node in snapshot.structure.nodes.values():
        yield from node.figures
    for command in commands:
        if isinstance(command, CreateNodes):
            yield from (figure for spec in command.specs for figure in spec.figures)
        elif isinstance(command, UpdateNode):
            yield from command.figures or ()
        elif isinstance(command, RestoreRecords):
            for figures in command.restored.figures.values():
                yield from figures
            for one in command.restored.nodes.values():
                yield from one.node.figures if one is not None else ()
        elif isinstance(command, RestoreWorld):
            for node in command.nodes:
                yield from node.figures
