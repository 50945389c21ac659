"""Looks of nodes, written when these come and whenever their figures change."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable

from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp

from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot.errors import InvalidArgumentError, UnknownNameError, VirtualRobotError
from virtualrobot.files.assets import Assets
from virtualrobot.recording.entities import entity, models
from virtualrobot.v1 import nodes_pb2, scene_pb2

Write = Callable[[SceneUpdate, Timestamp], None]


class Scenery:
    """Looks of the nodes of a scene that is watched; a thread of its own asks the kernel for them."""

    def __init__(self, services: Services, write: Write) -> None:
        """Begin with no node; `write` takes what is to be written."""
        self._services, self._write = services, write
        self._looks: dict[int, bytes] = {}
        self._names: dict[int, str] = {}
        self._parents: dict[str, str] = {}
        self._with_states = False
        self._drawn: set[str] = set()
        self._asked: list[tuple[str, Timestamp]] = []
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
            look = _look(node)
            if self._looks.get(node.uid) != look or before != node.name:
                self._looks[node.uid] = look
                different.append(node.name)
            self._with_states = self._with_states or any(figure.tool_state for figure in node.figures)
        if gone:
            self._delete(gone, time)
        self._ask(different, time)

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
        wanted = set(names)
        topmost = [name for name in wanted if not wanted.intersection(self._above(name))]
        with self._changed:
            self._asked.extend((name, time) for name in topmost)
            self._changed.notify()

    def _above(self, name: str) -> Iterable[str]:
        while name := self._parents.get(name, ""):
            yield name

    def _run(self) -> None:
        while True:
            with self._changed:
                self._busy = False
                while not (self._asked or self._closed):
                    self._changed.wait()
                if self._closed:
                    return
                self._busy = True
                name, time = self._asked.pop(0)
            try:
                self._draw(name, time)
            except UnknownNameError:
                continue  # it is gone since
            except VirtualRobotError:
                return  # the kernel has ended, which the watches tell, too

    def _draw(self, root: str, time: Timestamp) -> None:
        request = scene_pb2.ExportModelRequest(node=root, format=".glb")
        try:
            response = self._services.scene.ExportModel(request, timeout=LONG_TIMEOUT_SECONDS)
            drawn = dict(models(Assets(self._services).download(response.files[0].sha256)))
        except InvalidArgumentError:
            drawn = {}  # nothing is to be seen there
        below = {name for name in self._drawn if name == root or root in self._above(name)}
        if missing := below - drawn.keys():
            self._delete(missing, time)
        if drawn:
            self._drawn |= drawn.keys()
            update = SceneUpdate(entities=[entity(name, model, time) for name, model in drawn.items()])
            self._write(update, time)

    def _delete(self, names: Iterable[str], time: Timestamp) -> None:
        gone = self._drawn.intersection(names)
        self._drawn -= gone
        if gone:
            self._write(SceneUpdate(deletions=[SceneEntityDeletion(timestamp=time, id=name) for name in gone]), time)


def _look(node: nodes_pb2.Node) -> bytes:
    return nodes_pb2.Node(hidden=node.hidden, figures=node.figures).SerializeToString()
