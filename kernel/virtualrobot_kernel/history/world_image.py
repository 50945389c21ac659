"""Image of a whole world as a checkpoint has it: its nodes and its state, from which all else follows."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Node, Structure


@dataclass(frozen=True, slots=True, eq=False)
class WorldImage:
    """World at a tick: its nodes in the order of their rows, the uid of the next one, its revision, and its state."""

    nodes: tuple[Node, ...]
    next_uid: int
    revision: int
    state: State

    @property
    def structure(self) -> Structure:
        """Return the structure, indexed anew."""
        return index.build({node.uid: node for node in self.nodes}, self.next_uid, self.revision)


def image_of(structure: Structure, state: State) -> WorldImage:
    """Return the image of a world."""
    return WorldImage(tuple(structure.nodes.values()), structure.next_uid, structure.revision, state)
