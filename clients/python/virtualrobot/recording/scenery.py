"""Looks of nodes, written when these come and whenever their figures change.

Each message holds all that its topic has, so that a reader that begins anywhere in a file sees all by the last message
of each. There are two topics: most looks are there from the begin, are large and stay; what comes or changes later is
written to the other one, again and again.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable

from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp

from virtualrobot._wire.services import Services
from virtualrobot.errors import ClientClosedError, KernelGoneError, VirtualRobotError
from virtualrobot.files.assets import Assets
from virtualrobot.recording import topics
from virtualrobot.recording.entities import entity, models
from virtualrobot.recording.looks import above, exported, look_of, topmost
from virtualrobot.v1 import scene_pb2

Write = Callable[[str, SceneUpdate, Timestamp], None]
"""Writes a message to a topic."""


class Scenery:
    """Looks of the nodes of a scene that is watched; a thread of its own asks the kernel for them.

    Attributes:
        notes: the nodes whose looks the kernel could not tell, and why.
    """

    def __init__(self, services: Services, write: Write) -> None:
        """Begin with no node; `write` takes what is to be written."""
        self.notes: list[str] = []
        self._services, self._write = services, write
        self._looks: dict[int, bytes] = {}
        self._names: dict[int, str] = {}
        self._parents: dict[str, str] = {}
        self._with_states = False
        self._models: dict[str, bytes] = {}
        self._first: set[str] | None = None
        self._asked: list[tuple[list[str], Timestamp]] = []
        self._changed = threading.Condition()
        self._busy = self._closed = False
        self._thread = threading.Thread(target=self._run, name="scenery", daemon=True)
        self._thread.start()

    def update(self, change: scene_pb2.WatchSceneResponse, time: Timestamp) -> None:
        """Take a change of the scene; what looks different now is asked for."""
        gone = [self._names.pop(uid) for uid in change.removed_uids if uid in self._names]
        different: list[str] = []
        for node in change.nodes:
            if (before := self._names.get(node.uid, node.name)) != node.name:
                gone.append(before)
            self._names[node.uid], self._parents[node.name] = node.name, node.parent
            look = look_of(node)
            if self._looks.get(node.uid) != look or before != node.name:
                self._looks[node.uid] = look
                different.append(node.name)
            self._with_states = self._with_states or any(figure.tool_state for figure in node.figures)
        self._ask([*gone, *different], time)

    def tools_changed(self, tools: Iterable[str], time: Timestamp) -> None:
        """Ask for the looks of tools that are in another state, if anything looks different by that."""
        if self._with_states:
            self._ask(tools, time)

    @property
    def idle(self) -> bool:
        """True where all that was asked for is written."""
        with self._changed:
            return not (self._asked or self._busy) or not self._thread.is_alive()

    def close(self) -> None:
        """Ask for nothing more."""
        with self._changed:
            self._closed = True
            self._changed.notify()

    def _ask(self, names: Iterable[str], time: Timestamp) -> None:
        """Ask for nodes with all below them, each once."""
        if roots := topmost(list(names), self._parents):
            with self._changed:
                self._asked.append((roots, time))
                self._changed.notify()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._busy = False
                while not (self._asked or self._closed):
                    self._changed.wait()
                if self._closed:
                    return
                self._busy = True
                roots, time = self._asked.pop(0)
            try:
                self._draw(roots, time)
            except (KernelGoneError, ClientClosedError):
                return  # the watches tell that, too
            except VirtualRobotError as error:
                self.notes.append(f"looks of {', '.join(roots)} and what is below: {error}")

    def _draw(self, roots: list[str], time: Timestamp) -> None:
        """Ask for nodes and what is below them, and write what looks different; a node that is gone has no looks."""
        below = {name for name in self._models if not {name, *above(name, self._parents)}.isdisjoint(roots)}
        before = {name: self._models[name] for name in below}
        now = {name: model for root in roots for name, model in self._exported(root).items()}
        different = {name for name in before.keys() | now.keys() if before.get(name) != now.get(name)}
        for name in before.keys() - now.keys():
            del self._models[name]
        self._models.update(now)
        if self._first is None:
            self._first = set(self._models)
            self._write_all(topics.SCENE, self._first, time)
            return
        if changed := self._first & different:
            self._first -= changed
            self._write_all(topics.SCENE, self._first, time)
        if different:
            self._write_all(topics.LATER_SCENE, self._models.keys() - self._first, time)

    def _exported(self, root: str) -> dict[str, bytes]:
        """Return the models of a node and of what is below it, by name."""
        sha256 = exported(self._services, root)
        return {} if sha256 is None else dict(models(Assets(self._services).download(sha256)))

    def _write_all(self, topic: str, names: Iterable[str], time: Timestamp) -> None:
        """Write all of a topic in place of what it had."""
        update = SceneUpdate(
            deletions=[SceneEntityDeletion(timestamp=time, type=SceneEntityDeletion.ALL)],
            entities=[entity(name, self._models[name], time) for name in sorted(names)],
        )
        self._write(topic, update, time)
