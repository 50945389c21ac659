"""One node of the scene: read live, changed at once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from virtualrobot._wire.arguments import PoseLike, Text, checked
from virtualrobot._wire.messages import pose_of
from virtualrobot._wire.showing import shown
from virtualrobot.geometry import Matrix
from virtualrobot.scene.figures import Figure, Figures
from virtualrobot.v1 import nodes_pb2

if TYPE_CHECKING:
    from virtualrobot.scene.scene import Scene


@shown
@dataclass(frozen=True, slots=True, eq=False)
class NodeInfo:
    """Description of a node at one instant.

    Attributes:
        name: its name, unique in the world.
        uid: its number, never used again.
        kind: such as `robot`, `link`, `tool`, `part` or `object`.
        parent: the name of the node that it is fixed to; empty where that was not asked for.
        hidden: true where it is hidden by itself.
        parent_t_node: pose in its parent's frame, 4x4.
        figures: its shapes.
        description: what it is or is for, in words.
        tags: words by which it is found.
        icon: the name of the icon that pages show for it; empty for that of its kind.
        locked: true where it can be neither changed nor removed; see `Node.lock`.
    """

    name: str
    uid: int
    kind: str
    parent: str
    hidden: bool
    parent_t_node: Matrix
    figures: tuple[Figure, ...]
    description: str
    tags: tuple[str, ...]
    icon: str
    locked: bool

    @staticmethod
    def of(message: nodes_pb2.Node) -> NodeInfo:
        """Return what a message tells."""
        return NodeInfo(
            message.name,
            message.uid,
            message.WhichOneof("kind") or "",
            message.parent,
            message.hidden,
            pose_of(message.parent_t_node),
            tuple(map(Figure, message.figures)),
            message.description,
            tuple(message.tags),
            message.icon,
            message.locked,
        )


@checked
class Node:
    """A node of the scene by its name. What it tells is read anew each time; `name`, `uid` and `kind` are kept."""

    def __init__(self, scene: Scene, message: nodes_pb2.Node) -> None:
        """Handle a node that was read; `Scene.node` and the `add_` methods make them."""
        self._scene = scene
        self.name = message.name
        self.uid = message.uid
        self.kind = message.WhichOneof("kind") or ""

    @property
    def info(self) -> NodeInfo:
        """Description of the node now."""
        return NodeInfo.of(self._message)

    @property
    def parent(self) -> str:
        """The name of the node that it is fixed to."""
        return self.info.parent

    @property
    def hidden(self) -> bool:
        """True where it is hidden by itself (its ancestors may be hidden too)."""
        return self.info.hidden

    @property
    def figures(self) -> tuple[Figure, ...]:
        """Its shapes."""
        return self.info.figures

    @property
    def _message(self) -> nodes_pb2.Node:
        return self._scene._read([self.name])[0][0]

    @property
    def pose(self) -> Matrix:
        """`world_t_node`, 4x4: its pose in the world's frame."""
        return self._scene.pose(self.name)

    @property
    def parent_t_node(self) -> Matrix:
        """Pose in its parent's frame, 4x4; setting it moves the node at once."""
        return self.info.parent_t_node

    @parent_t_node.setter
    def parent_t_node(self, parent_t_node: PoseLike) -> None:
        self._scene.set_pose(self.name, parent_t_node)

    def attach(self, parent: str = "world", pose: PoseLike | None = None) -> None:
        """Give it another parent; without `pose` (`parent_t_node`) it stays where it is in the world."""
        self._scene.attach(self.name, parent, pose)

    def rename(self, new_name: str) -> None:
        """Give it another name."""
        self._scene.rename(self.name, new_name)
        self.name = new_name

    def hide(self, hidden: bool = True) -> None:
        """Hide it and what hangs below, or show it again."""
        self._scene.hide(self.name, hidden)

    @property
    def description(self) -> str:
        """Description in words; set it, in at most 2000 characters, to say what it is or is for."""
        return self.info.description

    @description.setter
    def description(self, description: Text) -> None:
        self._scene.describe(self.name, description=description)

    @property
    def tags(self) -> tuple[str, ...]:
        """Words by which people and programs find it (`scene.nodes(tag="fixture")`); set it to others."""
        return self.info.tags

    @tags.setter
    def tags(self, tags: Iterable[str]) -> None:
        self._scene.describe(self.name, tags=tags)

    @property
    def locked(self) -> bool:
        """True where it can be neither changed nor removed."""
        return self.info.locked

    def lock(self, locked: bool = True) -> None:
        """Keep its name, parent, pose and figures as they are, and it in the world, or let go of it again.

        Whoever may change scenes may unlock it. It moves along with its parent, and joints below it move.
        """
        self._scene.lock(self.name, locked)

    def set_figures(self, figures: Figures) -> None:
        """Give it other shapes."""
        self._scene.set_figures(self.name, figures)

    def remove(self) -> None:
        """Take it and all below it out of the world."""
        self._scene.remove(self.name)

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Node {self.name!r} ({self.kind})>"
